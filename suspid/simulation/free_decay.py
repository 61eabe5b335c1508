"""Exact free decays of a model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from suspid.arguments import explained
from suspid.errors import InputError
from suspid.model import Suspension, statespace
from suspid.records import as_response
from suspid.simulation.piecewise import Driving, machine_of, state_labels
from suspid.simulation.stepping import motion, observed
from suspid.units import RealArray, Second
from suspid.values import nearest_names
from suspid.wording import Argument

if TYPE_CHECKING:
    import control


@explained
def free_decay(
    system: control.StateSpace | Suspension,
    timepts: ArrayLike,
    *,
    initial_state: Mapping[str, float] | ArrayLike | None = None,
    impulse: str | None = None,
) -> control.TimeResponseData:
    """Return the exact free response, ``C exp(A (t - t_0)) x_0``, at all outputs.

    Uniform time points are filled by doubling: the states of the next 2^k samples are
    ``exp(A 2^k step)`` times those of the last 2^k. This is exact to rounding and also holds for defective
    (critically damped) systems. Each doubling computes its own exponential, so errors do not accumulate over
    the record.

    A suspension with friction or curves is linear between the points of its curves, and stepped exactly from one to
    the next. Friction holds a damper up to a creep of 1e-9 m/s.

    Parameters
    ----------
    system : control.StateSpace or Suspension
        The model; a suspension is taken as ``statespace(suspension)``, or as it is if it has friction or curves.
    timepts : array_like (sample,)
        Increasing times [s]; the initial state holds at the first of them.
    initial_state : mapping of str to float, or array_like (state,), optional
        State at the first time: by label (``{"v_tire": 1.0}``, the others zero), or as a vector.
    impulse : str, optional
        Name of an input that receives a unit impulse just before the first time.

    Returns
    -------
    control.TimeResponseData
        Outputs (channel, sample), labelled as the system's.

    Raises
    ------
    InputError
        If neither or both of initial_state and impulse are given, a name is unknown, the impulse passes directly to
        an output (it would be infinite there), the system is sampled, or an unstable response exceeds the
        floating-point range.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> free_decay(car, np.arange(0, 3, 0.01), initial_state={"v_tire": 1.0}).y.shape
    (2, 300)
    """
    if isinstance(system, Suspension) and system.linear:
        system = statespace(system)
    if not isinstance(system, Suspension):
        check_continuous(system, "free_decay")
    time = np.asarray(timepts, float)
    if time.ndim != 1 or time.size < 1:
        raise InputError(f"timepts must be a vector of at least one time; got shape {time.shape}")
    if np.any(np.diff(time) <= 0) or not np.all(np.isfinite(time)):
        raise InputError("timepts must be finite and increase strictly")
    if (initial_state is None) == (impulse is None):
        raise InputError("give either ", Argument("initial_state"), " or ", Argument("impulse"))
    if isinstance(system, Suspension):
        return _piecewise_decay(system, time, initial_state)
    A, C = np.asarray(system.A, float), np.asarray(system.C, float)
    start = state_of(system.state_labels, initial_state) if impulse is None else _impulse_state(system, impulse)
    # Times within 8 floats of a uniform grid count as uniform: rounding moves them by no more.
    step = (time[-1] - time[0]) / max(time.size - 1, 1)
    deviation = np.max(np.abs(time - (time[0] + step * np.arange(time.size))))
    with np.errstate(over="ignore", invalid="ignore"):
        if deviation <= 8 * np.spacing(np.max(np.abs(time))):
            states = _uniform_states(A, start, time.size, step)
        else:
            states = _states_at(A, start, time - time[0])
        values = C @ states
    beyond = np.flatnonzero(~np.all(np.isfinite(values), axis=0))
    if beyond.size:
        raise InputError(
            f"the system is unstable: its response exceeds the largest float before t = {time[beyond[0]]:g} s; "
            f"end the record earlier"
        )
    return as_response(time, values, system.output_labels, title="Free decay")


def _piecewise_decay(
    car: Suspension, time: RealArray, given: Mapping[str, float] | ArrayLike | None
) -> control.TimeResponseData:
    """Return the decay of a suspension with friction or curves."""
    if given is None:
        raise InputError(
            "the suspension has friction or curves, so its response is not in proportion to an impulse; give the state "
            "after it: ",
            Argument("initial_state"),
            ", such as v_tire = 1 m/s",
        )
    machine = machine_of(car, Driving())
    states, choices = motion(machine, np.zeros((0, len(time))), state_of(state_labels(car), given), time)
    still = np.zeros((2, len(car.roads), len(time)))
    values = observed(machine, car, car.coordinates, states, choices, still)
    return as_response(time, values, car.coordinates, title="Free decay")


def check_continuous(system: control.StateSpace, verb: str) -> None:
    """Refuse what is no continuous-time system."""
    if not hasattr(system, "A") or not hasattr(system, "state_labels"):
        raise InputError(f"{verb} needs a control.StateSpace or a Suspension, not {type(system).__name__}")
    if system.dt:
        raise InputError(f"{verb} needs a continuous-time system; this one is sampled (dt = {system.dt})")


def state_of(labels: Sequence[str], given: Mapping[str, float] | ArrayLike | None) -> RealArray:
    """Return a state that is given by label, the others zero, or as a vector."""
    if isinstance(given, Mapping):
        for name in given:
            if name not in labels:
                raise InputError(f"there is no state {name!r}.{nearest_names(name, labels)}")
        state = np.array([given.get(label, 0.0) for label in labels], float)
    else:
        state = np.asarray(given, float)
        if state.shape != (len(labels),):
            raise InputError(f"{Argument('initial_state')} has shape {state.shape}; the states are {', '.join(labels)}")
    if not np.all(np.isfinite(state)):
        raise InputError(f"initial_state {state} is not finite")
    return state


def _impulse_state(system: control.StateSpace, name: str) -> RealArray:
    labels = list(system.input_labels)
    if name not in labels:
        raise InputError(f"there is no input {name!r}.{nearest_names(name, labels)}")
    direct = np.asarray(system.D, float)[:, labels.index(name)]
    if np.any(direct):
        output = system.output_labels[int(np.flatnonzero(direct)[0])]
        raise InputError(
            f"an impulse on {name!r} passes directly to output {output!r} and is infinite there; "
            f"choose other outputs, or give the state after the impulse ({Argument('initial_state')})"
        )
    return np.asarray(system.B, float)[:, labels.index(name)]


def _uniform_states(A: RealArray, start: RealArray, count: int, step: Second) -> RealArray:
    """Return ``exp(A k step) start`` for k = 0 … count - 1, (state, sample)."""
    from scipy.linalg import expm

    states = np.empty((len(A), count))
    states[:, 0] = start
    done = 1
    while done < count:
        new = min(done, count - done)
        states[:, done : done + new] = expm(A * (done * step)) @ states[:, :new]
        done += new
    return states


def _states_at(A: RealArray, start: RealArray, elapsed: RealArray) -> RealArray:
    """Return ``exp(A t) start`` at any times, (state, sample), in blocks to limit memory."""
    from scipy.linalg import expm

    blocks = np.array_split(elapsed, max(1, elapsed.size // 4096))
    return np.concatenate([(expm(A * block[:, None, None]) @ start).T for block in blocks], axis=1)
