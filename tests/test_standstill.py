"""Motion that stops: a mode that would go on is none."""

from __future__ import annotations

import importlib
from dataclasses import replace
from typing import Any

import control
import numpy as np
import pytest

from suspid import Identification, Settings, analyse, identify
from suspid.analysis.standstill import swings_on
from suspid.analysis.support import supported
from suspid.analysis.used import Used
from suspid.records import as_response, cut
from suspid.words import Level, ModeCheck, Reason

TIME = np.arange(0, 6, 0.01)
STOP = 2.0


def stopped(*, noise: float = 0.0, after: float = 0.0, light: float = 0.1) -> control.TimeResponseData:
    """Return a mass that stops at once, with a small motion beside its own that has hardly decayed by then."""
    moved = np.exp(-3 * TIME) * np.cos(6 * TIME) + 0.1 * np.exp(-light * TIME) * np.cos(30 * TIME)
    beyond = after * 0.1 * np.cos(30 * TIME)
    values = np.where(TIME < STOP, moved, beyond) + noise * np.random.default_rng(1).standard_normal(TIME.size)
    return as_response(TIME, values[None], ["mass"])


def of(record: control.TimeResponseData) -> Identification:
    return identify(cut(record, stop=STOP - 0.01))


@pytest.mark.parametrize(
    ("made", "on"),
    [
        ({}, True),
        ({"noise": 1e-3}, True),
        ({"after": 0.15}, True),  # a swing is from trough to crest
        ({"after": 0.3}, False),  # what follows hides it
        ({"after": 1.0}, False),  # it goes on
        ({"light": 0.5}, False),  # a third of it is left: a mass stops at a turn
    ],
)
def test_a_mode_that_would_swing_on_is_seen(made: dict[str, float], *, on: bool) -> None:
    record = stopped(**made)
    found = of(record)
    assert len(found.modes) == 2
    assert swings_on(found, record).tolist() == [False, on]


def test_it_is_rejected_and_the_rest_is_doubtful() -> None:
    record = stopped(noise=1e-3)
    found = of(record)
    left = supported(found, Used(record=record, decays=(), used=(), notes=()), Settings(), whole=record)
    assert [complex(pole) for pole in left.modes.poles] == [complex(found.modes.poles[0])]
    assert left.considered[0].remark.code is Reason.STANDS_STILL
    assert left.verdict.level is Level.DOUBTFUL
    assert ModeCheck.STANDS_STILL in {check.remark.code for check in left.verdict.checks}


def test_of_a_record_that_ends_with_its_decay_nothing_is_rejected() -> None:
    record = cut(stopped(noise=1e-3), stop=STOP - 0.01)
    found = of(record)
    assert not swings_on(found, record).any()


def test_a_fit_with_forces_stops_by_itself() -> None:
    record = stopped(noise=1e-3)
    forces: Any = (object(),)
    assert not swings_on(replace(of(record), forces=forces), record).any()


def test_modes_that_are_asked_for_are_not_questioned() -> None:
    record = stopped(noise=1e-3)
    found, used = of(record), Used(record=record, decays=(), used=(), notes=())
    assert supported(found, used, Settings(modes=2), whole=record) is found


def test_of_other_channels_nothing_is_said() -> None:
    record = stopped(noise=1e-3)
    other = as_response(record.time, record.y[:1], ["other"])
    assert not swings_on(of(record), other).any()


def test_the_first_command_tells(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where friction is not found by the fit, its modes are."""
    module = importlib.import_module("suspid.analysis.analyse")
    monkeypatch.setattr(module, "stretch_of", lambda record, _: _used(record))
    found = analyse(stopped(noise=1e-3))
    assert Reason.STANDS_STILL in {c.remark.code for c in found.identification.considered}


def _used(record: control.TimeResponseData) -> Used:
    part = cut(record, stop=STOP - 0.01)
    return Used(record=part, decays=(), used=(), notes=(), identification=identify(part))


def test_a_real_pole_of_a_record_of_microseconds_does_not_overflow() -> None:
    """A capacitor that discharges: it turns never, and the steps are 2e-8 s."""
    time = 2e-8 * np.arange(1000.0)
    noise = 1e-3 * np.random.default_rng(3).standard_normal(time.size)
    record = as_response(time, (np.exp(-4e5 * time) + noise)[None], ["voltage"])
    assert not swings_on(of(record), record).any()
