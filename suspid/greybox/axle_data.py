"""Two axles on one track: what their wheels measured, as the slope of the road under each, at one place.

The motion of the wheels gives the road under each of them (`road_maps`). At time t the rear wheel stands where the
front wheel stood at t', with ``x(t') = x(t) - lag`` and x the distance from the speed. So the front's slope per metre
is taken at t': whatever the speed does, both are then one road, and noise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from suspid.errors import InputError
from suspid.greybox.measured_causes import WheelProblem
from suspid.greybox.noise_levels import Levels, covariance_of
from suspid.greybox.road_maps import MapProblem
from suspid.greybox.transfers import transfer
from suspid.greybox.trials import Trial
from suspid.greybox.wheel_power import TAPER_BANDWIDTH, TAPERS
from suspid.model import Suspension
from suspid.units import ComplexArray, Hertz, Metre, RealArray, Second
from suspid.values import likely_names, listed
from suspid.wording import Argument

LOWEST_SLOPE: Hertz = 0.3  # below it, accelerations say nothing of roads
ROLL_OFF = 1.15  # highest frequency of the slopes over that of the band: what is cut off must not reach into it
SHOWN_ENDS: Second = 3.0  # of a record, where its ends show in the slopes
FADE: Second = 1.0  # over which a record is faded in and out
FINER = 2  # samples of the slope of the front between two of the record, for splines through them
STANDING = 0.25  # of the median speed: slower stretches are left out, as their delay is long and uncertain


Led: TypeAlias = Mapping[str, tuple[str, Metre]]  # by road the one that it follows, and how far behind


class Behind(NamedTuple):
    """Which road another meets later."""

    rear: int
    front: int
    lag: Metre
    wheels: tuple[int, int]  # coordinates on the front and the rear one


class Lag(NamedTuple):
    """How much later a wheel meets the road of another: the way between them, and a time besides.

    Loggers smooth the speed, so that it swings less than the car. Then the time of a way is off by what a longer way
    and a delay make together.
    """

    way: Metre
    time: Second = 0.0

    def delays(self, log_speed: RealArray) -> RealArray:
        """Return the delays [s] at given speeds, by their logarithms."""
        return np.asarray(self.way * np.exp(-log_speed) + self.time)


def behind_of(behind: Led | None, car: Suspension) -> tuple[Behind, ...]:
    """Return which roads of a car follow which.

    Raises
    ------
    InputError
        If the names are not all roads of the car, each once, a distance is not positive, or a road does not carry one
        wheel.
    """
    if not behind:
        return ()
    roads, pairs = list(car.roads), [_pair(rear, led) for rear, led in behind.items()]
    named = [road for rear, front, _ in pairs for road in (rear, front)]
    for road in named:
        if road not in roads:
            raise InputError(
                Argument("behind"),
                f": the car has no road {road!r}; it has {listed(roads)}.{likely_names(str(road), roads)}",
            )
    odd = [f"{road!r} {named.count(road)} times" for road in roads if named.count(road) != 1]
    if odd:
        raise InputError(
            Argument("behind"),
            f" must name every road of the car once, as one that follows or one that leads; it names {', '.join(odd)}",
        )
    arms, on_roads = car.arms(car.coordinates), car.arms(car.roads)
    on = [np.flatnonzero(np.any(arms[on_roads[:, i] != 0] != 0, axis=0)).tolist() for i in range(len(roads))]
    if any(len(some) != 1 for some in on):
        stand = [car.coordinates[i] for i in sorted(place for some in on for place in some)]
        raise InputError(Argument("behind"), f": one wheel must stand on each road; here {listed(stand)} stand on them")
    places = {road: some[0] for road, some in zip(roads, on, strict=True)}
    return tuple(
        Behind(rear=roads.index(rear), front=roads.index(front), lag=lag, wheels=(places[front], places[rear]))
        for rear, front, lag in pairs
    )


def _pair(rear: str, led: Any) -> tuple[str, str, Metre]:
    """Return a road, the one that it follows, and how far behind; refuse what is not that."""
    if not isinstance(led, tuple | list) or len(led) != 2:
        wrong, fits = repr(led), False
    else:
        wrong, fits = repr(led[1]), isinstance(led[1], int | float) and 0 < led[1] < np.inf
    if not fits:
        raise InputError(
            Argument("behind"),
            f": {rear!r} needs the road that it follows and the distance, a positive number [m], not {wrong}",
        )
    front, lag = led
    return rear, front, float(lag)


def check_rolled(pairs: Sequence[Behind], car: Suspension, trials: Sequence[Trial], speed: object) -> None:
    """Refuse pairs of roads where the speed is unknown, or the motion of a wheel is not given.

    Raises
    ------
    InputError
        Saying which.
    """
    if pairs and speed is None:
        raise InputError(
            Argument("behind"), " needs the speed, from which the delay follows; give ", Argument("speed"), " too"
        )
    for wheel in (wheel for pair in pairs for wheel in pair.wheels):
        if any(wheel not in trial.wheels for trial in trials):
            raise InputError(
                Argument("behind"),
                f": the motion of every wheel on a road must be given; that of {car.coordinates[wheel]!r} is not",
            )


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class AxleRecord:
    """The spectrum of a whole record, and where its stretches lie."""

    s: ComplexArray  # (line,): of the whole record
    causes: ComplexArray  # (line, cause)
    outputs: ComplexArray  # (line, output)
    weigh: ComplexArray  # (line, cause, output): of the residual of outputs, in the best estimate of causes
    edge: RealArray  # (line,): fades the slopes out at the ends of the band
    first: int  # line of the first
    count: int  # samples
    step: Second
    speed: RealArray  # (sample,)
    distance: RealArray  # (sample,)
    starts: tuple[int, ...]  # first sample of each stretch

    def slopes(self, maps: MapProblem, z: RealArray, x: RealArray, lag: Lag) -> RealArray:
        """Return the slopes of the first two roads of ``maps`` at the place of the second one, (2, sample)."""
        from scipy.interpolate import CubicSpline

        made = maps.maps(self.s, z, x)
        residual = self.outputs - np.einsum("lab,lb->la", made.outputs, self.causes)
        motion = self.causes + np.einsum("lab,lb->la", self.weigh, residual)
        rates = np.einsum("lab,lb->la", made.roads[:, :2], motion) * (self.s * self.edge)[:, None]
        whole = np.zeros((2, FINER * self.count // 2 + 1), complex)
        whole[:, self.first : self.first + len(self.s)] = FINER * rates.T
        front, rear = np.fft.irfft(whole, FINER * self.count, axis=1)
        times = self.step * np.arange(self.count)
        before = np.interp(self.distance - lag.way, self.distance, times) - lag.time
        there = CubicSpline(self.step / FINER * np.arange(len(front)), front)(before)
        return np.stack([there / np.interp(before, times, self.speed), rear[::FINER] / self.speed])


def axle_record(
    problem: WheelProblem,
    z: RealArray,
    number: int,
    levels: Levels,
    trial: Trial,
    *,
    speed: RealArray,
    band: tuple[Hertz, Hertz],
    slowest: float,
) -> AxleRecord:
    """Return the spectrum of one record, at the unknowns z of the suspension."""
    from scipy.signal.windows import tukey

    samples, step, layout = problem.sources[number].spectra.samples, trial.step, problem.sources[number].layout
    fade = tukey(trial.count, min(1.0, 2 * FADE / (trial.count * step)))
    centred = trial.values - trial.values.mean(axis=1, keepdims=True)
    spectrum, hertz = np.fft.rfft(centred * fade, axis=1), np.fft.rfftfreq(trial.count, step)
    highest = min(ROLL_OFF * band[1], 0.45 / step)  # below half the rate, where filters of loggers act
    first, last = np.searchsorted(hertz, [LOWEST_SLOPE, highest])
    inside = hertz[first:last]
    s = np.asarray(2j * np.pi * inside, complex)
    shape = np.minimum((inside - LOWEST_SLOPE) / (band[0] - LOWEST_SLOPE), (highest - inside) / (highest - band[1]))
    edge = np.ones_like(inside) if band[0] <= LOWEST_SLOPE else np.sin(np.pi / 2 * np.clip(shape, 0, 1)) ** 2
    skip = round(SHOWN_ENDS / step)
    starts = range(skip, trial.count - skip - samples + 1, samples)
    return AxleRecord(
        s=s,
        causes=spectrum[list(layout.causes), first:last].T,
        outputs=spectrum[list(layout.outputs), first:last].T,
        weigh=best_motion(problem, z, number, levels, s)[0],
        edge=edge,
        first=int(first),
        count=trial.count,
        step=step,
        speed=speed,
        distance=np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2)]) * step,
        starts=tuple(i for i in starts if np.min(speed[i : i + samples]) > slowest),
    )


def best_motion(
    problem: WheelProblem, z: RealArray, number: int, levels: Levels, s: ComplexArray
) -> tuple[ComplexArray, ComplexArray]:
    """Return the weights of the residual in the best estimate of the causes, and the covariance of its noise."""
    source = problem.sources[number]
    made = transfer(
        source.layout, s, problem.physics(z, number), problem.unknowns.rows,
        mounts=problem.extras.mounts, gains=source.gains, delays=source.delays,
    )  # fmt: skip
    seen, causes = levels.spectra(source.basis)
    at = np.log(s.imag / (2 * np.pi))
    outputs = np.exp([np.interp(at, np.log(source.spectra.hertz), row) for row in np.log(seen).T]).T
    weigh = made.T.conj().swapaxes(1, 2) * causes[:, None] @ np.linalg.inv(covariance_of(made.T, outputs, causes))
    return weigh, np.diag(causes) - weigh @ made.T * causes


def cross_power(
    records: Sequence[RealArray], starts: Sequence[Sequence[int]], samples: int, lines: NDArray[np.intp]
) -> ComplexArray:
    """Return the multitaper estimate of the spectral matrix of two rows in each stretch, (stretch, line, 2, 2)."""
    from scipy.signal.windows import dpss

    cut = np.concatenate(
        [np.stack([rows[:, i : i + samples] for i in own]) for rows, own in zip(records, starts, strict=True) if own]
    )
    made = np.zeros((len(cut), len(lines), 2, 2), complex)
    for taper in dpss(samples, TAPER_BANDWIDTH, TAPERS):
        shown = np.fft.rfft(cut * taper, axis=2)[:, :, lines].swapaxes(1, 2)
        made += shown[..., :, None] * shown[..., None, :].conj() / TAPERS
    return made
