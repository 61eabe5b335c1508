"""Mounts, gains and delays that are asked for in the time domain, with the samples that unknown delays need."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from suspid.errors import InputError
from suspid.greybox.clocks import Clocks, clocks_of
from suspid.greybox.further import INPUTS, Place, check_some_known, chosen_of, label, sensing_of, with_further
from suspid.greybox.responses import output_error
from suspid.greybox.trials import HOLDS, Trial
from suspid.greybox.wheel_problem import band_of
from suspid.reconstruction import Unknowns, parameter_vector
from suspid.values import listed
from suspid.wording import Argument

Names = dict[str, tuple[str, ...]]  # of channels or struts, by kind


def further_asked(
    unknowns: Unknowns,
    trials: tuple[Trial, ...],
    *,
    gains: Sequence[str] | None,
    delays: Sequence[str] | None,
    mounts: Sequence[str] | None,
) -> tuple[Unknowns, tuple[Trial, ...]]:
    """Return the unknowns in the time domain, with mounts, gains and delays that were asked for, and the trials.

    Beside known roads and forces, channels of unknown delay are used where the inputs are known at any of its values.

    Raises
    ------
    InputError
        If a name is unknown, or delays are asked for that cannot be found.
    """
    damped = [s.name for s in unknowns.car.struts if s.damping > 0]
    channels = tuple(dict.fromkeys(c for trial in trials for c in (*trial.channels, *trial.known)))
    high, late = chosen_of("gains", gains, channels, ()), chosen_of("delays", delays, channels, ())
    for argument, names in (("gains", high), ("delays", late)):
        _check_inputs(argument, names, trials)
        for trial in trials:
            check_some_known(argument, names, (*trial.channels, *trial.known))
    return with_sensors(unknowns, trials, gains=high, delays=late, mounts=chosen_of("mounts", mounts, damped, ()))


def with_sensors(
    unknowns: Unknowns, trials: Sequence[Trial], *, gains: Sequence[str], delays: Sequence[str], mounts: Sequence[str]
) -> tuple[Unknowns, tuple[Trial, ...]]:
    """Return what `further_asked` does, for names that are known."""
    struts, late_places = [s.name for s in unknowns.car.struts], _places(delays, trials)
    about = [_clocks(unknowns, trial, i, late_places) for i, trial in enumerate(trials)]
    free = with_further(
        unknowns,
        mounts=[struts.index(name) for name in mounts],
        gains=_places(gains, trials),
        delays=late_places,
        about=[_looked_for(about[test], channel) for _, (test, channel) in late_places],
    )
    kept = [trial if one is None else trial.within(one.margin) for trial, one in zip(trials, about, strict=True)]
    return free, tuple(kept)


def possible(trials: Sequence[Trial], unknowns: Unknowns, chosen: Names, free: Sequence[str]) -> Names:
    """Return what is chosen and all that is possible of the kinds ``free``."""
    damped = tuple(s.name for s in unknowns.car.struts if s.damping > 0 and s.mount_stiffness is None)
    channels = tuple(dict.fromkeys(channel for trial in trials for channel in trial.channels))
    every = {kind: damped if kind == "mounts" else channels for kind in free}
    return {kind: tuple(dict.fromkeys((*chosen[kind], *every.get(kind, ())))) for kind in chosen}


def clearly_late(unknowns: Unknowns, trials: Sequence[Trial]) -> tuple[str, ...]:
    """Return the channels that are late or early by more than a fit finds from none, beside known inputs."""
    names: list[str] = []
    for i, trial in enumerate(trials):
        clocks = _clocks(unknowns, trial, i, [(name, (i, c)) for c, name in enumerate(trial.channels)])
        if clocks is not None:
            names += [name for name, lag in zip(trial.channels, clocks.about, strict=True) if lag]
    return tuple(dict.fromkeys(names))


def _places(names: Sequence[str], trials: Sequence[Trial]) -> list[tuple[str, Place]]:
    return [
        (label(name, i, len(trials)), (i, trial.channels.index(name) if name in trial.channels else INPUTS))
        for i, trial in enumerate(trials)
        for name in names
        if name in (*trial.channels, *trial.known)
    ]


def _check_inputs(argument: str, names: Sequence[str], trials: Sequence[Trial]) -> None:
    """Refuse the gain or delay of one of several inputs."""
    for trial in trials:
        among = [name for name in names if name in trial.known]
        if among and len(trial.known) > 1:
            raise InputError(
                Argument(argument),
                f": {among[0]!r} is one of several known roads and forces, of which none can be told from the others; "
                f"name the channels that they move instead: {listed(trial.channels)}",
            )


def _clocks(unknowns: Unknowns, trial: Trial, test: int, places: Sequence[tuple[str, Place]]) -> Clocks | None:
    """Return where delays of a test are looked for; None where any can be, as without inputs."""
    late = [channel for _, (owner, channel) in places if owner == test]
    if not late or not len(trial.inputs):
        return None
    car, power = unknowns.car, np.sqrt(np.maximum(np.mean(trial.values**2, axis=1), trial.noise.least))
    left = output_error(
        car, trial, parameter_vector(car), (), std=power, hold=HOLDS[0],
        sensing=sensing_of(unknowns, unknowns.base, test, len(trial.channels)),
    )  # fmt: skip
    every = list(range(len(trial.channels))) if INPUTS in late else late
    return clocks_of(trial, trial.values - left.residual, every, band_of(car)[1])


def _looked_for(clocks: Clocks | None, channel: int) -> tuple[float, float]:
    if clocks is None:
        return 0.0, np.inf
    return (-float(np.median(clocks.about)) if channel == INPUTS else float(clocks.about[channel])), clocks.reach
