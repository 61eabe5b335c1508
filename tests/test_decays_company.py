"""Events that are no decays: those beside a decay speak against it, what rises within it is part of it."""

import importlib
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from suspid import analyse, identify
from suspid.analysis.choice import doubts_of
from suspid.decays.bursts import Burst
from suspid.decays.decay import Decay
from suspid.decays.find_decays import _in_company, _ranked, find_decays
from suspid.identification import Force, ForceKind
from suspid.records import as_response
from suspid.words import Check, DecayDoubt, Level, RecordCheck, Remark


@pytest.fixture(scope="module")
def decay() -> Decay:
    time = np.asarray(np.arange(2000) / 200, float)
    values = 1e-4 * np.random.default_rng(1).standard_normal((1, 2000))
    values[0, 600:] += (np.exp((-1.5 + 40j) * time[:1400])).imag
    (found,) = find_decays(as_response(time, values, ("y",)))
    return replace(found, doubts=())


def events(decay: Decay, times: list[float]) -> list[Burst]:
    """Events as loud as the decay."""
    return [
        Burst(onset=t, peak=t, stop=t + 0.1, level=decay.level, top=6.0, width=0.05, cut=False, again=()) for t in times
    ]


def test_events_within_a_decay_are_part_of_it(decay: Decay) -> None:
    within = np.linspace(decay.start, decay.stop, 8)[1:-1].tolist()
    assert not _in_company(decay, [decay], events(decay, within)).doubts


def test_events_beside_a_decay_speak_against_it(decay: Decay) -> None:
    beside = [decay.start - 0.1 * k for k in range(1, 7)]
    doubts = _in_company(decay, [decay], events(decay, beside)).doubts
    assert [doubt.code for doubt in doubts] == [DecayDoubt.COMPANY]


