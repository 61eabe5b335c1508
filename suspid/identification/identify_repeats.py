"""Several decays of one structure, identified one by one and jointly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from suspid.arguments import explained
from suspid.cleaning import RecordLike, as_record, is_pair
from suspid.errors import IdentificationError, InputError, RecordError
from suspid.identification.by_amplitude import joined, strongest
from suspid.identification.considered import removed_as
from suspid.identification.covariance import joint_covariance
from suspid.identification.exponentials import blocks_of
from suspid.identification.identification import Identification
from suspid.identification.identify import identify
from suspid.identification.joint_fit import agreement, maximize_jointly
from suspid.identification.noise import WhiteNoise, noise_of, shared_noise
from suspid.identification.repeats import Repeats
from suspid.identification.selection import select
from suspid.identification.verdict import OTHER_THAN_NOISE
from suspid.levels import EQUAL_RATE, FEWEST_SAMPLES
from suspid.model import ModalSet
from suspid.records import cut
from suspid.samples import held
from suspid.signals import Stretch, as_signal
from suspid.threads import in_one_thread
from suspid.units import Hertz, RealArray, Second, angular
from suspid.values import check_count, frozen_real
from suspid.words import Reason

if TYPE_CHECKING:
    import control

# Poles are sought in the repeats at least this long, relative to the median, side by side over their common length.
LONG_ENOUGH = 0.5
# Share of the decays with forces other than linear ones from which on poles common to all describe none of them. The
# same holds of decays that no linear fit describes where there are more common poles than any of them has.
BENT_SHARE = 0.5


@explained
@in_one_thread
def identify_repeats(
    response: RecordLike | Sequence[RecordLike],
    decays: Sequence[Stretch | tuple[Second, Second]] | None = None,
    *,
    modes: int | None = None,
    band_hz: tuple[Hertz, Hertz] | None = None,
    names: Sequence[str] = (),
) -> Repeats:
    """Return the modes that several decays share.

    The poles are common to all decays; amplitudes and an offset are free in each decay and channel, and so is the
    level of the noise. Which poles there are is found over the length that the decays have in common (those shorter
    than half the median stay out of that); then the joint likelihood of all decays, each over its whole length, is
    maximised. The shapes of the decays are combined by generalised least squares with the covariance of their
    amplitudes, so that one shape per mode remains. Variances are widened where the residual is louder than white noise,
    where the channels share noise, and where the decays disagree.

    Where half of the decays or more are not linear, poles that are common to all describe none of them, and split. Then
    each mode is that of the single decays at the middle of the amplitudes that all of them met (see
    `Repeats.amplitude_dependence`), where they are compared; it is one that half of them hold.

    Parameters
    ----------
    response : control.TimeResponseData or what `as_record` takes, or several
        One recording with several decays, or several records with the same channels and rate, each a decay from its
        first sample on.
    decays : sequence of Decay or (float, float), optional
        The stretches of free decay in one recording, or their first and last times [s].
    modes : int, optional
        How many modes: the strongest. Default: all that the decays support.
    band_hz : (float, float), optional
        Frequency range [Hz].
    names : sequence of str, optional
        Names of several records, in messages and tables. Default: ``record 1``, ``record 2``, ….

    Returns
    -------
    Repeats
        Each decay by itself, all jointly, and whether they agree.

    Raises
    ------
    IdentificationError
        If fewer modes than requested are significant; ``.found`` has those found.
    RecordError, InputError
        If a stretch, the record or a setting cannot be used.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import free_decay, quarter_car
    >>> from suspid.records import as_response
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> decay = free_decay(car, np.arange(400) / 100, initial_state={"v_tire": 1.0}).y
    >>> noise = 1e-5 * np.random.default_rng(1).standard_normal((2, 800))
    >>> record = as_response(np.arange(800) / 100, np.hstack([decay, 0.5 * decay]) + noise, ["chassis", "tire"])
    >>> found = identify_repeats(record, [(0, 3.99), (4, 7.99)])
    >>> (found.modes.wn / (2 * np.pi)).round(2)
    array([ 1.08, 11.68])
    """
    check_count("modes", modes)
    parts = _stretches(response, decays, names)
    each = tuple(_identified(name, part, band_hz) for name, part in parts)
    signals = [as_signal(held(found, "response"), least=FEWEST_SAMPLES) for found in each]
    spans = tuple((s.start, s.start + s.step * (s.values.shape[1] - 1)) for s in signals)
    if sum(bool(found.forces) for found in each) >= BENT_SHARE * len(each):
        return _of_bent_decays(each, spans, modes, tuple(names))
    step, channels = signals[0].step, signals[0].channels
    values = [s.values - s.values.mean(axis=1, keepdims=True) for s in signals]
    noises = [noise_of(s.values) for s in signals]
    low, high = angular(band_hz) or (0.0, np.pi / step)
    lengths = np.array([v.shape[1] for v in values])
    stacked = np.flatnonzero(lengths >= LONG_ENOUGH * np.median(lengths))
    common = int(np.min(lengths[stacked]))
    beside = np.vstack([signals[r].values[:, :common] for r in stacked])
    selection = select(
        beside - beside.mean(axis=1, keepdims=True),
        noise=WhiteNoise(least=np.concatenate([noises[r].least for r in stacked])),
        modes=modes,
        band=(low * step, high * step),
    )
    blocks = [blocks_of(v) for v in values]
    noises = [noise.rounded(b.energy, b.count, of_energies=True) for noise, b in zip(noises, blocks, strict=True)]
    poles = selection.fit.poles
    # A drift is as slow as its repeat is long.
    start = [replace(poles, nuisances=poles.nuisances * (common / length)) for length in lengths]
    fits = maximize_jointly(blocks, start, noises)
    kept = selection.modes
    agreements = [agreement(blocks, fits, noises, int(index)) for index in kept]
    loudness = selection.loudness[kept]
    shared = shared_noise(_end_to_end(selection.residual, repeats=len(stacked)))
    joint = joint_covariance(fits, kept, np.maximum(loudness * shared, [a.widening for a in agreements]))
    found, order = joint.modes(step=step, channels=channels), np.argsort(np.abs(joint.exponents), kind="stable")
    split = len(found) > max(len(one.modes) for one in each)
    if split and sum(_is_bent(one) for one in each) >= BENT_SHARE * len(each):
        return _of_bent_decays(each, spans, modes, tuple(names))
    _check_enough(found, modes, len(spans))
    return Repeats(
        spans=spans,
        each=each,
        modes=found,
        consistency=tuple(agreements[k] for k in order),
        loudness=frozen_real(loudness[order]),
        noise_std=frozen_real([np.sqrt(fit.squares / fit.freedom) for fit in fits]),
        names=tuple(names),
    )


def _is_bent(found: Identification) -> bool:
    """Return whether no linear fit describes a decay: much is left near its modes, or they have harmonics."""
    harmonics = removed_as(found.considered, Reason.HARMONIC)
    return bool(np.any(found.loudness > OTHER_THAN_NOISE)) or bool(harmonics)


def _of_bent_decays(
    each: tuple[Identification, ...],
    spans: tuple[tuple[Second, Second], ...],
    modes: int | None,
    names: tuple[str, ...],
) -> Repeats:
    """Return what decays share that depend on their amplitude."""
    found = joined(each)
    _check_enough(found.modes, modes, len(spans))
    if modes is not None and modes < len(found.modes):
        found = strongest(found, modes)
    return Repeats(
        spans=spans,
        each=each,
        modes=found.modes,
        consistency=found.consistency,
        loudness=found.loudness,
        noise_std=frozen_real([one.noise_std for one in each]),
        amplitude_dependence=found.amplitude_dependence,
        names=names,
    )


def _check_enough(found: ModalSet, modes: int | None, repeats: int) -> None:
    """Refuse fewer modes than were requested."""
    if modes is not None and len(found) < modes:
        raise IdentificationError(
            f"{modes} modes were requested, {len(found)} could be found in {repeats} repeats",
            found=found if len(found) else None,
        )


def _stretches(
    response: RecordLike | Sequence[RecordLike],
    decays: Sequence[Stretch | tuple[Second, Second]] | None,
    names: Sequence[str],
) -> list[tuple[str, control.TimeResponseData]]:
    """Return each decay with its name in messages."""
    if isinstance(response, list | tuple) and not is_pair(response):
        if decays is not None:
            raise InputError("decays are stretches of one recording; several records are decays as they are")
        called = names or [f"record {number}" for number in range(1, len(response) + 1)]
        parts = list(zip(called, map(as_record, response), strict=True))
        _check_alike(parts)
    else:
        spans = [(d.start, d.stop) if not isinstance(d, tuple) else (float(d[0]), float(d[1])) for d in decays or ()]
        stretches = [f"the decay {start:g} … {stop:g} s" for start, stop in spans]
        record = as_record(response)
        parts = [(name, _cut(name, record, *span)) for name, span in zip(stretches, spans, strict=True)]
    if not parts:
        raise InputError("no decay given; give at least one, as from find_decays, or (start, stop) in seconds")
    return parts


def _check_alike(parts: Sequence[tuple[str, control.TimeResponseData]]) -> None:
    """Refuse records of other channels or of another rate: they are not repeats of one test."""
    signals, first = [as_signal(part) for _, part in parts], parts[0][0] if parts else ""
    for (name, _), signal in zip(parts, signals, strict=True):
        if signal.channels != signals[0].channels:
            raise InputError(
                f"{name} has the channels {', '.join(signal.channels)}, {first} has {', '.join(signals[0].channels)}; "
                f"choose the same channels, in the same order, from each"
            )
        if abs(signal.step - signals[0].step) > EQUAL_RATE * signals[0].step:
            raise InputError(
                f"{name} is sampled at {1 / signal.step:.7g} Hz, {first} at {1 / signals[0].step:.7g} Hz; repeats "
                f"are joined at one rate only: identify them separately and compare"
            )


def _cut(name: str, response: control.TimeResponseData, start: Second, stop: Second) -> control.TimeResponseData:
    try:
        return cut(response, start=start, stop=stop)
    except RecordError as error:
        raise RecordError(f"{name} cannot be used: ", error.wording) from error


def _identified(name: str, part: control.TimeResponseData, band_hz: tuple[Hertz, Hertz] | None) -> Identification:
    try:
        return identify(part, band_hz=band_hz)
    except RecordError as error:
        raise RecordError(f"{name} cannot be used: ", error.wording) from error
    except IdentificationError as error:
        raise IdentificationError(f"{name}: ", error.wording, found=error.found) from error


def _end_to_end(residual: RealArray, *, repeats: int) -> RealArray:
    """Return the residuals of repeats (repeat · channel, sample) end to end, each of unit power."""
    power = np.sqrt(np.mean(residual**2, axis=1, keepdims=True))
    unit = residual / np.where(power > 0, power, 1.0)
    return unit.reshape(repeats, -1, residual.shape[1]).transpose(1, 0, 2).reshape(len(residual) // repeats, -1)
