"""Speed of the car and rotation of its wheels in the stretches of a record."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from suspid.cleaning import as_record
from suspid.errors import InputError
from suspid.greybox.record_test import RecordTest
from suspid.greybox.trials import Trial, records_of
from suspid.signals import as_signal
from suspid.units import Metre, MetrePerSecond, RealArray
from suspid.values import frozen_real, likely_names, listed
from suspid.wording import Argument

SLOWEST: MetrePerSecond = 1.0  # below it a car counts as moving at this speed; a standing one has no road
Speed: TypeAlias = MetrePerSecond | str | ArrayLike


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Rolling:
    """Speed by record, and the radius of the wheels; None where they are unknown."""

    speeds: tuple[RealArray, ...] | None  # by record, (sample,)
    radius: Metre | None
    channels: tuple[str, ...]  # of the records that are the speed


def rolling_of(
    records: object,
    trials: Sequence[Trial],
    *,
    speed: Speed | Sequence[Speed] | None,
    radius: Metre | None,
) -> Rolling:
    """Return the speed at every sample.

    Raises
    ------
    InputError
        If the speed is no number, channel or array as long as the record, or the radius is not positive.
    """
    if radius is not None and not (np.isfinite(radius) and radius > 0):
        raise InputError(Argument("wheel_radius", f"{radius!r}"), " must be a positive number [m]")
    if speed is None:
        return Rolling(speeds=None, radius=radius, channels=())
    whole: Any = speed
    asked = records_of(records)
    # Speeds of several records differ in length, so that they make no array.
    each = isinstance(whole, list | tuple) and len(asked) > 1
    shared = not each and (
        isinstance(whole, str) or np.ndim(whole) == 0 or (len(asked) == 1 and np.shape(whole) != (1,))
    )
    every = [whole] * len(trials) if shared else list(whole)
    if len(every) != len(trials):
        raise InputError(
            Argument("speed"), f": {len(every)} given for {len(trials)} records; give one for each, or one for all"
        )
    names = tuple(dict.fromkeys(one for one in every if isinstance(one, str)))
    return Rolling(
        speeds=tuple(_samples(r, t, v) for r, t, v in zip(asked, trials, every, strict=True)),
        radius=radius,
        channels=names,
    )


def without_speed(trials: Sequence[Trial], rolling: Rolling) -> tuple[Trial, ...]:
    """Return the trials without the channel of the speed among those that measure nothing."""
    return tuple(replace(t, unused=tuple(n for n in t.unused if n not in rolling.channels)) for t in trials)


def _samples(record: object, trial: Trial, speed: Any) -> RealArray:
    if isinstance(speed, str):
        signal = as_signal(as_record(record.record if isinstance(record, RecordTest) else record))
        if speed not in signal.channels:
            raise InputError(
                Argument("speed"),
                f": the record has no channel {speed!r}; it has {listed(signal.channels)}."
                f"{likely_names(speed, signal.channels)}",
            )
        values = signal.values[signal.channels.index(speed)]
    else:
        values = np.asarray(speed, float)
        values = np.full(trial.count, float(values)) if values.ndim == 0 else values.ravel()
    if len(values) != trial.count:
        raise InputError(Argument("speed"), f": {len(values)} values for a record of {trial.count} samples")
    if not np.all(np.isfinite(values)) or np.max(values) <= 0:
        raise InputError("speed must be finite, and positive where the car moves [m/s]")
    return frozen_real(np.maximum(values, SLOWEST))
