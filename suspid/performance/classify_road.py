"""Classify a measured road after ISO 8608."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress

import numpy as np
from numpy.typing import ArrayLike

from suspid.arguments import explained
from suspid.cleaning import RecordLike, as_record, to_si
from suspid.errors import InputError
from suspid.io import bare_name, bracketed_unit
from suspid.levels import LEVEL, likely
from suspid.performance.road_classes import RoadClass, class_shares
from suspid.performance.road_lines import EXPONENTS, FEWEST_WAVES, UNFOLDED, line_of, line_through, unfolded
from suspid.signals import Signal, as_signal
from suspid.simulation import ROUGHNESS, WAVELENGTHS, checked_wavelengths, road_class
from suspid.units import Metre, RealArray
from suspid.values import frozen_real, nearest_names
from suspid.words import Check, Level, Number, Remark, Verdict, percent
from suspid.words.ride import RoadCheck, RoadHeadline

# Share of the mean square slope, under a Hann window, from which a few lines beside each other are waves of one length
# and no road. None of 20 000 of the shortest records of roads with exponents up to 3 has more; at 4 one of 300.
ONE_WAVE, LINES_OF_WAVE = 0.99, 5
# Mean square of the lines' departures from the fit, over that of a random road, below which the road is no random one:
# with the fewest lines one of a hundred thousand has less.
LEAST_SCATTER = 0.15


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
    first = int(np.sum(unfolded(n, spacing, UNFOLDED[0])))
    if first < FEWEST_WAVES:
        raise InputError(
            f"the record is too short, or its samples are too far apart: {spacing * len(heights):.4g} m in steps of "
            f"{spacing:.4g} m give {first} spectral lines between wavelengths of {short:g} and {long:g} m, "
            f"{FEWEST_WAVES} are needed; check the speed"
        )
    _check_waves(name, n, windowed)
    n, (level, exponent, covariance, excess, scatter) = line_of(n, power, held, spacing)
    _check_line(name, line_through(n, (power / held)[: len(n)])[1], excess)
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
            f"{percent(share)} of its mean square slope, as those of a sine; give heights with many wavelengths"
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
