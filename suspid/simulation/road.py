"""The road under the wheels of a car at a speed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from suspid.arguments import explained
from suspid.errors import InputError
from suspid.model import Suspension, positive_number
from suspid.simulation.road_profile import WAVELENGTHS, level_of
from suspid.simulation.roads import Place, Road
from suspid.units import Metre, Ratio
from suspid.values import FrozenItems
from suspid.wording import Argument


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
