"""A road that a car drives on at a speed: its spectrum under each wheel, and heights drawn from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from suspid.errors import InputError
from suspid.records import as_response
from suspid.signals import real_numbers
from suspid.simulation.road_profile import REFERENCE, track_coherence, tracks
from suspid.units import ComplexArray, Hertz, Metre, Ratio, RealArray

if TYPE_CHECKING:
    import control

# Where a road input meets the road: metres behind the first axle, metres to the left.
Place = tuple[Metre, Metre]


@dataclass(frozen=True, kw_only=True, slots=True)
class Road:
    """A random road of ISO 8608 under the wheels of a car at a speed.

    Parameters
    ----------
    roughness : float
        Displacement spectral density at 0.1 cycle/m, G_d(n_0) [m3].
    speed : float
        Speed [m/s].
    exponent : float
        Exponent w of the spectral density [1].
    wavelengths : tuple of float
        Shortest and longest wavelength [m]; there is nothing outside.
    places : mapping of str to tuple of float
        Where each road input meets the road: metres behind the first axle, and to the left.
    coherence : float, optional
        Share of amplitude that tracks have in common [1]. Default: that of an isotropic road, see `track_coherence`.

    Examples
    --------
    >>> from suspid import road
    >>> country = road("C", speed=20.0)
    >>> country.roughness, country.band
    (0.000256, (0.2, 200.0))
    >>> record = country.record(np.arange(0, 1, 0.1), rng=np.random.default_rng(1))
    >>> record.outputs.shape
    (10,)
    """

    roughness: float
    speed: float
    exponent: Ratio
    wavelengths: tuple[Metre, Metre]
    places: Mapping[str, Place]
    coherence: Ratio | None = None

    @property
    def band(self) -> tuple[Hertz, Hertz]:
        """Frequencies that the road excites [Hz]: speed over the longest and over the shortest wavelength.

        Examples
        --------
        >>> from suspid import road
        >>> road("C", speed=20.0, wavelengths=(0.5, 100.0)).band
        (0.2, 40.0)
        """
        return self.speed / self.wavelengths[1], self.speed / self.wavelengths[0]

    def spectrum(self, hertz: ArrayLike) -> RealArray:
        """Return the one-sided spectral density of the height under any wheel [m2/Hz], in the shape of ``hertz``.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import road
        >>> country = road("C", speed=20.0)
        >>> bool(np.isclose(country.spectrum(2.0), country.roughness / 20.0)), float(country.spectrum(500.0))
        (True, 0.0)
        """
        f = np.asarray(hertz, float)
        inside = (f >= self.band[0] * (1 - 1e-12)) & (f <= self.band[1] * (1 + 1e-12))
        waves = np.where(inside, f, self.band[1]) / self.speed
        return np.where(inside, self.roughness * (waves / REFERENCE) ** -self.exponent / self.speed, 0.0)

    def shares(self, hertz: ArrayLike) -> ComplexArray:
        """Return the spectral matrix of all inputs over `spectrum` [1], (frequency, input, input).

        Hermitian, with ones on the diagonal: ``coherence exp(-2 pi i f (d_i - d_j) / v)`` with d the metres behind.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import road
        >>> country = road("C", speed=20.0)
        >>> country.shares([1.0, 2.0])[:, 0, 0].real.tolist()
        [1.0, 1.0]
        """
        f = np.asarray(hertz, float)
        behind, left = np.array(list(self.places.values())).T
        phase = np.exp(-2j * np.pi * f[:, None] * behind / self.speed)
        shared = track_coherence(f / self.speed, left, exponent=self.exponent, coherence=self.coherence)
        return np.asarray(phase[:, :, None] * shared * phase[:, None, :].conj())

    def heights(
        self, timepts: ArrayLike, *, rng: np.random.Generator, speed: ArrayLike | None = None
    ) -> dict[str, RealArray]:
        """Return heights under each road input at times [m], as `simulate` takes them; each begins at zero.

        Parameters
        ----------
        timepts : array_like (sample,)
            Ascending times [s].
        rng : numpy.random.Generator
            Source of the heights: the same state makes the same road.
        speed : array_like (sample,), optional
            Speed at each time [m/s], 0 or more. Default: the road's own at all times. Samples hold wavelengths down
            to ``2 speed / fs``; shorter ones of the road are left out.

        Raises
        ------
        InputError
            If the times do not ascend, or the speeds are none.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import road
        >>> drawn = road("C", speed=20.0).heights(np.arange(0, 5, 0.01), rng=np.random.default_rng(1))
        >>> list(drawn), drawn["road"].shape, float(drawn["road"][0])
        (['road'], (500,), 0.0)
        """
        time = real_numbers(timepts, "timepts")
        if time.ndim != 1 or time.size < 2 or not np.all(np.diff(time) > 0):
            raise InputError("timepts must be a vector of at least two ascending times [s]")
        pace = np.broadcast_to(np.asarray(self.speed if speed is None else speed, float), time.shape)
        if not np.all(np.isfinite(pace) & (pace >= 0)) or not np.any(pace):
            raise InputError("speed must contain finite speeds [m/s], not negative and not all zero")
        if not isinstance(rng, np.random.Generator):
            raise InputError(f"{rng=} is not a random generator; pass np.random.default_rng(seed)")
        steps = np.diff(time)
        distance = np.concatenate([[0.0], np.cumsum((pace[1:] + pace[:-1]) / 2 * steps)])
        held = max(self.wavelengths[0], 2 * float(np.max(pace)) * float(np.max(steps)))
        if held >= self.wavelengths[1]:
            raise InputError(
                f"samples every {np.max(steps):g} s resolve no wavelength below {held:.3g} m; sample faster"
            )
        behind, left = np.array(list(self.places.values())).T
        sides, which = np.unique(left, return_inverse=True)
        drawn = tracks(
            [distance - behind[which == side, None] for side in range(len(sides))],
            sides,
            roughness=self.roughness,
            rng=rng,
            exponent=self.exponent,
            wavelengths=(held, self.wavelengths[1]),
            coherence=self.coherence,
        )
        rows: dict[int, RealArray] = {}
        for side, heights in enumerate(drawn):
            rows |= dict(zip(np.flatnonzero(which == side).tolist(), heights, strict=True))
        return {name: rows[i] - rows[i][0] for i, name in enumerate(self.places)}

    def record(
        self, timepts: ArrayLike, *, rng: np.random.Generator, speed: ArrayLike | None = None
    ) -> control.TimeResponseData:
        """Return `heights` as a record, one channel for each road input.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import road
        >>> road("C", speed=20.0).record(np.arange(0, 5, 0.01), rng=np.random.default_rng(1))
        <Response Road: 500 samples at 100 Hz from t = 0 s, 1 channel: road>
        """
        drawn = self.heights(timepts, rng=rng, speed=speed)
        return as_response(np.asarray(timepts, float), np.array(list(drawn.values())), list(drawn), title="Road")
