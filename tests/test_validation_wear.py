"""The report on wear: its drives, and its drawn fleets."""

import numpy as np
import pytest

from suspid import DamperState, wear
from validation.wear import DRIVES, RULE, day, drawn_fleet, shares, worn_drive


def test_a_drive_of_another_day_shows_the_loss() -> None:
    new, old = worn_drive(0.5, 1, duration=20.0), worn_drive(1.0, 2, duration=20.0)
    assert new is not None
    assert old is not None
    found = wear(new, before=old)
    assert found.states["chassis"] is DamperState.WORN
    # Temperature makes 3 % of it in each drive.
    assert found.dampers[0].loss.value == pytest.approx(0.5, abs=0.08)


def test_days_differ_as_the_rule_says() -> None:
    rng = np.random.default_rng(0)
    days = [day(rng) for _ in range(4000)]
    # 4000 draws tell a standard deviation to 1.1 %.
    for name, std in (("damper", RULE.damper_std), ("spring", RULE.spring_std), ("mass", RULE.load_std)):
        assert np.std([np.log(getattr(one, name)) for one in days]) == pytest.approx(std, rel=0.05)


def test_a_drawn_fleet_has_its_loss() -> None:
    rows = drawn_fleet(0.2, 0.01, np.random.default_rng(0))
    ratios = {k: [np.log(r.damping / r.stiffness) for _, _, when, r in rows if when == k] for k in (0, DRIVES - 1)}
    assert np.mean(ratios[DRIVES - 1]) - np.mean(ratios[0]) == pytest.approx(np.log(0.8), abs=0.01)


def test_shares_add_up() -> None:
    said = shares([DamperState.GOOD, DamperState.GOOD, DamperState.WORN, DamperState.WATCH])
    assert said[DamperState.GOOD] == 0.5
    assert sum(said.values()) == 1
