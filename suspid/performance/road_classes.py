"""Class of a measured road after ISO 8608, with its interval."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from suspid.arguments import explained
from suspid.cleaning import RecordLike, as_record, to_si
from suspid.errors import InputError
from suspid.io import bare_name, bracketed_unit
from suspid.levels import LEVEL, check_level, likely, normal_reach
from suspid.results import Result
from suspid.signals import Signal, as_signal
from suspid.simulation import REFERENCE, ROUGHNESS, WAVELENGTHS, checked_wavelengths, road_class
from suspid.text_tables import spread, text_table
from suspid.units import Metre, Ratio, RealArray
from suspid.values import FrozenMapping, frozen_real, nearest_names
from suspid.words import Check, Level, Number, Remark, Verdict
from suspid.words.ride import RoadCheck, RoadHeadline

# Upper limits of G_d(0.1 cycle/m) of the classes [m3], ISO 8608, table C.1 as publications quote it; H has none.
ROAD_LIMITS: Mapping[str, float] = FrozenMapping(
    {name: 2 * mean if name != "H" else np.inf for name, mean in ROUGHNESS.items()}
)
# Exponents of measured roads are 1.5 to 3; beyond these a spectrum is that of noise, or of a filter.
EXPONENTS, LEAST_MEASURED = (1.0, 4.0), 1.5
# Fewest spectral lines from which a level and an exponent are told, and lines of each piece of the test of a bend.
FEWEST_WAVES, LINES_OF_PIECE = 20, 16
# Shares of half the sampling rate up to which lines are used: the largest one at which folding is no matter. Heights
# are points of a road with shorter waves, which fold into those lines: at the exponent 2 they add 11 % at a half.
UNFOLDED = tuple((0.5 * 0.8 ** np.arange(12)).tolist())
# Share of the mean square slope, under a Hann window, from which a few lines beside each other are waves of one length
# and no road. None of 20 000 of the shortest records of roads with exponents up to 3 has more; at 4 one of 300.
ONE_WAVE, LINES_OF_WAVE = 0.99, 5
# Mean square of the lines' departures from the fit, over that of a random road, below which the road is no random one:
# with the fewest lines one of a hundred thousand has less.
LEAST_SCATTER = 0.15
# Largest step of the logarithm of a line in the search of the fit: from far off, the next would be too far.
LARGEST_LOG_STEP = 2.0
# Error by folding, in standard deviations, up to which it is none: intervals of 95 % then hold 94.5 %.
MOST_FOLDING = 0.2


@dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)
class RoadClass(Result):
    """Level and exponent of a road's spectrum, with their uncertainty, and its class.

    Parameters
    ----------
    roughness : float
        G_d(0.1 cycle/m) [m3].
    exponent : float
        Exponent w of ``G_d(n) = G_d(n_0) (n / n_0)^-w`` [1].
    covariance : ndarray (2, 2)
        Joint covariance of the logarithm of the roughness and of the exponent.
    wavelengths : tuple of float
        Shortest and longest wavelength that was used [m].
    verdict : Verdict
        The class and how sure it is.

    Examples
    --------
    >>> from suspid import classify_road, road
    >>> heights = road("B", speed=20.0).record(np.arange(0, 30, 0.01), rng=np.random.default_rng(1))
    >>> found = classify_road(heights, speed=20.0)
    >>> found.name, max(found.shares, key=found.shares.get)
    ('B', 'B')
    """

    roughness: float
    exponent: float
    covariance: RealArray
    wavelengths: tuple[Metre, Metre]
    verdict: Verdict

    @property
    def name(self) -> str:
        """Class ``"A"`` to ``"H"``.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import classify_road, road
        >>> heights = road("B", speed=20.0).record(np.arange(0, 30, 0.01), rng=np.random.default_rng(1))
        >>> found = classify_road(heights, speed=20.0)
        >>> found.name
        'B'
        """
        return road_class(self.roughness)

    @property
    def shares(self) -> dict[str, float]:
        """Probability of each class.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import classify_road, road
        >>> heights = road("B", speed=20.0).record(np.arange(0, 30, 0.01), rng=np.random.default_rng(1))
        >>> found = classify_road(heights, speed=20.0)
        >>> round(sum(found.shares.values()), 6)
        1.0
        """
        return class_shares(self.roughness, float(np.sqrt(self.covariance[0, 0])))

    def interval(self, level: Ratio = LEVEL) -> dict[str, tuple[float, float]]:
        """Return the ends between which roughness and exponent lie with probability ``level``.

        Raises
        ------
        InputError
            If the level is not between 0 and 1.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import classify_road, road
        >>> heights = road("B", speed=20.0).record(np.arange(0, 30, 0.01), rng=np.random.default_rng(1))
        >>> found = classify_road(heights, speed=20.0)
        >>> low, high = found.interval(0.95)["roughness"]
        >>> bool(low < 64e-6 < high)
        True
        """
        check_level(level)
        reach = normal_reach(level) * np.sqrt(np.diag(self.covariance))
        factor = float(np.exp(reach[0]))
        return {
            "roughness": (self.roughness / factor, self.roughness * factor),
            "exponent": (self.exponent - float(reach[1]), self.exponent + float(reach[1])),
        }

    def _table(self) -> Mapping[str, Sequence[object]]:
        ends = self.interval()
        return {
            "name": ["roughness", "exponent"],
            "unit": ["m3", "1"],
            "value": [self.roughness, self.exponent],
            "lower": [ends["roughness"][0], ends["exponent"][0]],
            "upper": [ends["roughness"][1], ends["exponent"][1]],
        }

    def _brief(self) -> str:
        return str(self.verdict.headline)

    def __str__(self) -> str:
        stds = np.sqrt(np.diag(self.covariance)) * [1e6 * self.roughness, 1.0]
        rows = {
            "road": ["G_d(0.1 cycle/m)", "exponent"],
            "unit": ["1e-6 m3", "1"],
            "found": [f"{1e6 * self.roughness:.4g}", f"{self.exponent:.3f}"],
            "±": [spread(std) for std in stds.tolist()],
        }
        return f"{text_table(rows)}\n{self.verdict}"


@explained
def classify_road(
    record: RecordLike,
    *,
    speed: ArrayLike,
    channel: str | None = None,
    wavelengths: tuple[Metre, Metre] = WAVELENGTHS,
) -> RoadClass:
    """Return the class of a road after ISO 8608, from its measured heights, with interval.

    The spectrum of the road's slope over distance is fitted by maximum likelihood (Whittle) to
    ``G_d(n) = G_d(n_0) (n / n_0)^-w`` within the wavelengths, at ``n_0 = 0.1`` cycle/m.

    Parameters
    ----------
    record : control.TimeResponseData, or what `as_record` takes
        Heights of the road over time [m].
    speed : float or array_like (sample,)
        Speed, constant or at each sample [m/s], positive.
    channel : str, optional
        The heights. Default: the first channel.
    wavelengths : tuple of float
        Shortest and longest wavelength to use [m]; shorter ones than the samples hold with certainty are left out.

    Returns
    -------
    RoadClass
        Level, exponent, their intervals, and the probability of each class.

    Raises
    ------
    InputError
        If there is no such channel, a speed is not positive, or the record is too short for the wavelengths.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import road
    >>> heights = road("B", speed=20.0).record(np.arange(0, 30, 0.005), rng=np.random.default_rng(1))
    >>> classify_road(heights, speed=20.0).name
    'B'
    """
    if isinstance(record, Mapping):
        first = next(iter(record), "road")
        raise InputError(
            f"heights of several tracks come without their time: pass one of them with it, as in "
            f"(timepts, heights[{first!r}]), or the record that Road.record returns"
        )
    signal = as_signal(as_record(record))
    name = signal.channels[0] if channel is None else channel
    if name not in signal.channels:
        raise InputError(f"there is no channel {name!r}.{nearest_names(name, signal.channels)}")
    pace = _numbers(speed)
    short, long = checked_wavelengths(wavelengths)
    if not 0 < short < long < np.inf:
        raise InputError(f"{wavelengths=} must ascend from 0 [m]")
    name, heights = _in_metres(signal, name)
    if pace.shape not in ((), signal.timepts.shape) or not np.all(np.isfinite(pace) & (pace > 0)):
        raise InputError(f"speed must be positive, one number or one for each of {len(signal.timepts)} samples [m/s]")
    spacing, heights = _over_distance(heights, signal.step, pace)
    n, power, held, windowed = _slopes(heights, spacing, (short, long))
    first = int(np.sum(_unfolded(n, spacing, UNFOLDED[0])))
    if first < FEWEST_WAVES:
        raise InputError(
            f"the record is too short, or its samples are too far apart: {spacing * len(heights):.4g} m in steps of "
            f"{spacing:.4g} m give {first} spectral lines between wavelengths of {short:g} and {long:g} m, "
            f"{FEWEST_WAVES} are needed; check the speed"
        )
    _check_waves(name, n, windowed)
    n, (level, exponent, covariance, excess, scatter) = _fitted_unfolded(n, power, held, spacing)
    _check_line(name, _line(n, (power / held)[: len(n)])[1], excess)
    used = (float(1 / n[-1]), float(1 / n[0]))
    return RoadClass(
        roughness=float(np.exp(level)),
        exponent=exponent,
        covariance=frozen_real(covariance),
        wavelengths=used,
        verdict=Verdict(
            Remark(RoadHeadline.CLASS, {"name": road_class(float(np.exp(level)))}),
            tuple(_checks(level, exponent, float(np.sqrt(covariance[0, 0])), excess, scatter)),
        ),
    )


def _numbers(speed: ArrayLike) -> RealArray:
    """Return a speed, or one for each sample, as numbers; NaN of what is none."""
    try:
        return np.asarray(speed, float) if np.asarray(speed).dtype.kind in "iuf" else np.asarray(np.nan)
    except ValueError:
        return np.asarray(np.nan)


def _in_metres(signal: Signal, name: str) -> tuple[str, RealArray]:
    """Return the heights of a channel in metres, by the unit in brackets behind its name.

    Raises
    ------
    InputError
        If the unit is none of length, or the heights are constant.
    """
    heights, unit = signal.values[signal.channels.index(name)], bracketed_unit(name)
    if unit:
        factor, si = 1.0, "?"
        with suppress(InputError):
            made, si = to_si(1.0, unit)
            factor = float(made)
        if si != "m":
            raise InputError(f"channel {name!r}: {unit} is not a unit of length; heights of a road are in m")
        heights = heights * factor
    if not np.ptp(heights):
        raise InputError(f"channel {name!r} shows no road: constant at {heights[0]:g}")
    return bare_name(name), heights


def class_of(roughness: float) -> str:
    """Return the class of ISO 8608 of G_d(0.1 cycle/m) [m3]."""
    return next(name for name, top in ROAD_LIMITS.items() if roughness <= top)


def class_shares(roughness: float, std: float) -> dict[str, float]:
    """Return the probability of each class where the logarithm of the roughness has a standard deviation."""
    from scipy.special import ndtr

    with np.errstate(divide="ignore"):
        ends = ndtr((np.log(list(ROAD_LIMITS.values())) - np.log(roughness)) / max(std, 1e-300))
    return dict(zip(ROAD_LIMITS, np.diff(ends, prepend=0.0).tolist(), strict=True))


def _check_waves(name: str, n: RealArray, power: RealArray) -> None:
    """Refuse heights with one wavelength alone, such as those of a sine.

    Raises
    ------
    InputError
        If a few lines beside each other hold all of the slope.
    """
    total = float(np.sum(power))
    near = np.convolve(power, np.ones(LINES_OF_WAVE), mode="same")
    share = float(np.max(near)) / total if total > 0 else 0.0
    if share >= ONE_WAVE:
        length = 1 / n[int(np.argmax(power))]
        raise InputError(
            f"channel {name!r} is not the height of a road: waves of one length, {length:.3g} m, hold "
            f"{100 * share:.3g} % of its mean square slope, as those of a sine; give heights with many wavelengths"
        )


def _check_line(name: str, exponent: float, excess: tuple[float, int]) -> None:
    """Refuse a spectrum that is neither a line nor, by most of its lines, as steep as one of a road.

    Raises
    ------
    InputError
        If it is neither.
    """
    low, high = EXPONENTS
    if not low <= exponent <= high and not likely(*excess):
        raise InputError(
            f"channel {name!r} is not the height of a road: its spectrum is not a straight line, and the exponent of "
            f"most of it, {exponent:.2g}, is outside the range of roads, {low:g} to {high:g}; check the channel"
        )


def _over_distance(heights: RealArray, step: float, pace: RealArray) -> tuple[Metre, RealArray]:
    """Return the largest spacing of samples over distance, and heights at that spacing."""
    if pace.ndim == 0 or not np.ptp(pace):
        return float(pace.flat[0]) * step, heights
    from scipy.interpolate import CubicSpline

    distance = np.concatenate([[0.0], np.cumsum((pace[1:] + pace[:-1]) / 2 * step)])
    spacing = float(np.max(pace)) * step
    return spacing, np.asarray(CubicSpline(distance, heights)(np.arange(0, distance[-1], spacing)))


def _slopes(
    heights: RealArray, spacing: Metre, wavelengths: tuple[Metre, Metre]
) -> tuple[RealArray, RealArray, RealArray, RealArray]:
    """Return wavenumbers, the periodogram of differences of the heights, and what differences do to a density.

    The last is the periodogram under a Hann window, in which a sine of any length fills a few lines alone.
    """
    differences = np.diff(heights)
    differences = differences - np.mean(differences)
    n = np.fft.rfftfreq(len(differences), spacing)
    power = 2 * spacing / len(differences) * np.abs(np.fft.rfft(differences)) ** 2
    use = (n >= 1 / wavelengths[1]) & (n <= min(1 / wavelengths[0], 0.5 / spacing)) & (n > 0)
    lines = np.asarray(n[use], float)
    windowed = np.abs(np.fft.rfft(differences * np.hanning(len(differences)))) ** 2
    return lines, power[use], 4 * np.sin(np.pi * lines * spacing) ** 2, windowed[use]


# Log level, exponent, their covariance, chi-square of the spectrum against the line with its degrees of freedom, and
# the mean square of the lines' departures.
Fitted: TypeAlias = tuple[float, float, RealArray, tuple[float, int], float]


def _fitted_unfolded(n: RealArray, power: RealArray, held: RealArray, spacing: Metre) -> tuple[RealArray, Fitted]:
    """Return the wavenumbers that are used, and the line fitted to them: as many as folding leaves."""
    for share in UNFOLDED:
        use = _unfolded(n, spacing, share)
        if np.sum(use) < FEWEST_WAVES:
            break
        lines, found = n[use], _fitted(n[use], power[use], held[use])
        if np.all(np.abs(_folding(lines, spacing, found[1])) <= MOST_FOLDING * np.sqrt(np.diag(found[2]))):
            break
    return lines, found


def _unfolded(n: RealArray, spacing: Metre, share: Ratio) -> NDArray[np.bool_]:
    return np.asarray(n <= share * 0.5 / spacing)


def _folding(n: RealArray, spacing: Metre, exponent: Ratio) -> RealArray:
    """Return the errors of log level and exponent by waves that are shorter than two samples, were there all of them.

    Waves of ``2 m / x - 1`` and ``2 m / x + 1`` times the wavenumber of a line fold into it, where x is its share of
    half the sampling rate and m = 1, 2, …; their sum is one of Hurwitz's zeta functions.
    """
    from scipy.special import zeta

    # Below the least exponent of a measured road the sum is one of noise, and has no end at 1.
    w, half = max(exponent, LEAST_MEASURED), n * spacing
    more = half**w * (zeta(w, 1 - half) + zeta(w, 1 + half))
    X = _design(n)
    return np.asarray(np.linalg.solve(X.T @ X, X.T @ more))


def _design(n: RealArray) -> RealArray:
    """Return the derivatives of the logarithm of the density by log level and exponent."""
    return np.column_stack([np.ones(len(n)), -np.log(n / REFERENCE)])


def _line(n: RealArray, density: RealArray) -> RealArray:
    """Return log level and exponent of the line through the logarithms, which a few strong lines hardly move."""
    logs = np.log(np.maximum(density, 1e-300)) + np.euler_gamma
    return np.asarray(np.linalg.lstsq(_design(n), logs, rcond=None)[0])


def _fitted(n: RealArray, power: RealArray, held: RealArray) -> Fitted:
    """Return log level, exponent, their covariance, and chi-square of the spectrum against the line."""
    X = _design(n)
    p = _line(n, power / held)
    for _ in range(50):
        # Fisher scoring of an exponential distribution with a log-linear mean.
        score = power / (held * np.exp(X @ p)) - 1
        step = np.linalg.solve(X.T @ X, X.T @ score)
        step = step * min(1.0, LARGEST_LOG_STEP / max(float(np.max(np.abs(X @ step))), LARGEST_LOG_STEP))
        p = p + step
        if np.max(np.abs(step)) < 1e-10:
            break
    score = power / (held * np.exp(X @ p)) - 1
    bread = np.linalg.inv(X.T @ X)
    # The larger of what exponential lines have by law and what these have: a bent spectrum scatters more.
    covariance = np.asarray(bread * max(1.0, float(np.mean(score**2))), float)
    pieces = np.array_split(score, max(len(score) // LINES_OF_PIECE, 3))
    bends = np.array([np.sum(piece) ** 2 / len(piece) for piece in pieces])
    scatter = float(np.mean(score**2))
    return float(p[0]), float(p[1]), covariance, (float(np.sum(bends)), len(pieces) - 2), scatter


def _checks(level: float, exponent: float, std: float, excess: tuple[float, int], scatter: float) -> Iterator[Check]:
    shares = class_shares(float(np.exp(level)), std)
    best = max(shares, key=lambda name: shares[name])
    if shares[best] >= LEVEL:
        yield Check(Remark(RoadCheck.CLASS, {"name": best, "share": shares[best]}), Level.SOUND)
    else:
        names = tuple(name for name, share in shares.items() if share > 1 - LEVEL)
        yield Check(Remark(RoadCheck.BETWEEN, {"names": names}), Level.CARE)
    roughness = float(np.exp(level))
    if roughness > 2 * ROUGHNESS["H"]:
        numbers: dict[str, Number] = {"roughness": roughness}
        yield Check(Remark(RoadCheck.NO_ROAD, numbers), Level.DOUBTFUL)
    low, high = EXPONENTS
    if not low <= exponent <= high:
        beyond: dict[str, Number] = {"exponent": exponent, "low": low, "high": high}
        yield Check(Remark(RoadCheck.NO_POWER_LAW, beyond), Level.DOUBTFUL)
    if scatter < LEAST_SCATTER:
        yield Check(Remark(RoadCheck.ONE_EVENT), Level.DOUBTFUL)
    if not likely(*excess):
        yield Check(Remark(RoadCheck.BENT, {"chi_square": excess[0], "freedom": excess[1]}), Level.CARE)
