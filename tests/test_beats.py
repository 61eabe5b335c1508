"""Two close modes swell and sink in turn: what pendulums coupled by a weak spring do, integrated finely."""

from dataclasses import replace

import control
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from suspid import Settings, analyse, identify
from suspid.analysis.support import of_a_wave
from suspid.analysis.swelling import beats
from suspid.analysis.used import Used
from suspid.identification.noise import WhiteNoise
from suspid.identification.nonlinear.signs import rises_again
from suspid.identification.selection import select
from suspid.records import as_response
from suspid.units import RealArray
from suspid.words import Check, Level, ModeCheck, Remark

WN = 3.2
SLOW = pytest.mark.slow


def coupled(
    rng: np.random.Generator, *, spring: float, drag: float, damping: float, end: float
) -> tuple[control.TimeResponseData, RealArray]:
    """Return the angles of two pendulums with quadratic drag of which the right one is let go, and their wn.

    The sensor of that is the noisier one: the motion of the other is clear, and begins at nothing.
    """

    def rate(_: float, state: RealArray) -> RealArray:
        angles, speeds = state[:2], state[2:]
        pull = spring * (angles - angles[::-1])
        return np.concatenate([speeds, -(WN**2) * np.sin(angles) - pull - (damping + drag * np.abs(speeds)) * speeds])

    time = np.arange(0.0, end, 0.1)
    motion = solve_ivp(rate, (0.0, end), [0.0, -0.2, 0.0, 0.0], t_eval=time, rtol=1e-9, atol=1e-11).y[:2]
    motion += np.array([[0.002], [0.02]]) * rng.standard_normal(motion.shape)
    return as_response(time, motion, ["left", "right"]), np.sqrt([WN**2, WN**2 + 2 * spring])


@pytest.mark.parametrize("seed", [105, *(pytest.param(seed, marks=SLOW) for seed in (109, 120))])
def test_pendulums_that_beat_are_two_modes(seed: int) -> None:
    """What swells again and again, and is two modes, is no wave, nor does its decay end where they are out of step."""
    rng = np.random.default_rng(seed)
    spring, drag, end, damping = rng.uniform([0.1, 0.001, 100, 0.0], [0.6, 0.02, 250, 0.002]).tolist()
    record, wn = coupled(rng, spring=spring, drag=drag, damping=damping, end=end)
    assert analyse(record).modes.wn == pytest.approx(wn, rel=3e-3)


