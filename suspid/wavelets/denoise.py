"""Denoise by shrinking wavelet coefficients: Eq. (8)-(11)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, TypeAlias, get_args

import numpy as np

from suspid.arguments import explained
from suspid.cleaning import RecordLike, as_record
from suspid.errors import InputError
from suspid.records import as_response
from suspid.signals import as_signal
from suspid.units import Hertz, RealArray
from suspid.values import nearest_names
from suspid.wavelets.filter_bank import (
    FilterBank,
    decimated_merge,
    decimated_split,
    filter_bank,
    noise_std,
    stationary_merge,
    stationary_split,
)
from suspid.wavelets.thresholds import RuleName, ThresholdName, shrink, threshold_of
from suspid.wording import Argument

if TYPE_CHECKING:
    import control

NoiseName: TypeAlias = Literal["once", "per-level"]
TransformName: TypeAlias = Literal["stationary", "decimated"]


@explained
def denoise(
    response: RecordLike,
    *,
    fs: Hertz | None = None,
    wavelet: str = "sym8",
    level: int | None = None,
    threshold: ThresholdName = "sure",
    rule: RuleName = "garrote",
    noise: NoiseName = "once",
    transform: TransformName = "stationary",
) -> control.TimeResponseData:
    """Return the response with its wavelet coefficients shrunk towards zero, each channel on its own: Eq. (8)-(11).

    The least-squares line of the record is subtracted first and added back, so offsets and linear drift are kept; the
    rest is continued by reflection at both ends. The default threshold and rule have the smallest error on decays, and
    on the usual test signals an error within 0.2 dB of the smallest (the universal threshold with the hard rule). The
    universal threshold with the soft rule, the usual choice in textbooks, has the largest: it also subtracts
    ``sqrt(2 log n)`` noise deviations from every coefficient of a mode.

    Denoise records to look at them. It adds no information on the modes, and it removes the noise floor from which an
    identification sees the end of a decay: damping ratios identified from a denoised record are worse. Identify from
    the record as measured.

    Parameters
    ----------
    response : control.TimeResponseData, or what `as_record` takes
        One trace, any number of channels, of any length from ``2 (taps - 1)`` samples on (30 for "sym8").
    fs : float, optional
        Sampling rate [Hz] of samples that come without a time.
    wavelet : str
        A discrete wavelet of PyWavelets, orthogonal or biorthogonal. "bior3.1" and "rbio3.1" are unsuitable: their
        gain of noise, or of the shrunk coefficients, grows with every level.
    level : int, optional
        Depth of the decomposition; level j holds frequencies from ``fs / 2^(j + 1)`` to ``fs / 2^j``.
        By default the levels of each channel end above the first one whose median coefficient is 3 times the noise of
        the finest level, and at ``pywt.dwt_max_level``: at such a level a mode rings throughout the record, and a
        threshold would shrink the mode instead of the noise. Noise that grows towards low frequencies looks the same;
        give the level for it.
    threshold : {"sure", "universal", "bayes", "minimax"}
        Threshold in noise deviations: of least Stein risk per level, `sure_threshold`; `universal_threshold`;
        BayesShrink per level, `bayes_threshold`; `minimax_threshold`.
    rule : {"garrote", "soft", "hard"}
        Rule for the coefficients above the threshold, see `shrink`.
    noise : {"once", "per-level"}
        Noise deviation from the median absolute coefficient over 0.6745, of the finest level (white noise) or of each
        level (coloured noise).
    transform : {"stationary", "decimated"}
        The translation-invariant transform (the mean over all shifts of the reflected record, exact for any length),
        or the plain one (faster, with 1 to 2 dB less gain).

    Returns
    -------
    control.TimeResponseData
        Same time stamps and channels. A channel without noise (median 0 to rounding) is unchanged.

    Raises
    ------
    RecordError
        If the record is too short for the wavelet, irregular or not finite.
    InputError
        If a name is unknown, or the level is out of range.

    References
    ----------
    D. L. Donoho, I. M. Johnstone, Biometrika 81 (1994) 425; J. Am. Stat. Assoc. 90 (1995) 1200.
    R. R. Coifman, D. L. Donoho, Translation-invariant de-noising (1995). H.-Y. Gao, J. Comput. Graph. Stat. 7
    (1998) 469 (garrote). S. G. Chang, B. Yu, M. Vetterli, IEEE Trans. Image Process. 9 (2000) 1532 (Bayes).

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import add_noise, free_decay, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> clean = free_decay(car, np.arange(0, 3, 0.002), impulse="road")
    >>> noisy = add_noise(clean, snr_db=10.0, rng=np.random.default_rng(1))
    >>> left = np.std(denoise(noisy).y - clean.y) / np.std(noisy.y - clean.y)
    >>> bool(left < 0.3)
    True
    """
    for keyword, name, known in (
        ("threshold", threshold, get_args(ThresholdName)),
        ("rule", rule, get_args(RuleName)),
        ("noise", noise, get_args(NoiseName)),
        ("transform", transform, get_args(TransformName)),
    ):
        if name not in known:
            raise InputError(f"{keyword}={name!r} is unknown.{nearest_names(str(name), known)}")
    response = as_record(response, fs=fs)
    signal = as_signal(response)
    filters = filter_bank(wavelet, signal.values.shape[1])
    depth = _depth(filters, level)
    split = stationary_split if transform == "stationary" else decimated_split
    merge = stationary_merge if transform == "stationary" else decimated_merge
    cleaned = np.empty_like(signal.values)
    for samples, out in zip(signal.values, cleaned, strict=True):
        line = _straight_line(samples)
        rest = samples - line
        details, rough = split(rest, filters, depth)
        std = noise_std(details, filters)
        # Wavelets of two vanishing moments or more do not see the line; "haar" does, with or without it.
        std[0] = min(std[0], noise_std(split(samples, filters, 1)[0], filters)[0])
        # Smaller noise is rounding: the record is clean.
        if std[0] <= 64 * np.finfo(np.float64).eps * np.max(np.abs(samples)):
            out[:] = samples
            continue
        # From this ratio of its median coefficient to the noise on a level holds signal throughout. The scatter of a
        # median over the dozen coefficients of the coarsest level stays below it; a higher ratio shrinks modes.
        dense = np.flatnonzero(std > 3.0 * std[0]) if level is None else np.array([], int)
        if noise == "once":
            std[:] = std[0]
        for j in range(dense[0] if dense.size else depth):
            unit = std[j] * filters.gains[j]
            if unit > 0:
                scaled = details[j] / unit
                limit = threshold_of(scaled, threshold=threshold, rule=rule, count=samples.size)
                details[j] = unit * shrink(scaled, limit, rule=rule)
        out[:] = line + merge(details, rough, filters)
    return as_response(np.asarray(response.time), cleaned, signal.channels, title=f"Denoised with {wavelet}")


def _depth(filters: FilterBank, level: int | None) -> int:
    if level is None:
        return filters.depth
    if isinstance(level, bool) or not isinstance(level, int | np.integer) or not 1 <= level <= filters.depth:
        raise InputError(
            Argument("level", repr(level)),
            f" is out of range: a record of {filters.count} samples has levels 1 to {filters.depth} "
            f"with {filters.wavelet.name!r}",
        )
    return int(level)


def _straight_line(samples: RealArray) -> RealArray:
    """Return the least-squares line through the samples."""
    ramp = np.linspace(-1.0, 1.0, samples.size)
    return np.asarray(np.mean(samples) + ramp * (ramp @ samples) / (ramp @ ramp))
