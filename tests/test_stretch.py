"""Which stretch of a record is identified: a clear decay, or none."""

import numpy as np
from scipy.signal import lfilter

from suspid import analyse
from suspid.signals import as_response
from suspid.units import RealArray
from suspid.words import DecayDoubt, Note


def people_in_a_parked_car(seed: int) -> tuple[RealArray, RealArray]:
    """Acceleration of a car at rest in which people move now and then, by a sensor of coarse steps."""
    rng = np.random.default_rng(seed)
    values = np.zeros((2, 3000))
    at = 200
    while at < 2750:
        length = int(rng.uniform(30, 160))
        memory = rng.uniform(0.8, 0.98)
        size = rng.uniform(1, 4)
        drawn = rng.standard_normal((2, length))
        drawn[1] += 0.5 * drawn[0]
        values[:, at : at + length] += (
            size * np.hanning(length) * lfilter([np.sqrt(1 - memory**2)], [1, -memory], drawn)
        )
        at += length + int(rng.uniform(60, 250))
    return np.arange(3000) / 100, np.round(values * 4 + 0.05 * rng.standard_normal(values.shape)) / 4


def test_one_of_many_events_that_looks_like_a_short_decay_is_a_coincidence() -> None:
    time, values = people_in_a_parked_car(2)
    found = analyse(as_response(time, values, ["x", "z"]))
    assert DecayDoubt.COMPANY in {doubt.code for decay in found.decays for doubt in decay.doubts}
    assert not found.used
    assert not len(found.modes)
    assert next(str(note) for note in found.notes if note.code is Note.WHOLE_RECORD).startswith("no clear decay")