@pytest.mark.parametrize(("hertz", "doubted"), [((1.2, 1.22, 1.19, 1.25), False), ((1.2, 1.5, 1.9, 2.4), True)])
def test_releases_that_share_no_mode_are_no_company(
    decay: Decay, hertz: tuple[float, ...], doubted: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of eight pushes four seem to be followed by a decay: of one body, or of a drive that shows another each time."""
    module = importlib.import_module("suspid.decays.find_decays")
    made = [replace(decay, wn=np.array([2 * np.pi * f])) for f in hertz]
    left = iter(made)
    monkeypatch.setattr(module, "releases", lambda *_: ([(100 * k, 100 * k + 90) for k in range(4)], 8))
    monkeypatch.setattr(module, "examined", lambda *_, **__: ([next(left)], []))
    monkeypatch.setattr(module, "_given", lambda *_: None)
    recording = SimpleNamespace(signal=SimpleNamespace(start=0.0, step=0.01), finest=None, bands=None)
    found = module._let_go(recording)
    assert [any(doubt.code is DecayDoubt.COMPANY for doubt in one.doubts) for one in found] == [doubted] * 4


@pytest.mark.parametrize(
    ("hertz", "level"),
    [
        ((5, 5, 5, 5), None),
        ((5, 6.1, 7.5), Level.CARE),
        ((5, 6.1, 7.5, 9.2), Level.DOUBTFUL),
    ],
)
def test_what_no_other_stretch_shows_is_doubted(hertz: tuple[float, ...], level: Level | None) -> None:
    """Each stretch alone is a perfect decay: of one structure, or of another one each time; small ones do not tell."""
    time = np.arange(300) / 100
    decays = [np.exp(-2.5 * time) * np.sin(2 * np.pi * f * time) for f in hertz]
    values = np.concatenate([np.zeros(100), *decays])
    noise = 1e-3 * np.random.default_rng(1).standard_normal(values.size)
    found = analyse((np.arange(values.size) / 100, values + noise))
    said = [check.level for check in found.verdict.checks if check.remark.code is RecordCheck.NOT_REPEATED]
    assert said == ([] if level is None else [level])
    (used,) = found.used
    small = [used, *(replace(other, level=used.level - 21.0) for other in found.decays if other.start != used.start)]
    beside = doubts_of((used,), found.identification, small)
    assert RecordCheck.NOT_REPEATED not in {check.remark.code for check in beside}


def before_its_end(**of_larger: Any) -> list[Check]:
    """Return what is said of the clean end of a decay, of which another one is the larger start."""
    time = np.arange(300) / 100
    noise = 1e-3 * np.random.default_rng(1).standard_normal(time.size)
    found = analyse((time, np.exp(-2.5 * time) * np.sin(10 * np.pi * time) + noise))
    used = Decay(
        start=1.0, stop=4.0, rank=1, kind=None, level=26.0, cycles=9.0, strength=60.0, wn=np.array([10 * np.pi]),
        zeta=np.array([0.08]), doubts=(),
    )  # fmt: skip
    larger = replace(used, rank=2, **{"start": 0.6, "stop": 3.0, "level": 56.0, **of_larger})
    checks = doubts_of((used,), found.identification, (used, larger))
    return [check for check in checks if check.remark.code is RecordCheck.DIED_BEFORE]


@pytest.mark.parametrize(
    ("more", "early", "hertz", "said"), [(30, 0.4, 17.6, 1), (5, 0.4, 17.6, 0), (30, 0.4, 5.01, 0), (30, -1, 17.6, 0)]
)
def test_a_mode_of_a_larger_decay_before_is_named(more: float, early: float, hertz: float, said: int) -> None:
    """A clean end of a decay was called sound, though a mode with ten times its motion had died before it."""
    named = before_its_end(start=1.0 - early, level=26.0 + more, wn=2 * np.pi * np.array([5.0, hertz]))
    assert [(check.level, f"{hertz:g} Hz" in str(check)) for check in named] == [(Level.CARE, True)] * said


@pytest.mark.parametrize(("doubts", "said"), [((Remark(DecayDoubt.FORCED, {"share": 0.5}),), 1), ((), 0)])
def test_a_larger_start_that_no_fit_follows_is_said(doubts: tuple[Remark, ...], said: int) -> None:
    named = before_its_end(doubts=doubts)
    assert [(check.level, "which no fit follows" in str(check)) for check in named] == [(Level.CARE, True)] * said


@pytest.mark.parametrize(
    ("loud", "forces", "level"),
    [(61.0, 0, Level.DOUBTFUL), (2.0, 0, Level.CARE), (2.0, 1, Level.DOUBTFUL), (1.0, 1, Level.CARE)],
)
def test_a_short_stretch_beside_more_than_noise_is_a_guess(
    decay: Decay, loud: float, forces: int, level: Level
) -> None:
    time = np.arange(200) / 100
    found = identify(as_response(time, (np.exp(-time) * np.sin(9 * time))[None], ["seat"]))
    force = Force(kind=ForceKind.FRICTION, channel=0, other=None)
    found = replace(found, loudness=np.full(len(found.modes), loud), forces=(force,) * forces)
    short = replace(decay, doubts=(Remark(DecayDoubt.FEW_CYCLES, {"cycles": 1.0}),))
    assert [check.level for check in doubts_of((short,), found, ())] == [level]


@pytest.mark.parametrize("doubt", [DecayDoubt.FEW_CYCLES, DecayDoubt.TOO_SHORT])
@pytest.mark.parametrize(("fall", "doubted"), [(1.0, False), (2.5, False), (12.0, True)])
def test_few_cycles_of_a_quick_fit_are_no_doubt_where_many_are_identified(
    doubt: DecayDoubt, fall: float, doubted: bool, decay: Decay
) -> None:
    """Of 1.4 cycles a second, the mode makes 4.3, 4 or 1.8 in the record until it is gone (e to the -3)."""
    time = np.arange(300) / 100
    found = identify(as_response(time, (np.exp(-fall * time / 3) * np.sin(9 * time))[None], ["seat"]))
    short = replace(decay, doubts=(Remark(doubt, {"cycles": 1.0, "hertz": 1.4}),))
    assert bool(doubts_of((short,), found, ())) is doubted


def test_the_end_of_a_doubted_decay_is_no_better_than_all_of_it(decay: Decay) -> None:
    doubt = (Remark(DecayDoubt.FEW_CYCLES, {"cycles": 1.0}),)
    whole = replace(decay, start=2.0, stop=6.0, strength=66.5, doubts=doubt)
    end = replace(decay, start=5.0, stop=6.0, strength=67.5, doubts=doubt)
    later = replace(end, start=7.0, stop=9.0, strength=60.0)
    assert [one.start for one in _ranked([end, whole, later], [])] == [2.0, 7.0, 5.0]
    # One that is beyond doubt is.
    assert [one.start for one in _ranked([replace(end, doubts=()), whole], [])] == [5.0, 2.0]
