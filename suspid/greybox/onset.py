"""Free decays of records that begin before the decay: with the car at rest, or while it is still being pushed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from suspid.decays import find_decays
from suspid.greybox.trials import Trial
from suspid.records import as_response


def from_onset(trials: Sequence[Trial]) -> tuple[Trial, ...] | None:
    """Return trials from where their best decay begins to where it ends; None if all of them begin with it."""
    cut = tuple(_cut(trial) for trial in trials)
    return None if all(new is old for new, old in zip(cut, trials, strict=True)) else cut


def _cut(trial: Trial) -> Trial:
    times = np.linspace(trial.start, trial.start + trial.step * (trial.count - 1), trial.count)
    decays = find_decays(as_response(times, trial.values, trial.channels))
    if not decays:
        return trial
    first, last = np.searchsorted(
        times, np.array([decays[0].start, decays[0].stop]) + np.array([-0.5, 0.5]) * trial.step
    )
    if not first:
        return trial
    return replace(trial, start=float(times[first]), values=trial.values[:, first:last])
