"""From a record to its modes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np

from suspid.cleaning import clipped_run
from suspid.errors import IdentificationError, InputError, RecordError
from suspid.identification.halves import FEWEST_SAMPLES, disagreement
from suspid.identification.modal_estimate import modes_of
from suspid.identification.noise import lag_one, noise_correlation, noise_of, shared_noise
from suspid.identification.poles import Poles
from suspid.identification.selection import Selection, select
from suspid.model import ModalSet
from suspid.signals import Signal, as_response, as_signal
from suspid.units import ComplexArray, RadianPerSecond, RealArray
from suspid.values import frozen_real, text_table
from suspid.wavelets import (
    BandwidthSearch,
    Ridge,
    Scalogram,
    SkeletonFit,
    best_bandwidth,
    cwt,
    find_ridges,
    fit_ridges,
    fit_skeleton,
    sample_noise,
)

if TYPE_CHECKING:
    import control

# Rows of the scalogram per octave: a third of the width of the narrowest row in use.
PER_OCTAVE = 24
# Where ridges are looked for: from this many cycles in the record to this share of the Nyquist frequency.
LEAST_CYCLES = 4.0
HIGHEST = 0.9
# Each ridge may use the wavelet of least entropy or one shorter by these factors.
SHORTER = (1.0, 0.5, 0.25, 0.125)
# Ridges are found on a scalogram of this precision; their skeletons are then transformed anew, to rounding.
TO_LOOK_AT = 1e-6
# How many of the poles that are no modes the table shows.
MOST_SHOWN = 6

REASONS: dict[str, str] = {
    "tone": "a tone: it does not decay within the record",
    "drift": "a drift: it decays more slowly than the record lasts",
    "growing": "it grows",
    "under a cycle": "under one cycle in the record",
    "a few samples": "gone after a few samples",
    "outside the band": "outside the band",
    "beyond": "weaker than the modes asked for",
    "real or pair": "one real pole or a heavily damped pair: the record does not tell",
}

Method = Literal["likelihood", "ridge"]


@dataclass(frozen=True, kw_only=True)
class FourSteps:
    """The paper's four steps on one record, each computed when first asked for.

    Parameters
    ----------
    signal : Signal
        The record less its mean.
    count : int or None
        How many ridges; None: all that stand out.
    band : (float, float)
        Angular frequencies of the first and last row [rad/s].
    bandwidth : float or None
        N of the wavelet; None: that of least entropy.
    candidates : tuple of float
        Bandwidths among which to choose.
    """

    signal: Signal
    count: int | None
    band: tuple[RadianPerSecond, RadianPerSecond]
    bandwidth: float | None
    candidates: tuple[float, ...]

    @cached_property
    def response(self) -> control.TimeResponseData:
        """The record less its mean."""
        return as_response(self.signal.timepts, self.signal.values, self.signal.channels)

    @cached_property
    def omega(self) -> RealArray:
        """Angular frequencies of the rows [rad/s], (row,): the band, evenly spaced in its logarithm."""
        low, high = self.band
        return frozen_real(np.geomspace(low, high, max(8, int(np.ceil(PER_OCTAVE * np.log2(high / low))))))

    @cached_property
    def search(self) -> BandwidthSearch | None:
        """Step 1: entropy against bandwidth; None if the bandwidth was given."""
        if self.bandwidth is not None:
            return None
        return best_bandwidth(self.response, omega=self.omega, candidates=self.candidates)

    @cached_property
    def scalogram(self) -> Scalogram:
        """Step 2: the transform with the bandwidth given or of least entropy."""
        bandwidth = self.bandwidth if self.search is None else self.search.best
        assert bandwidth is not None
        return cwt(self.response, omega=self.omega, bandwidth=bandwidth, precision=TO_LOOK_AT)

    @cached_property
    def ridges(self) -> tuple[Ridge, ...]:
        """Step 3: each ridge with the wavelet, of that one and shorter ones, that leaves its pole least uncertain."""
        attempts: list[tuple[Ridge, ...]] = []
        failure: IdentificationError | None = None
        for factor in SHORTER:
            transform = self.scalogram
            if factor != 1.0:
                bandwidth = self.scalogram.wavelet.bandwidth * factor
                transform = cwt(self.response, omega=self.omega, bandwidth=bandwidth, precision=TO_LOOK_AT)
            try:
                attempts.append(find_ridges(transform, count=self.count))
            except IdentificationError as error:
                failure = failure or error
        if not attempts:
            assert failure is not None
            raise failure
        steady = []
        for ridge in attempts[0]:
            same = [r for other in attempts for r in other if abs(np.log(r.omega / ridge.omega)) < 0.02]
            steady.append(min(same, key=lambda r: fit_skeleton(r).variance))
        return tuple(steady)

    @cached_property
    def modes(self) -> ModalSet:
        """Step 4: modes from the lines through the skeletons."""
        return fit_ridges(self.ridges)


@dataclass(frozen=True, kw_only=True, slots=True)
class Considered:
    """A pole that was met on the way and is not among the modes.

    Parameters
    ----------
    pole : complex
        Where it lies [rad/s].
    reason : str
        Why it is no mode.
    removed : bool
        Whether its motion was taken out of the record with the fit (a tone, a drift), or left in the residual.
    """

    pole: complex
    reason: str
    removed: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class Identification:
    """What `identify` found, and all that is needed to judge it.

    Parameters
    ----------
    response : control.TimeResponseData
        The record.
    method : {"likelihood", "ridge"}
        How it was identified.
    modes : ModalSet
        The modes, with their uncertainty.
    fitted : control.TimeResponseData
        The motion that was found (with offset, tones and drift), as it fits the record.
    residual : control.TimeResponseData
        The record less `fitted`.
    noise_std : ndarray (channel,)
        Standard deviation of the noise, in the unit of each channel.
    loudness : ndarray (mode,)
        Power of the residual near each mode over that of the noise [1]. Where it is above 1 the covariance
        of the mode is widened by it, or by the square of `halves` if that is more. Ones for method "ridge".
    considered : tuple of Considered
        What else was met, and why it is no mode.
    steps : FourSteps
        The wavelet's view of the record.
    """

    response: control.TimeResponseData
    method: Method
    modes: ModalSet
    fitted: control.TimeResponseData
    residual: control.TimeResponseData
    noise_std: RealArray
    loudness: RealArray
    considered: tuple[Considered, ...]
    steps: FourSteps

    @property
    def bandwidth_search(self) -> BandwidthSearch | None:
        """Entropy against bandwidth; None if the bandwidth was given."""
        return self.steps.search

    @property
    def scalogram(self) -> Scalogram:
        """The transform of the record less its mean."""
        return self.steps.scalogram

    @property
    def ridges(self) -> tuple[Ridge, ...]:
        """The ridges that stand out, each with its own wavelet, skeleton and window; perhaps none."""
        try:
            return self.steps.ridges
        except IdentificationError:
            return ()

    @property
    def ridge_modes(self) -> ModalSet:
        """The modes from the ridges alone; perhaps none."""
        return fit_ridges(self.ridges) if self.ridges else _no_modes(as_signal(self.response))

    @property
    def lines(self) -> tuple[SkeletonFit, ...]:
        """The lines through log modulus and phase of each ridge."""
        return tuple(fit_skeleton(ridge) for ridge in self.ridges)

    @property
    def explained(self) -> RealArray:
        """Share of each channel's energy about its mean that the fit explains [1], (channel,)."""
        signal, left = as_signal(self.response).values, as_signal(self.residual).values
        energy = np.sum((signal - signal.mean(axis=1, keepdims=True)) ** 2, axis=1)
        return np.asarray(1 - np.sum(left**2, axis=1) / np.where(energy > 0, energy, 1.0))

    @property
    def whiteness(self) -> RealArray:
        """Correlation of each channel's residual with itself one sample later [1], (channel,): 0 for white noise."""
        return lag_one(as_signal(self.residual).values)

    @property
    def collinearity(self) -> RealArray:
        """Modal phase collinearity [1], (mode,): 1 if all channels move in phase or in antiphase, 0 if they circle."""
        assert self.modes.shapes is not None
        re, im = self.modes.shapes.real, self.modes.shapes.imag
        xx, yy, xy = np.sum(re**2, axis=0), np.sum(im**2, axis=0), np.sum(re * im, axis=0)
        total = np.where(xx + yy > 0, xx + yy, 1.0)
        return np.asarray(((xx - yy) ** 2 + 4 * xy**2) / total**2)

    @cached_property
    def halves(self) -> RealArray:
        """How far the two halves of the decay disagree on each mode [1], (mode,), in their standard deviations.

        The record is cut where half of what it says of the mode's pole lies before, and all poles are fitted to
        each part alone, starting from `modes`. The figure is the distance of the two poles over its standard
        deviation in the noise, root mean square of real and imaginary part: about 1 for a linear decay. It is
        NaN for a real pole, and where a part does not hold the mode.
        """
        signal = as_signal(self.response)
        every = np.array([*self.modes.poles, *(c.pole for c in self.considered if c.removed)]) * signal.step
        pair = every.imag > 0
        poles = Poles(pairs=np.asarray(every[pair], complex), reals=every[~pair].real, nuisances=np.zeros(1))
        place = np.cumsum(pair) - 1
        return frozen_real(
            [
                disagreement(signal.values, poles, int(place[mode]), self.noise_std) if pair[mode] else np.nan
                for mode in range(len(self.modes))
            ]
        )

    def __str__(self) -> str:
        if len(self.modes):
            quality = {
                "mode": [str(i + 1) for i in range(len(self.modes))],
                "phase collinearity": [f"{value:.3f}" for value in self.collinearity],
                "halves apart [sd]": [f"{value:.1f}" for value in self.halves],
                "residual beside / noise": [f"{value:.3g}" for value in self.loudness],
            }
            found = f"{self.modes}\n\n{text_table(quality)}"
        elif any(c.reason in (REASONS["outside the band"], REASONS["beyond"]) for c in self.considered):
            found = "no mode in the band; those outside it are listed below"
        elif np.max(self.explained) > 0.5 or any(
            c.removed or "part of another mode" in c.reason for c in self.considered
        ):
            found = "no mode: what moves in the record is no free decay of modes, see below"
        else:
            found = "no mode: nothing in the record decays like one and stands above its noise"
        channels = {
            "channel": as_signal(self.response).channels,
            "explained": [f"{100 * share:.2f} %" for share in self.explained],
            "noise std": [f"{std:.3g}" for std in self.noise_std],
            "lag-1 correlation": [f"{value:+.2f}" for value in self.whiteness],
        }
        parts = [found]
        loud = [str(i + 1) for i, ratio in enumerate(self.loudness) if ratio > 1]
        if loud:
            parts.append(
                f"Beside mode {', '.join(loud)} the residual is louder than white noise: the noise is coloured, or the "
                f"decay is not quite linear or not alone; the intervals are widened for it."
            )
        if len(self.modes) and shared_noise(as_signal(self.residual).values) > 1:
            parts.append(_shared_in_words(as_signal(self.residual)))
        late = late_start(as_signal(self.response))
        if late is not None and (loud or not len(self.modes)):
            parts.append(
                f"The largest motion comes {late - as_signal(self.response).start:.3g} s after the start: if the decay "
                f"begins there, cut the record to it, from t = {late:.6g} s on."
            )
        if self.method == "ridge":
            parts.append(text_table(_ridge_columns(self.ridges)))
        parts.append(text_table(channels))
        if self.considered:
            shown = self.considered[:MOST_SHOWN]
            others = {
                "considered: wn [rad/s]": [f"{abs(c.pole):.5g}" for c in shown],
                "zeta [1]": [f"{-c.pole.real / max(abs(c.pole), 1e-300):.3g}" for c in shown],
                "not a mode because": [c.reason for c in shown],
            }
            more = len(self.considered) - len(shown)
            parts.append(text_table(others) + (f"\n… and {more} more in .considered" if more else ""))
        return "\n\n".join(parts)


