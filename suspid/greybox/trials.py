"""Records as data of a grey-box fit: what each channel measures, and which motions and forces are known causes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from suspid.cleaning import is_pair
from suspid.errors import InputError, RecordError
from suspid.greybox.car_records import example, force_names, record_of_car, renaming
from suspid.greybox.dynamics import DEGREE
from suspid.greybox.record_test import RecordTest
from suspid.greybox.wheels import wheels_of
from suspid.identification import WhiteNoise, resolution
from suspid.io import bare_name
from suspid.model import FORCE, Suspension, force_weights, output_weights
from suspid.signals import Signal, as_signal
from suspid.units import RealArray, Second
from suspid.values import frozen_real, likely_names, listed, nearest_names
from suspid.wording import Argument, AtCommandLine

if TYPE_CHECKING:
    import control

# How an input moves between two samples: as the last one, on a straight line, on a cubic spline, on one of the fifth
# degree. The latter follows motion of a fifth of the rate to 1e-4, the cubic one to 7e-3.
Hold = Literal["zero", "linear", "cubic", "quintic"]
HOLDS: tuple[Hold, ...] = ("cubic", "quintic", "linear", "zero")
SPLINES: Mapping[Hold, int] = {"cubic": 3, "quintic": 5}


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Trial:
    """A test as numbers."""

    start: Second
    step: Second
    values: RealArray  # (channel, sample)
    channels: tuple[str, ...]
    orders: NDArray[np.intp]  # (channel,): derivative that is measured
    weights: RealArray  # (channel, coordinate)
    road_weights: RealArray  # (channel, road)
    added: RealArray  # (coordinate,): masses
    roads: tuple[int, ...]  # roads that are inputs, in the order of the suspension's
    forces: RealArray  # (force, coordinate): weights of the forces that are inputs
    wheels: tuple[int, ...]  # coordinates whose measured motion is the cause
    inputs: RealArray  # (input, sample): roads, then forces
    noise: WhiteNoise  # of the channels
    unused: tuple[str, ...]  # channels that measure nothing of the suspension
    logger: str | None = None
    causes: tuple[str, ...] = ()  # names of the inputs, or of the channels that show given motion alone
    margin: int = 0  # samples by which the inputs begin before the channels, and end behind them
    sensed_roads: tuple[int, ...] = ()  # roads that channels measure, with noise, and that are the cause
    sensed_forces: int = 0  # of `forces`, those that the last channels measure with noise
    uncut: RealArray | None = None  # the channels beside all of the inputs, where these begin before

    @property
    def known(self) -> dict[str, RealArray]:
        """The inputs by name."""
        return dict(zip(self.causes, self.inputs_beside, strict=False))

    @property
    def inputs_beside(self) -> RealArray:
        """The inputs at the samples of the channels."""
        return self.inputs[:, self.margin : self.margin + self.count]

    @property
    def count(self) -> int:
        """Samples per channel."""
        return int(self.values.shape[1])

    def first(self, count: int) -> Trial:
        """Return the first samples alone."""
        values, inputs = self.values[:, :count], self.inputs[:, : count + 2 * self.margin]
        return replace(self, values=values, inputs=inputs, uncut=None)

    def within(self, margin: int) -> Trial:
        """Return the channels without some samples at both ends, where the inputs stay."""
        if not margin:
            return self
        values, start = self.values[:, margin : self.count - margin], self.start + margin * self.step
        return replace(self, values=values, uncut=self.values, margin=margin, start=start)

    def with_noisy_inputs(self) -> Trial:
        """Return the trial with its inputs as channels of unknown noise."""
        shown = self.values if self.uncut is None else self.uncut
        roads, forces, width = len(self.roads), len(self.forces), self.road_weights.shape[1]
        on_road = np.eye(width)[list(self.roads)]
        return replace(
            self.whole,
            values=frozen_real(np.concatenate([shown, self.inputs])),
            channels=(*self.channels, *self.causes[: len(self.inputs)]),
            orders=np.append(self.orders, np.zeros(roads + forces, int)),
            weights=frozen_real(np.concatenate([self.weights, np.zeros((roads + forces, self.weights.shape[1]))])),
            road_weights=frozen_real(np.concatenate([self.road_weights, on_road, np.zeros((forces, width))])),
            roads=(),
            inputs=frozen_real(np.zeros((0, shown.shape[1]))),
            noise=WhiteNoise(
                least=frozen_real(np.append(self.noise.least, np.maximum(resolution(self.inputs) ** 2, 1e-300)))
            ),
            sensed_roads=self.roads,
            sensed_forces=forces,
        )

    @property
    def whole(self) -> Trial:
        """The trial with the channels beside all of the inputs."""
        if self.uncut is None:
            return self
        start = self.start - self.margin * self.step
        return replace(self, values=self.uncut, uncut=None, margin=0, start=start)


def trials_of(records: object, suspension: Suspension, given: Sequence[str]) -> tuple[Trial, ...]:
    """Return records as data, checked against the suspension."""
    if isinstance(given, str):
        raise InputError(Argument("given", repr(given)), f" is one string; give a sequence of names: [{given!r}]")
    return tuple(_trial(one, suspension, given) for one in records_of(records))


def records_of(records: object) -> list[object]:
    """Return one record or several as a list.

    Raises
    ------
    InputError
        If there is none.
    """
    single = isinstance(records, RecordTest) or hasattr(records, "output_labels") or is_pair(records)
    every = [records] if single else list(records) if isinstance(records, Sequence) else [records]
    if not every:
        raise InputError("there is no record; give a control.TimeResponseData, or a sequence of them")
    return every


def _trial(one: object, car: Suspension, given: Sequence[str]) -> Trial:
    test = one if isinstance(one, RecordTest) else RecordTest(record=one)
    record = record_of_car(test.record, car)
    signal, causes = as_signal(record, least=8), _inputs(record)
    names = given_names(given if test.given is None else test.given, car)
    for name in test.added_masses:
        if name not in car.coordinates:
            raise InputError(Argument("added_masses"), f": there is no mass {name!r}.{nearest_names(name, car.masses)}")
    roads = [name for name in car.roads if name in names]
    wheels = [i for i, name in enumerate(car.coordinates) if name in names]
    forces = [name for name in names if name not in {*roads, *car.coordinates}]
    pushes = [_force(car, name, (*causes, *signal.channels)) for name in forces]
    known = {**causes, **dict(zip(signal.channels, signal.values, strict=True))}
    for name in (*roads, *forces):
        if name not in known:
            raise InputError(
                Argument("given"),
                f": the record has no input or channel {name!r}; its inputs are {listed(list(causes)) or 'none'}, "
                f"its channels {listed(signal.channels)}",
            )
    taken = {*roads, *forces}
    rows, unused = [], []
    for channel in signal.channels:
        if channel in taken:
            continue
        try:
            rows.append((channel, *output_weights(car, channel)))
        except InputError:
            unused.append(channel)
    # Nothing in the model moves a road that is not given: beside the motion of wheels it is neither cause nor output.
    still = [i for i, road in enumerate(car.roads) if road not in roads]
    use = [row for row in rows if not wheels or not np.any(row[3][still])]
    if not use:
        raise RecordError(
            f"no channel of the record measures the suspension: {listed(signal.channels)}; name channels by what they "
            f"measure, such as {car.coordinates[0]!r} or '{car.coordinates[0]}_acceleration', or describe them under "
            f"[sensors] in the car file, as in "
            f'\'"{signal.channels[0]}" = {{ acceleration = "{car.coordinates[0]}" }}\'',
            AtCommandLine("rename", example(signal.channels, car.coordinates)),
        )
    unused += [row[0] for row in rows if wheels and np.any(row[3][still])]
    channels = tuple(row[0] for row in use)
    free = [i for i in range(len(car.coordinates)) if i not in wheels]
    caused = tuple(row[0] for row in use if wheels and not np.any(row[2][free]))
    values = np.array([known[name] for name in channels])
    return Trial(
        start=signal.start,
        step=signal.step,
        values=frozen_real(values),
        channels=channels,
        orders=np.array([row[1] for row in use], int),
        weights=frozen_real([row[2] for row in use]),
        road_weights=frozen_real(np.array([row[3] for row in use]).reshape(len(use), len(car.roads))),
        added=frozen_real([test.added_masses.get(c, 0.0) for c in car.coordinates]),
        roads=tuple(car.roads.index(road) for road in roads),
        forces=frozen_real(np.array(pushes).reshape(len(pushes), len(car.coordinates))),
        wheels=tuple(wheels),
        inputs=frozen_real(np.array([known[name] for name in (*roads, *forces)]).reshape(-1, values.shape[1])),
        noise=WhiteNoise(least=frozen_real(np.maximum(resolution(values) ** 2, 1e-300))),
        unused=tuple(unused),
        logger=test.logger,
        causes=(*roads, *forces, *caused),
    )


def given_names(given: Sequence[str], car: Suspension) -> tuple[str, ...]:
    """Return the causes that are named; ``"wheels"`` and ``"roads"`` are all of them, if nothing else has that name.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> given_names(["wheels"], car), given_names(["road"], car)
    (('tire',), ('road',))
    """
    known = {*car.coordinates, *car.roads}
    groups = {"wheel": wheels_of(car), "wheels": wheels_of(car), "road": car.roads, "roads": car.roads}
    every = [one for name in given for one in ((name,) if name in known else groups.get(name) or (name,))]
    return tuple(dict.fromkeys(every))


def _inputs(record: control.TimeResponseData) -> dict[str, RealArray]:
    """Return the inputs of a response by name."""
    samples, labels = getattr(record, "inputs", None), getattr(record, "input_labels", None)
    if samples is None:
        return {}
    table = np.asarray(samples, float)
    table = table.reshape(-1, table.shape[-1])
    names = list(labels) if labels else [f"u[{i}]" for i in range(len(table))]
    return dict(zip(names, table, strict=True))


def _force(car: Suspension, name: str, channels: Sequence[str]) -> RealArray:
    """Return the weights of a force on each coordinate."""
    try:
        return force_weights(car, name)
    except InputError:
        on_mass, in_strut = force_names(car)
        own = [channel for channel in channels if name in (channel, bare_name(channel))]
        how = f"{AtCommandLine('rename', renaming(own[0], on_mass))}." if own else "."
        causes = [*car.roads, *car.coordinates, *(f"{c}{FORCE}" for c in car.coordinates)]
        meant = "" if own else likely_names(name, causes)
        raise InputError(
            Argument("given"),
            f": {name!r} is no road ({listed(car.roads) or 'there is none'}), no coordinate "
            f"({listed(car.coordinates)}), none of 'roads' and 'wheels', and no force; a force is named by what it "
            f"pushes: {on_mass!r} one mass, {in_strut!r} the ends of a strut apart{how}{meant}",
        ) from None


def input_pieces(trial: Trial, hold: Hold) -> tuple[RealArray, RealArray]:
    """Return the inputs between samples: their coefficients (sample, coefficient), and jumps at the next sample.

    An input that is held steps at the samples: the jumps (sample, input) are those at the end of each step.
    """
    count, size = trial.count + 2 * trial.margin, len(trial.inputs)
    pieces, jumps = np.zeros((count, size, DEGREE)), np.zeros((count, size))
    u, h = trial.inputs.T, trial.step
    pieces[:, :, 0] = u
    degree = SPLINES.get(hold, 0)
    if size and count > degree > 0:
        from scipy.interpolate import make_interp_spline

        spline, times = make_interp_spline(h * np.arange(count), u, degree), h * np.arange(count)
        for order in range(1, degree + 1):
            pieces[:, :, order] = spline(times, order)
    elif size and hold != "zero":
        pieces[:-1, :, 1] = np.diff(u, axis=0) / h
        pieces[-1, :, 1] = pieces[-2, :, 1]
    elif size:
        jumps[:-1] = np.diff(u, axis=0)
    return pieces.reshape(count, DEGREE * size), jumps


def signal_of(trial: Trial) -> Signal:
    """Return the channels that are used as a signal."""
    return Signal(start=trial.start, step=trial.step, values=trial.values, channels=trial.channels)
