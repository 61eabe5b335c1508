"""Records in the time domain: as they are or from where decays begin, with what else they need."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from suspid.errors import EstimationError, InputError
from suspid.greybox.fits import Fit
from suspid.greybox.further import SENSOR_KINDS, chosen_of
from suspid.greybox.noisy_inputs import noise_told, with_noise_of_inputs
from suspid.greybox.onset import from_onset
from suspid.greybox.problem import Problem, default_holds
from suspid.greybox.sensors_asked import Names, clearly_late, further_asked, with_sensors
from suspid.greybox.sensors_needed import fit_beside, leaves_something, said_so, with_needed
from suspid.greybox.time_domain import fit_in_time
from suspid.greybox.trials import Trial
from suspid.reconstruction import Unknowns
from suspid.units import Hertz, Second
from suspid.values import listed
from suspid.wording import Argument
from suspid.words import Check, Level, Number, Remark
from suspid.words.greybox import EstimateCheck


class SensorsAsked(NamedTuple):
    """What is asked of sensors, as arguments of `estimate`."""

    gains: Sequence[str] | None
    delays: Sequence[str] | None
    mounts: Sequence[str] | None
    noisy: Sequence[str] | None
    band: tuple[Hertz, Hertz] | None
    stretch: Second | None

    @property
    def chosen(self) -> Names:
        """The names that are asked for, by kind."""
        given = {"mounts": self.mounts, "gains": self.gains, "delays": self.delays}
        return {kind: (one,) if isinstance(one := given[kind] or (), str) else tuple(one) for kind in SENSOR_KINDS}

    @property
    def free(self) -> tuple[str, ...]:
        """The kinds of which nothing is asked, so that what the records need may be added."""
        given = {"mounts": self.mounts, "gains": self.gains, "delays": self.delays}
        return tuple(kind for kind in SENSOR_KINDS if given[kind] is None)


def fitted_in_time(
    trials: tuple[Trial, ...], bare: Unknowns, asked: SensorsAsked, *, onsets: bool
) -> tuple[Fit, tuple[Trial, ...], Unknowns]:
    """Return the fit of decays or of motion under known causes, its trials and its unknowns.

    ``bare`` are the unknowns of the car alone; what is asked of sensors is added, and where nothing is, what the
    records need. With ``onsets``, decays are looked for in records that are none from the start.

    Raises
    ------
    InputError
        If a name is unknown, or what is asked cannot be found.
    """
    chosen, free = asked.chosen, asked.free
    unknowns, cut = further_asked(bare, trials, gains=asked.gains, delays=asked.delays, mounts=asked.mounts)
    known = tuple(dict.fromkeys(name for trial in trials for name in trial.known))
    if _are_noisy(asked.noisy, known, trials):
        found = with_noise_of_inputs(trials, bare, chosen, free, band=asked.band, stretch=asked.stretch, demanded=True)
        assert found is not None
        return *found[:2], bare
    if "delays" in free and (late := clearly_late(bare, trials)):
        # Channels that are late by cycles lead a fit without their delays astray.
        wider = with_sensors(bare, trials, **{**chosen, "delays": late})
        problem = Problem(trials=wider[1], holds=default_holds(wider[1]), unknowns=wider[0])
        with suppress(EstimationError):
            fit, problem = with_needed(fit_in_time(problem), problem, bare, {**chosen, "delays": late}, free)
            if fit.explains:
                return said_so(fit, problem, unknowns), problem.trials, problem.unknowns
    fit, cut = _with_onsets(cut, unknowns, onsets=onsets and not known)
    problem = Problem(trials=cut, holds=fit.holds, unknowns=unknowns)
    may_be_noisy = asked.noisy is None and all(map(_moved, trials)) and leaves_something(fit)
    told = may_be_noisy and noise_told(trials, bare, chosen, unknowns, fit)
    noisy = _with_noise(trials, bare, unknowns, chosen, free) if told else None
    if noisy is None:
        fit, problem = with_needed(fit, problem, bare, chosen, free)
        # What a late channel leaves of a fit hides the noise of a road, which hides the late channel from this fit.
        if may_be_noisy and free and not told and not fit.explains:
            noisy = _with_noise(trials, bare, unknowns, chosen, free)
    return (fit, problem.trials, problem.unknowns) if noisy is None else noisy


def _are_noisy(names: Sequence[str] | None, known: Sequence[str], trials: Sequence[Trial]) -> bool:
    """Return whether noise of known roads and forces is asked for, after checking that there is one."""
    if names and not known:
        raise InputError(
            Argument("noisy"), ": the records have no known road or force whose noise this could be; name it in ",
            Argument("given"),
        )  # fmt: skip
    asked = bool(chosen_of("noisy", names, known, ()))
    still = [number for number, trial in enumerate(trials, 1) if not _moved(trial)]
    if asked and still:
        raise InputError(
            Argument("noisy"), f": {listed(list(trials[still[0] - 1].known))} of record {still[0]} never change, or "
            "there is none: noise of a cause is told beside its motion; leave it out",
        )  # fmt: skip
    return asked


def _moved(trial: Trial) -> bool:
    """Return whether all known roads and forces of a test change, and there is one."""
    return len(trial.inputs) > 0 and bool(np.all(np.ptp(trial.inputs, axis=1) > 0))


def _with_noise(
    trials: tuple[Trial, ...], bare: Unknowns, before: Unknowns, chosen: Names, free: Sequence[str]
) -> tuple[Fit, tuple[Trial, ...], Unknowns] | None:
    """Return the fit with noise of the inputs, or without where it is not told beside what else the records need."""
    found = with_noise_of_inputs(trials, bare, chosen, free)
    if found is None or found[2] == chosen:
        return None if found is None else (*found[:2], bare)
    with suppress(EstimationError):
        fit, problem, left = fit_beside(trials, bare, found[2], chosen)
        if fit.explains and not noise_told(trials, bare, left, problem.unknowns, fit):
            return said_so(fit, problem, before), problem.trials, problem.unknowns
    return *found[:2], bare


def _with_onsets(trials: tuple[Trial, ...], unknowns: Unknowns, *, onsets: bool) -> tuple[Fit, tuple[Trial, ...]]:
    """Return the fit of decays or of motion under known causes; with ``onsets``, from where the decays begin.

    That is if it is nearer to an explanation than a fit of the whole records, or if these have none.
    """
    try:
        fit = fit_in_time(Problem(trials=trials, holds=default_holds(trials), unknowns=unknowns))
    except EstimationError:
        later = from_onset(trials) if onsets else None
        if later is None:
            raise
        found = _of_decays(later, unknowns)
        if found is None:
            raise
        return found, later
    later = from_onset(trials) if onsets and not fit.explains else None
    found = None if later is None else _of_decays(later, unknowns)
    if later is None or found is None:
        return fit, trials
    if not found.explains and found.chi_square / max(found.freedom, 1) > fit.chi_square / max(fit.freedom, 1):
        return fit, trials
    return found, later


def _of_decays(later: tuple[Trial, ...], unknowns: Unknowns) -> Fit | None:
    """Return the fit of decays that were cut out of records; None where they do not determine the car."""
    try:
        found = fit_in_time(Problem(trials=later, holds=default_holds(later), unknowns=unknowns))
    except EstimationError:
        return None
    numbers: dict[str, Number] = {"starts": ", ".join(f"{trial.start:.6g}" for trial in later)}
    return replace(found, checks=(*found.checks, Check(Remark(EstimateCheck.ONSET, numbers), Level.NOTE)))
