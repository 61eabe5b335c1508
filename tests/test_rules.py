"""Laws of single rules that tests of whole records do not see: halves, falls, turns, multiples, patience."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from suspid import identify
from suspid.decays.fading import FADING_PARTS, LEAST_FADED, falling
from suspid.identification import Considered, Force, ForceKind, patience
from suspid.identification.nonlinear import search
from suspid.identification.nonlinear.patience import COSTLY, SEARCHES_IN_VAIN, note_steps
from suspid.identification.nonlinear.turns import measured_turns
from suspid.identification.verdict import _outside
from suspid.records import as_response
from suspid.signals import Signal
from suspid.words import Reason, Remark


def test_halves_disagree_by_one_standard_deviation_in_white_noise() -> None:
    time = np.arange(800) / 100
    decay = np.exp(-0.15 * time) * np.cos(9 * time)
    apart = [
        identify(
            as_response(time, (decay + 0.02 * np.random.default_rng(seed).standard_normal(800))[None], ["y"])
        ).halves
        for seed in range(60)
    ]
    # A mean of 60 chi-squares of two degrees has a standard deviation of 0.13.
    assert 0.6 < np.mean(np.square(apart)) < 1.6


@pytest.mark.parametrize(("faded", "seen"), [(0.75, False), (1.5, True)])
def test_a_motion_falls_by_a_neper_at_least(faded: float, seen: bool) -> None:
    count = 100 * FADING_PARTS
    share = np.arange(count) / count * FADING_PARTS / (FADING_PARTS - 1)
    motion = np.exp(-faded * LEAST_FADED * share) * np.cos(np.arange(count))
    assert (falling(Signal(start=0.0, step=0.01, values=motion[None], channels=("y",))) is not None) is seen


def test_a_pole_that_hardly_turns_takes_no_memory() -> None:
    """A share of its cycle was the length of an array."""
    motion = np.exp(-np.arange(60) / 30)
    assert measured_turns(motion, np.array([5.0, 25.0, 45.0]), 10**12).size <= 3


def test_motion_that_forces_leave_out_is_said() -> None:
    def left(pole: complex, reason: Reason, **numbers: int) -> Considered:
        return Considered(pole=pole, remark=Remark(reason, dict(numbers)), removed=False)

    own, part, harmonic, wide = (
        left(-17.7 + 1165.8j, Reason.DISTORTION),
        left(-6 + 187j, Reason.SAME_MODE, mode=1),
        left(-17.7 + 567j, Reason.HARMONIC, mode=1, multiple=3),
        left(-900 + 1165.8j, Reason.DISTORTION),
    )
    force = Force(kind=ForceKind.DRAG, channel=0, other=None)
    found: Any = SimpleNamespace(forces=(force,), considered=(part, own, harmonic, wide))
    (check,) = _outside(found)
    assert str(check).startswith("Motion at 185.6 Hz decays beside the modes")
    assert not list(_outside(SimpleNamespace(forces=(), considered=(own,))))  # type: ignore[arg-type]


def test_structures_are_sought_in_vain_a_few_times_only(monkeypatch: pytest.MonkeyPatch) -> None:
    sought = list[int]()

    def in_vain(one: Any, *_: object) -> None:
        sought.append(len(one.values))
        note_steps(COSTLY + 1)

    monkeypatch.setattr(search, "_structure", in_vain)
    monkeypatch.setattr(search, "WithoutForces", SimpleNamespace(of=lambda _: None))
    for name in ("_searched", "_measured"):
        monkeypatch.setattr(search, name, lambda *_: None)
    noise, selection = cast("Any", None), cast("Any", SimpleNamespace(fit=None))

    def seek(channels: int) -> None:
        for k in range(SEARCHES_IN_VAIN + 3):
            values = np.random.default_rng(k).standard_normal((channels, 20))
            search.find_forces(values, noise=noise, selection=selection)

    with patience():
        seek(2)
        seek(3)
        # What was found in vain before counts as well where it is met again.
        assert sought == [2] * SEARCHES_IN_VAIN + [3] * SEARCHES_IN_VAIN
    sought.clear()
    search._found.cache_clear()
    seek(2)
    assert sought == [2] * (SEARCHES_IN_VAIN + 3)