def identify(
    response: control.TimeResponseData,
    *,
    modes: int | None = None,
    method: Method = "likelihood",
    band: tuple[RadianPerSecond, RadianPerSecond] | None = None,
    bandwidth: float | None = None,
    candidates: Iterable[float] = range(1, 51),
) -> Identification:
    """Return the modes of a free decay.

    "likelihood" fits the poles of all channels jointly: sums of damped exponentials with amplitudes of
    their own and an offset in every channel, in white noise of unknown level. Poles are added while
    the record pays for them by BIC; tones, drifts and the like are fitted but are no modes. The
    covariance is that of the Cramér-Rao bound at the estimate, widened where the residual is not noise.

    "ridge" is the paper's four steps: the bandwidth N of least wavelet entropy; the transform with it;
    ridges and skeletons; lines through them. Where a wavelet of that N is so long that the edges eat
    the skeleton, N / 2, N / 4 and N / 8 are tried, and each ridge keeps the one that leaves its pole
    the smallest standard deviation. It needs light damping.

    Parameters
    ----------
    response : control.TimeResponseData
        A free decay from its first sample on, uniformly sampled; all channels are used together.
    modes : int, optional
        How many modes: the strongest of those that the record supports. Default: all of them.
    method : {"likelihood", "ridge"}
        See above.
    band : (float, float), optional
        Angular frequencies between which to look [rad/s]. Default: all; for the ridges from four
        cycles in the record to 0.9 of the Nyquist frequency.
    bandwidth : float, optional
        N of the wavelet. Default: that of least entropy among ``candidates``.
    candidates : iterable of float
        Bandwidths among which to choose.

    Returns
    -------
    Identification
        Modes with uncertainty, and all that is needed to judge them. Without ``modes``, the likelihood
        may return no mode at all, and the table says so.

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
        raise InputError(f"{method=} is unknown; the methods are 'likelihood' and 'ridge'")
    if modes is not None and modes < 1:
        raise InputError(f"{modes=}: ask for at least one mode, or leave it out to find out")
    signal = as_signal(response, least=FEWEST_SAMPLES)
    centred = signal.values - signal.values.mean(axis=1, keepdims=True)
    for name, samples, about in zip(signal.channels, signal.values, centred, strict=True):
        if not max(about.max(), -about.min()) > 1e-12 * max(samples.max(), -samples.min()):
            raise IdentificationError(f"channel {name!r} is constant: there is no decay in it; leave it out")
    _check_clipping(signal)
    steps = FourSteps(
        signal=replace(signal, values=centred),
        count=modes,
        band=_band(signal, band),
        bandwidth=bandwidth,
        candidates=tuple(float(n) for n in candidates),
    )
    if method == "ridge":
        return _by_ridges(response, signal, steps)
    return _by_likelihood(response, signal, centred, steps, band)


def _by_ridges(response: control.TimeResponseData, signal: Signal, steps: FourSteps) -> Identification:
    fitted = _decay_of(steps.modes, signal, min(ridge.onset for ridge in steps.ridges))
    return Identification(
        response=response,
        method="ridge",
        modes=steps.modes,
        fitted=as_response(signal.timepts, fitted, signal.channels, title="Fitted decay"),
        residual=as_response(signal.timepts, signal.values - fitted, signal.channels, title="Residual"),
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
) -> Identification:
    low, high = band or (0.0, np.pi / signal.step)
    selection = select(
        centred, noise=noise_of(signal.values), modes=steps.count, band=(low * signal.step, high * signal.step)
    )
    left = selection.residual
    modes, loudness = modes_of(selection, centred, step=signal.step, channels=signal.channels)
    if steps.count is not None and len(modes) < steps.count:
        where = f", at {', '.join(f'{wn:.4g}' for wn in modes.wn)} rad/s" if len(modes) else ""
        raise IdentificationError(
            f"{steps.count} modes were asked for, {len(modes)} could be found{where}; "
            f"nothing else in the record decays like a mode",
            found=modes if len(modes) else None,
        )
    return Identification(
        response=response,
        method="likelihood",
        modes=modes,
        fitted=as_response(signal.timepts, signal.values - left, signal.channels, title="Fitted decay"),
        residual=as_response(signal.timepts, left, signal.channels, title="Residual"),
        noise_std=frozen_real(np.sqrt(np.sum(left**2, axis=1) / selection.fit.freedom)),
        loudness=loudness,
        considered=_considered(selection, signal),
        steps=steps,
    )


def _shared_in_words(residual: Signal) -> str:
    together = np.abs(noise_correlation(residual.values) - np.eye(len(residual.channels)))
    one, other = np.unravel_index(int(np.argmax(together)), together.shape)
    return (
        f"Channels {residual.channels[int(one)]!r} and {residual.channels[int(other)]!r} share noise (the residuals' "
        f"correlation is {together[one, other]:.2f}): they are not two witnesses, and the intervals are widened "
        f"for it. Leave out a channel that is computed from others."
    )


def late_start(signal: Signal) -> float | None:
    """Return when the largest motion comes [s], if that is after a fiftieth of the record, else None."""
    about = np.abs(signal.values - signal.values.mean(axis=1, keepdims=True))
    strength = np.sum((about / np.maximum(about.max(axis=1, keepdims=True), 1e-300)) ** 2, axis=0)
    peak = int(np.argmax(strength))
    return float(signal.timepts[peak]) if peak > 0.02 * signal.values.shape[1] else None


def _considered(selection: Selection, signal: Signal) -> tuple[Considered, ...]:
    """Return what was fitted but is no mode, then what was tried and not kept."""
    every = np.concatenate([selection.fit.poles.pairs, selection.fit.poles.reals])
    removed = tuple(
        Considered(pole=complex(theta) / signal.step, reason=REASONS[str(code)], removed=True)
        for theta, code in zip(every, selection.reasons, strict=True)
        if code is not None
    )
    left = tuple(
        Considered(pole=candidate.theta / signal.step, reason=str(remark), removed=False)
        for candidate, remark in sorted(selection.rejected, key=lambda item: -item[0].gain)
    )
    return removed + left


def _no_modes(signal: Signal) -> ModalSet:
    shapes = np.zeros((len(signal.channels), 0), complex)
    return ModalSet(poles=np.zeros(0, complex), shapes=shapes, channels=signal.channels)


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
                    f"them on end from t = {time[first]:g} s; start the record after t = {time[at[-1]]:g} s, "
                    f"or leave the channel out"
                )


def _band(
    signal: Signal, band: tuple[RadianPerSecond, RadianPerSecond] | None
) -> tuple[RadianPerSecond, RadianPerSecond]:
    """Return the angular frequencies between which ridges are looked for."""
    nyquist = np.pi / signal.step
    low, high = band or (2 * np.pi * LEAST_CYCLES / signal.duration, HIGHEST * nyquist)
    if not 0 < low < high <= nyquist:
        raise InputError(
            f"the band {low:g} … {high:g} rad/s must be two increasing angular frequencies between 0 and "
            f"the Nyquist frequency {nyquist:g} rad/s"
        )
    return float(low), float(min(high, 0.999 * nyquist))


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


def _ridge_columns(ridges: tuple[Ridge, ...]) -> dict[str, list[str]]:
    return {
        "ridge [rad/s]": [f"{ridge.omega:.5g}" for ridge in ridges],
        "N": [f"{ridge.wavelet.bandwidth:.3g}" for ridge in ridges],
        "from [s]": [f"{ridge.window.start:.3g}" for ridge in ridges],
        "to [s]": [f"{ridge.window.stop:.3g}" for ridge in ridges],
        "ends at": [ridge.window.reason for ridge in ridges],
    }
