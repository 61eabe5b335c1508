"""Responses of a model: exact free decays and driven responses, roads, and noise added to a record.

`free_decay` evaluates ``C expm(A t) x_0`` to rounding, `simulate` the response to roads and forces that are
polynomials between samples. `road_profile` draws a road of ISO 8608, `road` is one under the wheels of a car, with its
spectrum; `add_noise` adds white noise of a given signal-to-noise ratio. `recursion` runs a sampled linear system
without a loop over the samples. Every random number comes from the generator that the caller passes.
"""

from suspid.simulation.add_noise import add_noise
from suspid.simulation.free_decay import free_decay
from suspid.simulation.recursion import recursion
from suspid.simulation.road import places_of, road
from suspid.simulation.road_profile import (
    REFERENCE,
    ROUGHNESS,
    WAVELENGTHS,
    checked_wavelengths,
    road_class,
    road_profile,
    track_coherence,
)
from suspid.simulation.roads import Place, Road
from suspid.simulation.simulate import simulate

__all__ = [
    "REFERENCE",
    "ROUGHNESS",
    "WAVELENGTHS",
    "Place",
    "Road",
    "add_noise",
    "checked_wavelengths",
    "free_decay",
    "places_of",
    "recursion",
    "road",
    "road_class",
    "road_profile",
    "simulate",
    "track_coherence",
]
