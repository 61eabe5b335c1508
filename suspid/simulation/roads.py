"""A road that a car drives on at a speed: its spectrum under each wheel, and heights drawn from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from suspid.arguments import explained
from suspid.errors import InputError
from suspid.model import Suspension, positive_number
from suspid.records import as_response
from suspid.signals import real_numbers
from suspid.simulation.road_profile import REFERENCE, WAVELENGTHS, level_of, track_coherence, tracks
from suspid.units import ComplexArray, Hertz, Metre, Ratio, RealArray
from suspid.values import FrozenItems
from suspid.wording import Argument

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


@explained
def road(
    roughness: str | float,
    *,
    speed: float,
    under: Suspension | Mapping[str, Place] | None = None,
    exponent: Ratio = 2.0,
    wavelengths: tuple[Metre, Metre] = WAVELENGTHS,
    coherence: Ratio | None = None,
) -> Road:
    """Return a random road of ISO 8608 under the wheels of a car at a speed.

    The spectral density is ``G_d(n) = G_d(n_0) (n / n_0)^-w`` with ``n_0 = 0.1`` cycle/m; in time it is
    ``G_d(n_0) n_0^w v^(w - 1) f^-w``. The second axle meets what the first one met before; the tracks have the
    coherence of an isotropic road, unless it is given.

    Parameters
    ----------
    roughness : str or float
        Class ``"A"`` to ``"H"`` (its geometric mean), or G_d(n_0) [m3].
    speed : float
        Speed [m/s].
    under : Suspension or mapping of str to tuple of float, optional
        The car, whose axles and tracks are those of its struts between wheels and body, or for each road input the
        metres behind the first axle and to the left. Default: one input ``"road"``.
    exponent : float
        Exponent w of the spectral density [1].
    wavelengths : tuple of float
        Shortest and longest wavelength [m].
    coherence : float, optional
        Share of amplitude that different tracks have in common [1], 0 to 1, at all wavelengths.

    Returns
    -------
    Road
        ``.spectrum(hertz)``, ``.heights(timepts, rng=…)`` and ``.record(timepts, rng=…)``.

    Raises
    ------
    InputError
        If the class is unknown, or a number is not positive or not finite.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import quarter_car, simulate
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> motorway = road("B", speed=30.0, under=car)
    >>> motorway.spectrum([1.0, 10.0]).tolist()
    [1.92e-05, 1.92e-07]
    >>> t = np.arange(0, 10, 0.005)
    >>> record = simulate(car, t, motorway.heights(t, rng=np.random.default_rng(1)), interpolation="cubic")
    """
    level = level_of(roughness, exponent, wavelengths)
    if np.ndim(speed):
        raise InputError(
            Argument("speed"),
            ": a road has one speed [m/s], for its spectrum; for a changing speed give the mean here, and the "
            "profile to .heights(timepts, rng=…, speed=profile) or road_profile",
        )
    speed = positive_number("speed", speed, "m/s")
    share = coherence is None or (isinstance(coherence, int | float) and not isinstance(coherence, bool))
    if not share or (coherence is not None and not 0 <= coherence <= 1):
        raise InputError(f"{coherence=} must lie between 0 and 1")
    if not isinstance(under, Suspension | Mapping | None):
        raise InputError(
            f"under is a {type(under).__name__}; give the car, or places such as {{'road': (0.0, 0.0)}} [m]"
        )
    places = places_of(under) if isinstance(under, Suspension) else dict(under or {"road": (0.0, 0.0)})
    pairs = all(isinstance(place, tuple | list) and len(place) == 2 for place in places.values())
    if not pairs or not places or not np.all(np.isfinite(list(places.values()))):
        raise InputError("the car has no road, or a place is not finite; give metres behind and to the left")
    return Road(
        roughness=level,
        speed=speed,
        exponent=float(exponent),
        wavelengths=(float(wavelengths[0]), float(wavelengths[1])),
        places=FrozenItems({name: (float(b), float(left)) for name, (b, left) in places.items()}),
        coherence=coherence,
    )


def places_of(car: Suspension) -> dict[str, Place]:
    """Return where each road input of a car meets the road: metres behind the first axle, and to the left.

    They are the lever arms in ``pitch`` and ``roll`` of the strut that carries the body on that wheel; a car without
    these coordinates has one track and one axle.

    Examples
    --------
    >>> from suspid import half_car
    >>> car = half_car(chassis_mass=1200, pitch_inertia=1800, front_tire_mass=80, rear_tire_mass=80,
    ...                cg_to_front=1.2, cg_to_rear=1.5, front_stiffness=40e3, rear_stiffness=36e3,
    ...                front_tire_stiffness=400e3, rear_tire_stiffness=400e3,
    ...                front_damping=3000, rear_damping=2800)
    >>> places_of(car)
    {'road_front': (0.0, 0.0), 'road_rear': (2.7, 0.0)}
    """
    ahead: dict[str, Metre] = {}
    left: dict[str, Metre] = {}
    for name in car.roads:
        wheels = {c for s in car.struts if s.arms.get(name) for c in car.coordinates if s.arms.get(c)}
        arms = next(
            (s.arms for s in car.struts if s.arms.get("heave") and any(s.arms.get(c) for c in wheels - {"heave"})), {}
        )
        lift = arms.get("heave", 1.0)
        ahead[name], left[name] = -arms.get("pitch", 0.0) / lift, arms.get("roll", 0.0) / lift
    front = max(ahead.values(), default=0.0)
    return {name: (front - ahead[name], left[name]) for name in car.roads}
