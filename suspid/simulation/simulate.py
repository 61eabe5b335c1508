"""Response of a model to roads and forces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from suspid.arguments import explained
from suspid.errors import InputError, RecordError
from suspid.model import FORCE, Suspension, statespace
from suspid.records import as_response
from suspid.signals import uniform_step
from suspid.simulation.free_decay import check_continuous, state_of
from suspid.simulation.piecewise import Driving, machine_of, state_labels
from suspid.simulation.recursion import DEGREES, Interpolation, derivatives, driven_states, suited
from suspid.simulation.stepping import motion, observed
from suspid.units import RealArray
from suspid.values import nearest_names

if TYPE_CHECKING:
    import control

RATE = "_rate"


@explained
def simulate(
    system: control.StateSpace | Suspension,
    timepts: ArrayLike,
    inputs: Mapping[str, ArrayLike],
    *,
    outputs: Sequence[str] | None = None,
    initial_state: Mapping[str, float] | ArrayLike | None = None,
    interpolation: Interpolation | None = None,
) -> control.TimeResponseData:
    """Return the response to roads and forces, exact for inputs that are polynomials between the samples.

    It is what `control.forced_response` computes, without a loop over the samples, and it knows that a road and its
    rate are one motion. A suspension with friction or curves is linear between the points of its curves, and stepped
    exactly from one to the next; friction holds a damper up to a creep of 1e-9 m/s.

    Parameters
    ----------
    system : control.StateSpace or Suspension
        The model.
    timepts : array_like (sample,)
        Uniform times [s], at least two.
    inputs : mapping of str to array_like (sample,)
        Samples of roads [m] and forces [N] by the label of the input, such as ``"road"`` or ``"seat_travel_force"``;
        inputs that are not named are zero. A ``road_rate`` that is not given is the rate of ``road`` as interpolated.
    outputs : sequence of str, optional
        What to record, if the model is a suspension, as in `statespace`.
    initial_state : mapping of str to float, or array_like (state,), optional
        State at the first time, by label or as a vector. Default: zero, at rest where all coordinates are zero.
    interpolation : {"linear", "cubic"}, optional
        How inputs move between samples: straight as in python-control, or on a cubic spline, which is far nearer to a
        smooth motion (its error falls with the fourth power of the step instead of the second) but overshoots at steps.
        Default: straight where an input stands still at most samples, as before and after a step, else on a spline.
        Where straight lines meet, accelerations of wheels jump. No filter removes what lies above half the sampling
        rate of a record at the same samples; it folds into the band in step with the motion, and `estimate` takes it
        for a delay, a mount and less damping: records to identify from need "cubic".

    Returns
    -------
    control.TimeResponseData
        Outputs (channel, sample) and the inputs that were given, labelled.

    Raises
    ------
    InputError
        If an input is unknown, of another length than the times or not finite, if a rate is given without its road,
        if the system is sampled, or if an unstable response exceeds the floating-point range.
    RecordError
        If the times are not uniform.

    Examples
    --------
    A quarter car over a step of 5 cm settles 5 cm higher:

    >>> import numpy as np
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> t = np.arange(0, 10, 0.01)
    >>> record = simulate(car, t, {"road": np.where(t < 1, 0.0, 0.05)})
    >>> record.output_labels, record.input_labels, record.y[:, -1].round(6)
    (['chassis', 'tire'], ['road'], array([0.05, 0.05]))
    """
    if not isinstance(inputs, Mapping):
        raise InputError(f"inputs must map names of inputs to samples, such as {{'road': heights}}, not {type(inputs)}")
    if isinstance(system, Suspension) and not system.linear:
        return _simulate_pieces(system, timepts, inputs, outputs, initial_state, interpolation)
    if isinstance(system, Suspension):
        forces = [name for name in inputs if name.endswith(FORCE) and name not in system.roads]
        system = statespace(system, outputs=outputs, forces=forces, roads=system.roads)
    elif outputs is not None:
        raise InputError("outputs are chosen for a suspension; a StateSpace has its own: statespace(car, outputs=…)")
    check_continuous(system, "simulate")
    time = _times(timepts, interpolation)
    step, names = uniform_step(time), list(inputs)
    samples = _samples(inputs, system.input_labels, time.size)
    interpolation = interpolation or suited(samples)
    start = np.zeros(system.nstates) if initial_state is None else state_of(system.state_labels, initial_state)
    pieces = derivatives(samples, step, interpolation)
    B, D = (_by_derivative(np.asarray(matrix, float), system.input_labels, names) for matrix in (system.B, system.D))
    with np.errstate(over="ignore", invalid="ignore"):
        states = driven_states(np.asarray(system.A, float), B, pieces, start, step)
        values = np.asarray(system.C, float) @ states + sum(d @ piece for d, piece in zip(D, pieces, strict=False))
    beyond = np.flatnonzero(~np.all(np.isfinite(values), axis=0))
    if beyond.size:
        raise InputError(
            f"the system is unstable: its response exceeds the largest float before t = {time[beyond[0]]:g} s; "
            f"end the record earlier"
        )
    return as_response(
        time, values, system.output_labels, title="Driven", inputs=dict(zip(names, samples, strict=True))
    )


def _times(timepts: ArrayLike, interpolation: Interpolation | None) -> RealArray:
    """Return the times; refuse them, and an unknown interpolation."""
    if interpolation is not None and interpolation not in DEGREES:
        raise InputError(f"{interpolation=} is unknown; it is 'linear' or 'cubic'")
    time = np.asarray(timepts, float)
    if time.ndim != 1 or time.size < 2:
        raise RecordError(f"timepts must be a vector of at least two times; got shape {time.shape}")
    return time


def _simulate_pieces(
    car: Suspension,
    timepts: ArrayLike,
    inputs: Mapping[str, ArrayLike],
    outputs: Sequence[str] | None,
    initial_state: Mapping[str, float] | ArrayLike | None,
    interpolation: Interpolation | None,
) -> control.TimeResponseData:
    """Return the response of a suspension with friction or curves."""
    time = _times(timepts, interpolation)
    step, labels = uniform_step(time), [*car.roads, *(f"{road}{RATE}" for road in car.roads)]
    names = list(car.coordinates if outputs is None else outputs)
    pushes = [name for name in inputs if name.endswith(FORCE) and name not in car.roads]
    rows = _samples(inputs, [*labels, *pushes], time.size)
    samples, interpolation = dict(zip(inputs, rows, strict=True)), interpolation or suited(rows)
    driving = Driving(
        roads=tuple(road for road in car.roads if road in inputs),
        rates=tuple(road for road in car.roads if f"{road}{RATE}" in inputs),
        forces=tuple(pushes),
        degrees=DEGREES[interpolation] + 1,
    )
    ordered = [*driving.roads, *(f"{road}{RATE}" for road in driving.rates), *driving.forces]
    made = derivatives(np.array([samples[name] for name in ordered]).reshape(-1, time.size), step, interpolation)
    machine, states = machine_of(car, driving), state_labels(car)
    start = np.zeros(len(states)) if initial_state is None else state_of(states, initial_state)
    moved, choices = motion(machine, made.reshape(-1, time.size), start, time)
    seen = np.zeros((2, len(car.roads), time.size))
    for i, road in enumerate(car.roads):
        if road in inputs:
            rate = samples.get(f"{road}{RATE}", made[1, ordered.index(road)])
            seen[:, i] = samples[road], rate
    values = observed(machine, car, names, moved, choices, seen)
    return as_response(time, values, names, title="Driven", inputs=samples)


def _samples(inputs: Mapping[str, ArrayLike], labels: Sequence[str], count: int) -> RealArray:
    """Return the checked samples of the inputs, (input, sample)."""
    rows = []
    for name, given in inputs.items():
        if name not in labels:
            raise InputError(f"there is no input {name!r}.{nearest_names(name, labels)}")
        row = _numbers(name, given)
        if row.shape != (count,):
            raise InputError(f"input {name!r} has shape {row.shape}; there are {count} times")
        if not np.all(np.isfinite(row)):
            raise InputError(f"input {name!r} has {np.sum(~np.isfinite(row))} samples that are not finite")
        road = name.removesuffix(RATE)
        if road != name and road in labels and road not in inputs:
            raise InputError(f"input {name!r} needs {road!r}: give the road, and its rate is computed")
        rows.append(row)
    return np.array(rows).reshape(len(rows), count)


def _numbers(name: str, given: ArrayLike) -> RealArray:
    """Return the samples of an input, or refuse what is none, such as the class of a road, with the line to write."""
    try:
        return np.asarray(given, float)
    except (TypeError, ValueError):
        raise InputError(
            f"input {name!r} is {given!r:.40}: give a number for each time [m or N]; heights of a road of class C are "
            f"road_profile(speed * timepts, roughness='C', rng=np.random.default_rng(1))"
        ) from None


def _by_derivative(matrix: RealArray, labels: Sequence[str], names: Sequence[str]) -> RealArray:
    """Return the columns of the given inputs, and those that their rates drive if these are not given themselves."""
    columns = list(labels)
    direct, rates = matrix[:, [columns.index(name) for name in names]], np.zeros((len(matrix), len(names)))
    for i, name in enumerate(names):
        if f"{name}{RATE}" in columns and f"{name}{RATE}" not in names:
            rates[:, i] = matrix[:, columns.index(f"{name}{RATE}")]
    return np.stack([direct, rates])
