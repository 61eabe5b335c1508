"""Identify the modes of a free decay."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from suspid.cleaning import RecordLike, as_record, clipped_run
from suspid.errors import IdentificationError, InputError, RecordError
from suspid.identification.considered import Considered, beside_bent, considered_of
from suspid.identification.covariance import joint_covariance
from suspid.identification.dominant import dominant
from suspid.identification.halves import FEWEST_SAMPLES, disagreement
from suspid.identification.harmonics import without_harmonics
from suspid.identification.identification import Identification, Method
from suspid.identification.noise import WhiteNoise, noise_of, shared_noise
from suspid.identification.nonlinear import (
    AmplitudeDependence,
    Bent,
    find_forces,
    modes_of_bent,
    unlike_linear,
)
from suspid.identification.ongoing import without_lines
from suspid.identification.pulses import without_beginning, without_pulse
from suspid.identification.selection import Selection, select
from suspid.identification.steps import FourSteps
from suspid.levels import NORMAL_95, ROUNDING
from suspid.model import ModalSet
from suspid.samples import as_samples
from suspid.signals import Signal, as_signal
from suspid.threads import in_one_thread
from suspid.units import ComplexArray, Hertz, RadianPerSecond, RealArray, Second, angular
from suspid.values import check_count, frozen_real
from suspid.wavelets import BANDWIDTHS, row_band, sample_noise
from suspid.wording import Argument
from suspid.words import Reason, Remark

if TYPE_CHECKING:
    import control


@in_one_thread
def identify(
    response: RecordLike,
    *,
    fs: Hertz | None = None,
    modes: int | None = None,
    method: Method = "likelihood",
    band_hz: tuple[Hertz, Hertz] | None = None,
    bandwidth: float | None = None,
    candidates: Iterable[float] = BANDWIDTHS,
) -> Identification:
    """Identify the modes of a free decay.

    "likelihood" fits damped exponentials to all channels jointly, by maximum likelihood: common poles, and in each
    channel amplitudes, an offset and white noise of unknown level. Poles are added while BIC decreases, up to 50 pairs.
    Tones and drifts are fitted but are not modes. The covariance is the Cramér-Rao bound at the estimate, widened where
    the residual is not white noise.

    Where the linear fit leaves signs of a decay that is not linear, and no ``band_hz`` is given, friction, drag, and
    cubic and bilinear springs and dampers are fitted as well. They are kept if they explain more than a further pole
    would; with ``modes`` given, if they explain more than their parameters cost. Then ``.forces`` names them,
    ``.modes`` are those of the equivalent linear system over the record, and ``.amplitude_dependence`` has each natural
    frequency and damping ratio over the amplitude.

    "ridge" is the wavelet method of the paper: the bandwidth N of least entropy, the transform, its ridges and
    skeletons, and lines through log modulus and phase. N / 2, N / 4 and N / 8 are tried as well; each ridge keeps the
    bandwidth that leaves its pole the smallest standard deviation. The damping must be light.

    Parameters
    ----------
    response : control.TimeResponseData, or what `as_record` takes
        A free decay from its first sample on, uniformly sampled; all channels are used together.
    fs : float, optional
        Sampling rate [Hz] of samples that come without a time.
    modes : int, optional
        Number of modes: the strongest of those that the record supports. Poles beside them in frequency are then left
        out, and the others are fitted anew. Default: all modes.
    method : {"likelihood", "ridge"}
        See above.
    band_hz : (float, float), optional
        Frequencies between which to look [Hz]. Default: all; for the ridges from four
        cycles in the record to 0.9 of the Nyquist frequency.
    bandwidth : float, optional
        N of the wavelet. Default: that of least entropy among ``candidates``.
    candidates : iterable of float
        Bandwidths among which to choose.

    Returns
    -------
    Identification
        Modes with uncertainty, and all that is needed to judge them. Without ``modes`` there may be no mode at all; the
        verdict says why.

    Raises
    ------
    IdentificationError
        If fewer modes than asked for stand out; ``.found`` holds those found.
    RecordError, InputError
        If the record or a setting cannot be used.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import add_noise, free_decay, quarter_car
    >>> car = quarter_car(seat_mass=200, chassis_mass=200, tire_mass=200,
    ...                   seat_stiffness=200e3, chassis_stiffness=400e3, tire_stiffness=800e3,
    ...                   seat_damping=300, chassis_damping=200, tire_damping=100)
    >>> record = free_decay(car, np.arange(0, 10, 0.002), initial_state={"v_tire": 1.0})
    >>> identify(record).modes.wn.round(4)
    array([21.2737, 50.1386, 83.8549])
    >>> noisy = add_noise(record, snr_db=20.0, rng=np.random.default_rng(1))
    >>> len(identify(noisy).modes)
    3
    """
    if method not in ("likelihood", "ridge"):
        raise InputError(Argument("method", repr(method)), " is unknown; the methods are 'likelihood' and 'ridge'")
    check_count("modes", modes)
    response = as_record(response, fs=fs)
    signal = as_signal(response, least=FEWEST_SAMPLES)
    centred = _centred(signal)
    band = angular(band_hz)
    steps = FourSteps(
        signal=replace(signal, values=centred),
        count=modes,
        band=row_band(signal, band),
        bandwidth=bandwidth,
        candidates=tuple(float(n) for n in candidates),
    )
    if method == "ridge":
        return _by_ridges(response, signal, steps)
    return _by_likelihood(response, signal, centred, steps, band, with_forces=band is None)


def identify_linear(response: control.TimeResponseData) -> Identification:
    """Identify the modes of a free decay by its linear fit alone: friction and other forces are not looked for."""
    signal = as_signal(response, least=FEWEST_SAMPLES)
    centred = _centred(signal)
    steps = FourSteps(
        signal=replace(signal, values=centred), count=None, band=row_band(signal, None), bandwidth=None,
        candidates=tuple(map(float, BANDWIDTHS)),
    )  # fmt: skip
    return _by_likelihood(response, signal, centred, steps, None, with_forces=False)


def _centred(signal: Signal) -> RealArray:
    """Return the samples less their means, or refuse channels that are constant or clipped."""
    centred = signal.values - signal.values.mean(axis=1, keepdims=True)
    for name, samples, about in zip(signal.channels, signal.values, centred, strict=True):
        if not max(about.max(), -about.min()) > ROUNDING * max(samples.max(), -samples.min()):
            raise IdentificationError(f"channel {name!r} is constant: there is no decay in it; leave it out")
    _check_clipping(signal)
    return np.asarray(centred)


def _by_ridges(response: control.TimeResponseData, signal: Signal, steps: FourSteps) -> Identification:
    fitted = _decay_of(steps.modes, signal, min(ridge.onset for ridge in steps.ridges))
    return Identification(
        response=response,
        method="ridge",
        modes=steps.modes,
        fitted=as_samples(signal.timepts, fitted, signal.channels, title="Fitted decay"),
        residual=as_samples(signal.timepts, signal.values - fitted, signal.channels, title="Residual"),
        noise_std=frozen_real(sample_noise(signal)),
        loudness=frozen_real(np.ones(len(steps.modes))),
        considered=(),
        steps=steps,
    )


def _by_likelihood(
    response: control.TimeResponseData,
    signal: Signal,
    centred: RealArray,
    steps: FourSteps,
    band: tuple[RadianPerSecond, RadianPerSecond] | None,
    *,
    with_forces: bool,
) -> Identification:
    low, high = band or (0.0, np.pi / signal.step)
    noise = noise_of(signal.values)
    limits = (low * signal.step, high * signal.step)
    selection = select(centred, noise=noise, modes=steps.count, band=limits)
    bent = None
    if with_forces and _fades(centred) and unlike_linear(selection):
        bent = find_forces(centred, noise=noise, selection=selection, modes=steps.count)
        if bent is not None and bent.count < (steps.count or 0) <= len(selection.modes):
            bent = None
    described = None if bent is None else _described(bent, signal, steps.count)
    if bent is not None and described is not None:
        modes, loudness, dependence, growing = described
        _check_count(modes, steps.count)
        left, freedom, forces = bent.residual, bent.freedom, bent.forces
        considered = (*growing, *beside_bent(selection, modes, signal.step))
    else:
        if steps.count is None:
            selection = without_pulse(without_beginning(without_lines(selection)), centred)
            if not len(selection.modes):
                selection = dominant(centred, noise=noise, band=limits, selection=selection) or selection
        modes, loudness = _modes_of(selection, centred, noise, step=signal.step, channels=signal.channels)
        fewer = selection if steps.count is not None else _fewer(selection, modes)
        if fewer is not selection:
            selection = fewer
            modes, loudness = _modes_of(selection, centred, noise, step=signal.step, channels=signal.channels)
        _check_count(modes, steps.count)
        left, freedom, forces = selection.residual, selection.fit.freedom, ()
        considered, dependence = considered_of(selection, modes, signal.step), ()
    return Identification(
        response=response,
        method="likelihood",
        modes=modes,
        fitted=as_samples(signal.timepts, signal.values - left, signal.channels, title="Fitted decay"),
        residual=as_samples(signal.timepts, left, signal.channels, title="Residual"),
        noise_std=frozen_real(np.sqrt(np.sum(left**2, axis=1) / freedom)),
        loudness=loudness,
        considered=considered,
        steps=steps,
        amplitude_dependence=dependence,
        forces=forces,
    )


def _described(
    bent: Bent, signal: Signal, count: int | None
) -> tuple[ModalSet, RealArray, tuple[AmplitudeDependence, ...], tuple[Considered, ...]] | None:
    """Return the modes under forces, how loud the residual is near each, their amplitudes, and the poles that grow.

    Without a number of modes, one that grows over most of its amplitudes is none; None if no other is left.
    """
    modes, loudness, dependence = modes_of_bent(bent, timepts=signal.timepts, channels=signal.channels)
    falls = np.array([count is not None or np.median(each.zeta) >= 0 for each in dependence], bool)
    if falls.all():
        return modes, loudness, dependence, ()
    if not falls.any():
        return None
    growing = [Considered(pole=complex(p), remark=Remark(Reason.GROWING), removed=True) for p in modes.poles[~falls]]
    kept = tuple(each for each, fall in zip(dependence, falls, strict=True) if fall)
    return modes[falls], frozen_real(loudness[falls]), kept, tuple(growing)


def _check_count(modes: ModalSet, count: int | None) -> None:
    """Refuse fewer modes than were asked for."""
    if count is not None and len(modes) < count:
        where = f", at {', '.join(f'{wn:.4g}' for wn in modes.wn)} rad/s" if len(modes) else ""
        raise IdentificationError(
            f"{count} modes were asked for, {len(modes)} could be found{where}; "
            f"nothing else in the record decays like a mode: ask for fewer, or leave their number open",
            found=modes if len(modes) else None,
        )


def _fades(values: RealArray) -> bool:
    """Return whether the last third of a record moves less than the first, each about its own mean."""
    third = values.shape[1] // 3
    first, last = np.var(values[:, :third], axis=1), np.var(values[:, -third:], axis=1)
    # A larger ratio spends more time on noise, with a smaller one slow decays stay linear.
    return bool(np.sum(last / np.var(values, axis=1)) < 0.9 * np.sum(first / np.var(values, axis=1)))


def _modes_of(
    selection: Selection, values: RealArray, noise: WhiteNoise, *, step: Second, channels: tuple[str, ...]
) -> tuple[ModalSet, RealArray]:
    """Return the modes of one decay and how loud the residual is near each, (mode,).

    The variances of a mode are widened by its loudness, and by noise that the channels share; or by the square of the
    disagreement of the two halves of the decay where that is more and the residual shows that it is no chance. Where a
    mode may be two, its interval and those beside it hold what the fit with both says.
    """
    fit, kept = selection.fit, selection.modes
    loudness = selection.loudness[kept]
    widening = loudness * shared_noise(selection.residual, np.sqrt(noise.least))
    noise_std = np.sqrt(fit.squares / fit.count)
    for k in np.flatnonzero(((loudness > 1) | selection.bends[kept]) & (kept < len(fit.poles.pairs))):
        widening[k] = np.nanmax([widening[k], disagreement(values, fit.poles, int(kept[k]), noise_std) ** 2])
    widening = np.maximum(widening, selection.widening[kept])
    joint = joint_covariance([fit], kept, widening)
    order = np.argsort(np.abs(joint.exponents), kind="stable")
    return joint.modes(step=step, channels=channels), frozen_real(loudness[order])


def _fewer(selection: Selection, modes: ModalSet) -> Selection:
    """Return the poles, of which multiples of a stronger mode, and those whose frequency may be zero, are no modes."""
    kept = selection.modes
    fewer = without_harmonics(selection, modes)
    if modes.wn_std is None or not np.any(unknown := (modes.poles.imag > 0) & (modes.wn < NORMAL_95 * modes.wn_std)):
        return fewer
    order = kept[np.argsort(np.abs(selection.fit.poles.every[kept]), kind="stable")]
    reasons = list(fewer.reasons)
    for k in order[unknown].tolist():
        reasons[k] = Reason.UNKNOWN
    return replace(fewer, reasons=tuple(reasons))


def _check_clipping(signal: Signal) -> None:
    """Refuse a channel that stays at its largest or smallest value while it is moving fast."""
    for name, samples in zip(signal.channels, signal.values, strict=True):
        for largest, word in ((True, "largest"), (False, "smallest")):
            run = clipped_run(samples, largest=largest)
            if run is not None:
                first, count = run
                limit, time = samples[first], signal.timepts
                at = np.flatnonzero(samples == limit)
                raise RecordError(
                    f"channel {name!r} is clipped: {len(at)} samples are at its {word} value {limit:g}, {count} of "
                    f"them consecutive from t = {time[first]:g} s; start the record after t = {time[at[-1]]:g} s, "
                    f"or leave the channel out"
                )


def _decay_of(modes: ModalSet, signal: Signal, onset: float) -> RealArray:
    """Return the sum of the modes' decays and a constant nearest to the record from the onset on, (channel, sample)."""
    elapsed = signal.timepts - onset
    since = elapsed >= -0.5 * signal.step
    powers: ComplexArray = np.exp(modes.poles * elapsed[since, None])
    basis = np.column_stack([powers.real, powers.imag[:, modes.poles.imag > 0], np.ones(len(powers))])
    amplitudes, *_ = np.linalg.lstsq(basis, signal.values[:, since].T, rcond=None)
    fitted = np.zeros_like(signal.values)
    fitted[:, since] = (basis @ amplitudes).T
    return fitted
