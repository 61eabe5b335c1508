"""Random roads of ISO 8608."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from suspid.arguments import explained
from suspid.errors import InputError
from suspid.units import Metre, Ratio, RealArray
from suspid.values import FrozenMapping, is_size

# Geometric mean of the displacement spectral density of each class at REFERENCE [m3]: ISO 8608 as others quote it.
ROUGHNESS: Mapping[str, float] = FrozenMapping({name: 16e-6 * 4**k for k, name in enumerate("ABCDEFGH")})
REFERENCE = 0.1  # cycle/m, to which the classes refer
# Wavelengths of a road [m]: shorter ones are levelled by the contact patch of a tyre, longer ones by the road itself.
WAVELENGTHS = (0.1, 100.0)
# Exponents of measured roads are 1.5 to 3; beyond this one a spectrum is a single wave.
MOST_EXPONENT = 6.0
# Longer grids do not fit into memory: this many points take some gigabytes on the way.
MOST_POINTS = 2**26


def road_class(roughness: float) -> str:
    """Return the class of ISO 8608 of a road, by its G_d(n_0) [m3]: each spans a factor of four about its mean.

    Examples
    --------
    >>> road_class(31e-6), road_class(33e-6), road_class(1.0)
    ('A', 'B', 'H')
    """
    return next((name for name, mean in ROUGHNESS.items() if roughness <= 2 * mean), list(ROUGHNESS)[-1])


@explained
def road_profile(
    distance: ArrayLike,
    *,
    roughness: str | float,
    rng: np.random.Generator,
    exponent: Ratio = 2.0,
    wavelengths: tuple[Metre, Metre] = WAVELENGTHS,
) -> RealArray:
    """Return the height of a random road of ISO 8608 at given distances along it.

    Its spectral density is ``G_d(n) = G_d(n_0) (n / n_0)^-exponent`` with ``n_0 = 0.1`` cycle/m, its heights Gaussian.
    Driven at the speed v, the density in time is ``G_d(n_0) n_0^exponent v^(exponent - 1) f^-exponent``.

    Parameters
    ----------
    distance : array_like
        Distances [m], of any shape: ``speed * timepts``, or ``np.stack([s, s - wheelbase])`` for two axles on one
        track.
    roughness : str or float
        Class ``"A"`` to ``"H"`` (its geometric mean), or G_d(n_0) [m3].
    rng : numpy.random.Generator
        Source of the heights.
    exponent : float
        Exponent w of the spectral density.
    wavelengths : tuple of float
        Shortest and longest wavelength [m]; there is nothing outside. At the speed v, samples at the rate fs hold
        wavelengths down to ``2 v / fs``; shorter ones are aliased.

    Returns
    -------
    ndarray
        Heights [m], in the shape of the distances; mean zero over many roads.

    Raises
    ------
    InputError
        If the class is unknown, a number is not positive or not finite, or the road is too long for its wavelengths.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(0, 10, 0.005)
    >>> road = road_profile(20 * t, roughness="B", rng=np.random.default_rng(1))
    >>> road.shape, bool(0.001 < np.std(road) < 0.1)
    ((2000,), True)
    """
    level = level_of(roughness, exponent, wavelengths)
    if not isinstance(rng, np.random.Generator):
        raise InputError(f"{rng=} is not a random generator; pass np.random.default_rng(seed)")
    where = np.asarray(distance, float)
    if not where.size or not np.all(np.isfinite(where)):
        raise InputError("distance must contain finite distances [m]")
    return tracks([where], np.zeros(1), roughness=level, rng=rng, exponent=exponent, wavelengths=wavelengths)[0]


def level_of(roughness: str | float, exponent: Ratio, wavelengths: tuple[Metre, Metre]) -> float:
    """Return G_d(n_0) [m3] of a class or as given; refuse a spectrum that is none."""
    level = ROUGHNESS.get(roughness.upper()) if isinstance(roughness, str) else roughness
    if level is None:
        raise InputError(
            f"{roughness!r} is not a class of ISO 8608; give one of {', '.join(ROUGHNESS)}, or G_d(n_0) [m3]"
        )
    short, long = checked_wavelengths(wavelengths)
    if isinstance(level, bool) or not (level == 0 or is_size(level)):
        raise InputError(f"{roughness=} must be G_d(n_0) in m3, 0 or a positive number; class A has 16e-6")
    number = isinstance(exponent, int | float | np.number) and not isinstance(exponent, bool)
    if not (number and 0 < exponent <= MOST_EXPONENT and 0 < short < long < np.inf):
        raise InputError(
            f"{roughness=}, {exponent=}, {wavelengths=} must be finite, the exponent positive and at most "
            f"{MOST_EXPONENT:g} (ISO 8608: 2), and the wavelengths ascend from 0"
        )
    return float(level)


def checked_wavelengths(wavelengths: object) -> tuple[Metre, Metre]:
    """Return the shortest and the longest wavelength; refuse what is no pair of numbers.

    Examples
    --------
    >>> checked_wavelengths([0.5, 50])
    (0.5, 50.0)
    """
    pair = list(wavelengths) if isinstance(wavelengths, tuple | list) else []
    if len(pair) != 2 or not all(isinstance(one, int | float | np.number) for one in pair):
        raise InputError(
            f"wavelengths = {wavelengths!r:.60} must be the shortest and the longest, such as (0.1, 100.0) [m]"
        )
    return float(pair[0]), float(pair[1])


def tracks(
    distances: Sequence[RealArray],
    offsets: RealArray,
    *,
    roughness: float,
    rng: np.random.Generator,
    exponent: Ratio,
    wavelengths: tuple[Metre, Metre],
    coherence: Ratio | None = None,
) -> list[RealArray]:
    """Return the heights of parallel tracks at distances of each; see `road_profile` and `track_coherence`.

    ``offsets`` are their lateral positions [m].
    """
    from scipy.interpolate import CubicSpline

    short, long = wavelengths
    # Cubic interpolation between eight points per shortest wavelength is right to 1e-3 of its amplitude.
    first, spacing = min(float(np.min(where)) for where in distances), short / 8
    last = max(float(np.max(where)) for where in distances)
    # A periodic road, one longest wavelength longer than needed, so that its ends are no neighbours.
    count = int(np.ceil((last - first + long) / spacing)) + 1
    if count * len(distances) > MOST_POINTS:
        raise InputError(
            f"the road is {last - first:.4g} m long, {count} points at a shortest wavelength of {short:g} m; "
            f"at most {MOST_POINTS} are made: give longer wavelengths, or a shorter road"
        )
    n = np.fft.rfftfreq(count, spacing)
    inside = (n >= 1 / long) & (n <= 1 / short)
    density = np.zeros(len(n))
    density[inside] = roughness * (n[inside] / REFERENCE) ** -exponent
    lines = rng.standard_normal((len(distances), 2, len(n)))
    # One-sided density: the line 2 (a cos - b sin) has the variance 4 std(a)^2 = G dn.
    amplitude = np.sqrt(density / (4 * count * spacing)) * (lines[:, 0] + 1j * lines[:, 1])
    if len(distances) > 1:
        shared = track_coherence(np.asarray(n[inside], float), offsets, exponent=exponent, coherence=coherence)
        # Semidefinite where tracks coincide: the root of the eigenvalues, cut at zero, is a root of the matrix.
        values, vectors = np.linalg.eigh(shared)
        root = vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]
        amplitude[:, inside] = np.einsum("nij,jn->in", root, amplitude[:, inside])
    heights = np.fft.irfft(amplitude * count, count)
    grid = spacing * np.arange(count)
    return [np.asarray(CubicSpline(grid, row)(where - first)) for row, where in zip(heights, distances, strict=True)]


def track_coherence(
    wavenumbers: RealArray, offsets: RealArray, *, exponent: Ratio, coherence: Ratio | None = None
) -> RealArray:
    """Return the share of amplitude that parallel tracks have in common, (wavenumber, track, track).

    Of an isotropic road, whose statistics are the same in all directions, it is
    ``2 (x / 2)^(w / 2) K(x) / Gamma(w / 2)`` with ``x = 2 pi n d``, d the distance of the tracks and K the modified
    Bessel function of order w / 2 (Dodds and Robson, J. Sound and Vibration 31, 1973, 175-183, for any exponent w). A
    number ``coherence`` is used at all wavenumbers instead, between different tracks.

    Examples
    --------
    Long waves lift both sides of a car, short ones do not:

    >>> track_coherence(np.array([0.01, 0.1, 1.0]), np.array([0.0, 1.5]), exponent=2.0)[:, 0, 1].round(3)
    array([0.987, 0.626, 0.   ])
    """
    from scipy.special import gamma, kv

    apart = np.abs(np.subtract.outer(offsets, offsets))
    if coherence is not None:
        return np.broadcast_to(np.where(apart > 0, coherence, 1.0), (len(wavenumbers), *apart.shape)).copy()
    x = 2 * np.pi * np.asarray(wavenumbers, float)[:, None, None] * apart
    order = exponent / 2
    with np.errstate(invalid="ignore", over="ignore"):
        shared = 2 / gamma(order) * (x / 2) ** order * kv(order, x)
    return np.where(x > 0, np.nan_to_num(shared), 1.0)