@pytest.mark.parametrize(
    ("seed", "structures"), [(1, False), (15, False), *(pytest.param(seed, True, marks=SLOW) for seed in (1, 15))]
)
def test_forces_follow_what_poles_follow(seed: int, structures: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """One mode with forces is no explanation of two that beat, although their poles have parts beside them.

    The search for structures, which finds none here, takes nearly all of the time.
    """
    if not structures:
        monkeypatch.setattr("suspid.identification.nonlinear.search._structure", lambda *_: None)
    record, _ = coupled(np.random.default_rng(seed), spring=0.51928, drag=0.01415, damping=0.00025, end=132.4)
    assert np.min(identify(record).explained) > 0.9


@pytest.mark.parametrize("wn", [8.5, 9.6, 10.3])
def test_two_modes_are_out_of_step_once_in_each_beat(wn: float) -> None:
    time = np.arange(0.0, 40.0, 0.01)
    motion = np.exp(-0.01 * time) * (np.cos(9 * time) + np.cos(wn * time))
    noise = 1e-3 * np.random.default_rng(1).standard_normal(time.size)
    found = identify(as_response(time, (motion + noise)[None], ["left"]))
    # They are out of step in the middle of each beat, of which the record shows that many.
    assert beats(found) == int(40.0 * abs(wn - 9) / (2 * np.pi) + 0.5)


@pytest.mark.parametrize(("wn", "wave"), [(9.2, False), (9.08, True)])
def test_what_rises_once_may_be_a_wave(wn: float, wave: bool) -> None:
    """Of the slower beat the record shows the first swell alone, which one wave explains as well."""
    time = np.arange(0.0, 70.0, 0.05)
    motion = np.exp(-0.002 * time) * (np.cos(9 * time) - np.cos(wn * time))
    noise = 3e-3 * np.random.default_rng(1).standard_normal(time.size)
    record = as_response(time, (motion + noise)[None], ["left"])
    stretch = Used(record=record, decays=(), used=(), notes=())
    assert of_a_wave(identify(record), stretch, Settings(), record) == (wave, wave)


def test_modes_that_halves_disagree_on_do_not_beat(monkeypatch: pytest.MonkeyPatch) -> None:
    time = np.arange(0.0, 40.0, 0.01)
    motion = np.exp(-0.01 * time) * (np.cos(9 * time) + np.cos(9.6 * time))
    noise = 1e-3 * np.random.default_rng(1).standard_normal(time.size)
    found = identify(as_response(time, (motion + noise)[None], ["left"]))
    assert beats(found) == 4
    disagree = Check(Remark(ModeCheck.HALVES_DISAGREE, {"mode": 1, "apart": 9.0}), Level.CARE)
    monkeypatch.setitem(vars(found), "verdict", replace(found.verdict, checks=(disagree,)))
    assert beats(found) == 0


def test_one_burst_after_the_other_does_not_beat() -> None:
    """A second release is of another phase, which no mode that goes on from the first one has."""
    time = np.arange(0.0, 40.0, 0.01)
    motion = [np.where(time > at, np.exp(-0.2 * (time - at)) * np.sin(9 * (time - at) + at), 0.0) for at in (0, 13, 29)]
    noise = 1e-3 * np.random.default_rng(1).standard_normal(time.size)
    found = identify(as_response(time, (sum(motion) + noise)[None], ["left"]))
    assert beats(found) == 0


@pytest.mark.parametrize(("third", "size", "times"), [(0.0, 1e-3, 1), (0.3, 1e-3, 0), (0.0, 0.15, 0)])
def test_few_modes_explain_nearly_all_of_what_beats(third: float, size: float, times: int) -> None:
    """A beat is seen once: three modes follow any motion that sinks once, and so do two that leave 2 % of it."""
    time = np.arange(0.0, 32.0, 0.01)
    motion = np.exp(-0.01 * time) * (np.cos(9 * time) + np.cos(9.2 * time) + third * np.cos(20 * time))
    noise = size * np.random.default_rng(1).standard_normal(time.size)
    found = identify(as_response(time, (motion + noise)[None], ["left"]))
    assert len(found.modes) == 2 + (third > 0)
    assert beats(found) == times


class TestRisesAgain:
    """A tuned mass damper: near modes of one shape, whose motion sinks and rises while neither swells."""

    TIME = np.asarray(np.arange(1200.0), float)

    def told(self, motion: RealArray, noise: float = 1e-3) -> bool:
        values = np.stack([motion, 0.5 * motion]) + noise * np.random.default_rng(1).standard_normal((2, 1200))
        centred = values - values.mean(axis=1, keepdims=True)
        return rises_again(select(centred, noise=WhiteNoise(least=np.full(2, 1e-22))))

    def mode(self, wn: float, zeta: float) -> RealArray:
        return np.asarray(np.exp(-zeta * wn * self.TIME) * np.cos(wn * self.TIME), float)

    def test_two_modes_do(self) -> None:
        beat = self.mode(0.181, 0.042) + 0.6 * self.mode(0.197, 0.024)
        assert self.told(beat)
        assert not self.told(self.mode(0.181, 0.042))

    def test_parts_of_one_whose_spring_stiffens_do_not(self) -> None:
        def rate(_: float, state: RealArray) -> RealArray:
            x, speed = state
            return np.array([speed, -(0.19**2) * x * (1 + 0.3 * x**2) - 0.0076 * speed])

        solved = solve_ivp(rate, (0.0, 1200.0), [1.0, 0.0], t_eval=self.TIME, rtol=1e-9, atol=1e-12)
        assert not self.told(solved.y[0])
