"""Uniformly sampled signals, in and out of `control.TimeResponseData`.

That type accepts NaN, unsorted time and several traces without an error, and is 2-D or 3-D depending on the
function that made it. `as_signal` checks all of this in one place.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Protocol

import numpy as np

from suspid.errors import RecordError
from suspid.levels import NORMAL_MEDIAN
from suspid.units import RealArray, Second
from suspid.values import LARGEST_SIZE, SMALLEST_SIZE, frozen_real
from suspid.wording import Argument

if TYPE_CHECKING:
    import control
    from numpy.typing import ArrayLike

# Largest distance of a time stamp from the uniform grid, in sampling steps. At the highest frequency of use, a tenth
# of the rate, it moves a sample by 0.6 % of the amplitude.
JITTER = 0.01
# A step that is so much longer than the usual one is a gap, and no jitter.
GAP = 10.0
# Samples without which there is no step.
LEAST_SAMPLES = 2
# Share of the sampling rate up to which filters against aliases let a motion pass: those of loggers end there.
PASSED = 0.4


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Signal:
    """Finite samples of one or more channels at one uniform step.

    Parameters
    ----------
    start : float
        Time of the first sample [s].
    step : float
        Sampling step [s].
    values : ndarray (channel, sample)
        The samples, in the unit of the channel.
    channels : tuple of str
        Names of the channels.
    """

    start: Second
    step: Second
    values: RealArray
    channels: tuple[str, ...]

    @property
    def timepts(self) -> RealArray:
        """Time of each sample [s]."""
        return self.timepts_of(0, self.values.shape[1])

    def timepts_of(self, first: int, last: int) -> RealArray:
        """Return the times of the samples from the first to the last (excluded) [s]."""
        return np.asarray(self.start + self.step * np.arange(first, last), float)

    @property
    def duration(self) -> Second:
        """Time from the first sample to one step after the last [s]."""
        return float(self.step * self.values.shape[1])


class Stretch(Protocol):
    """Anything with a first and a last time, such as a `suspid.Decay`."""

    @property
    def start(self) -> Second:
        """First time [s]."""
        ...

    @property
    def stop(self) -> Second:
        """Last time [s]."""
        ...


def as_signal(response: control.TimeResponseData, *, least: int = LEAST_SAMPLES, copied: bool = True) -> Signal:
    """Return the checked samples of a response.

    Parameters
    ----------
    response : control.TimeResponseData
        One trace, any number of outputs.
    least : int
        Fewest samples that are of use.
    copied : bool
        Whether the samples of a user's response are copied, so that the signal may outlive its changes.

    Raises
    ------
    RecordError
        If the response is empty, too short, complex, masked, irregular in time, or holds values that are not finite.
    """
    # `suspid.samples.Samples` are checked once.
    own = getattr(response, "signal", None)
    signal = own if isinstance(own, Signal) else checked(response)
    if signal.values.shape[1] < least:
        raise _too_short(signal.values.shape[1], least)
    return signal if signal is own or not copied else replace(signal, values=frozen_real(signal.values))


def checked(response: control.TimeResponseData) -> Signal:
    """Return the samples of a response as they lie there, checked but for their number."""
    if not all(hasattr(response, name) for name in ("time", "y", "output_labels")):
        raise RecordError(
            f"expected a control.TimeResponseData, not {type(response).__name__}: write as_record(data, fs=...)"
        )
    timepts, values = real_numbers(response.time, "time"), real_numbers(response.y, "the response")
    if values.ndim == 3:
        if values.shape[1] != 1:
            raise RecordError(f"the response contains {values.shape[1]} traces; pass one of them at a time")
        values = values[:, 0, :]
    if values.shape[1] != len(timepts):
        raise RecordError(f"{len(timepts)} time points, but {values.shape[1]} samples")
    if len(timepts) < LEAST_SAMPLES:
        raise _too_short(len(timepts), LEAST_SAMPLES)
    labels = response.output_labels
    channels = tuple(labels) if labels else tuple(f"y[{i}]" for i in range(len(values)))
    for name, samples in zip(channels, values, strict=True):
        bad = np.flatnonzero(~np.isfinite(samples))
        if bad.size:
            raise RecordError(
                f"channel {name!r} has {bad.size} of {samples.size} samples that are not finite, the first at "
                f"t = {timepts[bad[0]]:g} s; cut the record there or fill the gap"
            )
        # What is left of a record of the smallest size is smaller.
        check_size(name, timepts, samples, smallest=SMALLEST_SIZE**2)
    kept = values.view()
    kept.flags.writeable = False
    return Signal(start=float(timepts[0]), step=uniform_step(timepts), values=kept, channels=channels)


def _too_short(samples: int, least: int) -> RecordError:
    return RecordError(
        f"the record has {samples} samples; at least {least} are needed: "
        f"record longer, or use a longer stretch ({Argument('start')}, {Argument('stop')})"
    )


def check_size(name: str, timepts: RealArray, samples: RealArray, *, smallest: float = SMALLEST_SIZE) -> None:
    """Refuse samples whose powers no float holds.

    Examples
    --------
    >>> check_size("seat", np.array([0.0, 0.1]), np.array([1.0, -1e160]))
    Traceback (most recent call last):
    suspid.errors.RecordError: channel 'seat' reaches 1e+160 at t = 0.1 s; samples are used from 1e-30 to 1e+30...
    """
    largest = max(float(np.max(samples, initial=0.0)), -float(np.min(samples, initial=0.0)))
    if largest and not smallest <= largest <= LARGEST_SIZE and np.isfinite(largest):
        at = timepts[int(np.argmax(np.abs(samples)))]
        raise RecordError(
            f"channel {name!r} reaches {largest:.3g} at t = {at:g} s; samples are used from {SMALLEST_SIZE:g} to "
            f"{LARGEST_SIZE:g}: change the unit of the channel, or cut the record there"
        )


def real_numbers(data: ArrayLike, what: str) -> RealArray:
    """Return an array of real numbers; refuse imaginary parts and masks, which would be lost without a word.

    Examples
    --------
    >>> real_numbers([1, 2j], "the response")
    Traceback (most recent call last):
    suspid.errors.RecordError: the response is complex; pass its real or its imaginary part as a record of its own
    """
    members = data if isinstance(data, list | tuple) else (data,)
    masked = sum(int(np.sum(np.ma.getmaskarray(one))) for one in members if np.ma.isMaskedArray(one))
    if masked:
        raise RecordError(f"{what}: {masked} samples are masked; fill them or cut the record there")
    try:
        values = np.asarray(data)
    except ValueError:
        raise RecordError(f"{what}: the channels have different lengths; pass those of one rate") from None
    if values.dtype.kind == "c":
        if np.any(values.imag):
            raise RecordError(f"{what} is complex; pass its real or its imaginary part as a record of its own")
        values = values.real
    if values.dtype.kind not in "iufb":
        way = "give an array of real numbers, as in np.asarray(data, float)"
        raise RecordError(f"{what} contains no numbers, but {values.dtype}; {way}")
    return np.asarray(values, float)


def block_means(values: RealArray, size: int) -> RealArray:
    """Return the means over blocks of ``size`` samples, (channel, block); the rest of the samples is left out."""
    if size == 1:
        return values
    blocks = values.shape[1] // size
    return np.asarray(values[:, : blocks * size].reshape(len(values), blocks, size).mean(axis=2))


def roughness(values: RealArray) -> float:
    """Return the standard deviation of what changes from sample to sample, by the median of second differences.

    Of white noise beside a slow motion it is that of the noise: second differences have sqrt(6) times as much.

    Examples
    --------
    >>> t, noise = np.arange(5000) / 100, 0.1 * np.random.default_rng(1).standard_normal(5000)
    >>> round(roughness(np.sin(3 * t) + noise), 2)
    0.1
    """
    bends = np.diff(values, 2)
    return float(np.median(np.abs(bends - np.median(bends))) / (NORMAL_MEDIAN * np.sqrt(6)))


def uniform_step(timepts: RealArray) -> Second:
    """Return the sampling step of uniform time points [s].

    Raises
    ------
    RecordError
        If the points do not increase, or stray from a uniform grid by more than a hundredth of a step.
    """
    bad = np.flatnonzero(~np.isfinite(timepts))
    if bad.size:
        raise RecordError(f"{bad.size} of {timepts.size} time stamps are not finite, the first is number {bad[0] + 1}")
    back = np.flatnonzero(np.diff(timepts) <= 0)
    if back.size:
        k = back[0]
        raise RecordError(
            f"time does not increase at {back.size} of {timepts.size} samples, the first after t = {timepts[k]:g} s "
            f"(next stamp {timepts[k + 1]:g} s); sort the record or remove the repeated samples"
        )
    step = float(timepts[-1] - timepts[0]) / (len(timepts) - 1)
    astray = np.abs(timepts - (timepts[0] + step * np.arange(len(timepts)))) / step
    worst = int(np.argmax(astray))
    if astray[worst] > JITTER:
        steps = np.diff(timepts)
        usual, longest = float(np.median(steps)), int(np.argmax(steps))
        if steps[longest] > GAP * usual:
            raise RecordError(
                f"time has a gap: after t = {timepts[longest]:.9g} s the next stamp is {steps[longest]:g} s later, but "
                f"the usual step is {usual:g} s; use the part before or after it, or fill it on a uniform grid"
            )
        raise RecordError(
            f"time is irregular: the stamp t = {timepts[worst]:g} s lies {astray[worst]:.2g} steps off a uniform grid "
            f"of {step:g} s; resample the record, or give "
            f"{Argument('fs')} if the stamps are only rounded"
        )
    return step
