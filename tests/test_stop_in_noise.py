"""One mass that friction stops, seen through white noise: in noise nothing shows that it rests, but that it does."""

from __future__ import annotations

import numpy as np
import pytest

from suspid import analyse
from suspid.records import as_response
from suspid.units import RealArray

RATE = 500.0


def stopped(*, wn: float, zeta: float, friction: float, first: float) -> tuple[RealArray, float, RealArray]:
    """Return the exact motion after a release at ``first``, when it stops, and its turns.

    Between turns it is a damped swing about ``friction`` on the side that it comes from.
    """
    wd, places = wn * np.sqrt(1 - zeta**2), [first]
    parts = []
    while abs(places[-1]) > friction:
        t = np.arange(0, np.pi / wd, 1 / RATE / 50)
        middle = friction * np.sign(places[-1])
        swing = np.exp(-zeta * wn * t) * (np.cos(wd * t) + zeta * wn / wd * np.sin(wd * t))
        parts.append(middle + (places[-1] - middle) * swing)
        places.append(middle - (places[-1] - middle) * np.exp(-zeta * wn * np.pi / wd))
    fine = np.concatenate(parts)
    return np.asarray(fine[::50]), len(fine) / RATE / 50, np.array(places)


@pytest.mark.parametrize(
    ("wn", "zeta", "friction", "seed"), [(30.0, 0.01, 0.02, 1), (18.0, 0.005, 0.03, 2), (40.0, 0.02, 0.025, 3)]
)
def test_the_decay_ends_where_the_mass_stops(wn: float, zeta: float, friction: float, seed: int) -> None:
    """It went on over the noise of the rest, with friction and quadratic damping and a third of the damping gone."""
    motion, lasts, places = stopped(wn=wn, zeta=zeta, friction=friction, first=1.0)
    rng = np.random.default_rng(seed)
    rest = np.full(int(3 * RATE), motion[-1])
    values = np.concatenate([np.ones(250), motion, rest])
    record = as_response(np.arange(values.size) / RATE, values[None], ["seat"])
    record.y[0] += 0.002 * rng.standard_normal(values.size)
    found = analyse(record)
    assert len(found.modes) == 1
    stop = 250 / RATE + lasts
    assert found.used[0].stop == pytest.approx(stop, abs=0.6 * np.pi / wn)
    # From turn to turn: what each swing loses.
    sizes = np.abs(places)
    lost = np.log(sizes[:-1] / sizes[1:])[: len(places) - 2]
    mean = float(np.mean(lost / np.hypot(np.pi, lost)))
    known = found.modes.interval(0.95).zeta[0]
    assert known[0] < mean < known[1]
    assert found.modes.zeta[0] == pytest.approx(mean, rel=0.15)
    assert found.modes.wn[0] == pytest.approx(wn, rel=0.01)
