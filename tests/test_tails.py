"""Records that are driven and then left alone: the free end is found, whatever drove it."""

from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import butter, lfilter, lsim, sosfilt

from suspid import analyse, find_decays, identify
from suspid.analysis.forced_start import later_starts
from suspid.decays import tails
from suspid.decays.envelopes import finest
from suspid.decays.releases import releases
from suspid.decays.tails import free_end
from suspid.decays.trials import BLOCKS_A_CYCLE
from suspid.identification.ascent import Quadratic
from suspid.records import as_response
from suspid.signals import Signal, as_signal

Real = NDArray[np.float64]
FS, DRIVEN, COUNT = 200.0, 3.2, 2000
# Pole of the rig [1/s]: 2.4 Hz, 4 % of critical damping.
WN, ZETA = 15.0, 0.04
POLE = WN * (-ZETA + 1j * np.sqrt(1 - ZETA**2))
TIME = np.arange(COUNT) / FS
FREE = TIME >= DRIVEN


def rolling(seed: int) -> Real:
    """A random force from 1 to 25 Hz."""
    sos = butter(4, [1.0, 25.0], "bandpass", fs=FS, output="sos")
    return np.asarray(sosfilt(sos, np.random.default_rng(seed).standard_normal(COUNT)))


def swept(seed: int) -> Real:
    """A sine from .3 to 2.5 times the natural frequency within the time that it acts."""
    low, high = 0.3 * WN, 2.5 * WN
    return np.sin(low * TIME + 0.5 * (high - low) / DRIVEN * TIME**2 + seed)


def motion(force: Real, *, seed: int = 1, noise: float = 0.003) -> Real:
    """The rig under a force until `DRIVEN`, exact for its recursion; noise relative to the free motion."""
    z = np.exp(POLE / FS)
    out = lfilter([1.0], [1.0, -2 * z.real, abs(z) ** 2], np.where(FREE, 0.0, force))
    out /= np.std(out[FREE][: round(FS)])
    return np.asarray(out + noise * np.random.default_rng(100 + seed).standard_normal(COUNT))


def signal(values: Real) -> Signal:
    return Signal(start=0.0, step=1 / FS, values=values[None], channels=("seat",))


@pytest.mark.parametrize(
    ("force", "seed"),
    [(rolling, 2), *(pytest.param(*more, marks=pytest.mark.slow) for more in ((rolling, 7), (swept, 5)))],
)
def test_the_first_command_finds_the_free_end(force: Callable[[int], Real], seed: int) -> None:
    found = analyse(as_response(TIME, motion(force(seed))[None], ["seat"]))
    start = as_signal(found.identification.residual).start
    assert len(found.modes) == 1
    # What a decay that is cut with a part of the force in it misses by far; the bound is ten times smaller.
    assert found.modes.wn[0] == pytest.approx(WN, rel=0.005)
    assert found.modes.zeta[0] == pytest.approx(ZETA, rel=0.05)
    # Fits average over blocks of an eighth of a period or less.
    assert start > DRIVEN - 0.06


def test_the_end_that_is_free_begins_where_the_force_ends() -> None:
    for seed in range(4):
        values = motion(rolling(seed))
        found = free_end(signal(values), finest(values[None]))
        assert found is not None
        first, last = found
        assert DRIVEN - 0.06 < first / FS < DRIVEN + 2 * 2 * np.pi / WN
        assert last == COUNT


@pytest.mark.slow
def test_what_is_driven_to_its_end_has_no_free_end() -> None:
    for seed in range(6):
        values = motion(rolling(seed))[~FREE]
        assert not [d for d in find_decays(as_response(TIME[~FREE], values[None], ["seat"])) if not d.doubts]


class TestSearch:
    """Which end is taken, where what is said of each depends on its length alone: of 2000 samples."""

    VALUES = np.random.default_rng(1).standard_normal((1, COUNT))

    def end(
        self,
        monkeypatch: pytest.MonkeyPatch,
        poles: Callable[[int], int],
        *,
        by: str = "tried",
        blocks: float = 1e6,
        values: Real = VALUES,
    ) -> tuple[int, int] | None:
        """Return the free end. An end without poles is not free, as one of the tests says."""

        def tried(part: Real, *, size: int, least: Real, **_: object) -> object:
            # The rounding error of a mean over several samples.
            assert least == pytest.approx(1e-6 / size)
            count = poles(part.shape[1])
            if not count and by == "tried":
                return None
            return SimpleNamespace(poles=count or 2, residual=np.zeros((1, round(blocks * (count or 2)))), free=count)

        monkeypatch.setattr(tails, "tried", tried)
        monkeypatch.setattr(
            tails, "clearly_driven", lambda part, **_: by == "clearly_driven" and not poles(part.shape[1])
        )
        monkeypatch.setattr(tails, "refused", lambda trial: "reason" if by == "refused" and not trial.free else None)
        monkeypatch.setattr(tails, "fits", lambda trial: by != "fits" or trial.free > 0)
        return free_end(signal(values[0]), np.array([1e-3]))

    @pytest.mark.parametrize("by", ["tried", "clearly_driven", "refused", "fits"])
    @pytest.mark.parametrize("length", [200, 777, 1150, 1990])
    def test_the_longest_free_end_is_found_to_a_percent(
        self, length: int, by: str, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        found = self.end(monkeypatch, lambda own: 2 if own <= length else 0, by=by)
        assert found is not None
        first, last = found
        assert last == COUNT
        assert 0.99 * length <= last - first <= length

    def test_one_free_end_alone_is_chance(self, monkeypatch: pytest.MonkeyPatch) -> None:
        assert self.end(monkeypatch, lambda own: 2 if 110 < own < 130 else 0) is None

    def test_of_two_runs_the_longer_ends_are_taken(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """Three ends each."""
        found = self.end(monkeypatch, lambda own: 2 if 150 < own < 260 or 580 < own < 950 else 0)
        assert found is not None
        assert 930 < found[1] - found[0] < 950

    def test_a_pole_that_the_longest_end_alone_needs_follows_the_force(self, monkeypatch: pytest.MonkeyPatch) -> None:
        found = self.end(monkeypatch, lambda own: 2 if own <= 800 else 4 if own <= 1000 else 0)
        assert found is not None
        assert 0.99 * 800 <= found[1] - found[0] <= 800

    @pytest.mark.parametrize(("cycles", "enough"), [(2.9, False), (3.0, True)])
    def test_each_pole_needs_three_cycles(self, cycles: float, enough: bool, monkeypatch: pytest.MonkeyPatch) -> None:
        found = self.end(monkeypatch, lambda _: 2, blocks=cycles * BLOCKS_A_CYCLE)
        assert (found is not None) is enough

    def test_it_ends_where_all_channels_are_at_rest(self, monkeypatch: pytest.MonkeyPatch) -> None:
        still = np.where(np.arange(COUNT) < 1500, self.VALUES, 0.0)
        found = self.end(monkeypatch, lambda _: 2, values=still)
        assert found is not None
        assert abs(found[1] - 1500) <= 1


def test_noise_has_no_free_end() -> None:
    for seed in range(4):
        values = np.random.default_rng(seed).standard_normal((1, COUNT))
        assert free_end(Signal(start=0.0, step=1 / FS, values=values, channels=("a",)), finest(values)) is None


@pytest.mark.parametrize(("channels", "found"), [(3, True), (1, False)])
def test_releases_of_a_second_and_a_half_need_several_channels(channels: int, *, found: bool) -> None:
    """A corner of a car is pushed four times, 30 samples a second: two modes of a decay have 45 samples."""
    fine, rng = np.arange(0, 24, 1 / 600), np.random.default_rng(4)
    force = sum(
        np.sin(np.pi * (fine - at) / 0.35) * ((fine > at) & (fine < at + 0.35)) for at in (10.0, 12.0, 14.0, 16.0)
    )
    force += np.sin(2 * np.pi * 1.9 * fine) * (fine > 2) * (fine < 8.7)
    motion = np.zeros((3, fine.size))
    for hertz, zeta, shape in ((1.9, 0.3, (0.6, 1.0, -0.8)), (3.1, 0.09, (-0.5, 0.6, 0.3))):
        wn = 2 * np.pi * hertz
        _, own, _ = lsim(([wn**2], [1, 2 * zeta * wn, wn**2]), force, fine)
        motion += np.outer(shape, own)
    values = motion[:channels, ::20][:, :530] + 4e-3 * rng.standard_normal((channels, 530))
    names = ("x", "y", "z")[:channels]
    here, looked = releases(Signal(start=0.0, step=1 / 30, values=values, channels=names), finest(values))
    assert looked > 1
    assert bool(here) == found


@pytest.mark.parametrize("limit", [0.05, 0.2, 0.5])
def test_the_free_end_of_a_clipped_sensor_begins_behind_its_limits(limit: float) -> None:
    """Both levels of a clipped sensor are held again and again; they are not the steps of a coarse one."""
    values = np.exp(POLE * TIME).real + 1e-4 * np.random.default_rng(1).standard_normal(COUNT)
    values = np.clip(values, -limit, limit)[None]
    end = free_end(Signal(start=0.0, step=1 / FS, values=values, channels=("a",)), finest(values))
    assert end is not None
    assert 0 < end[0] - np.flatnonzero(np.abs(values[0]) == limit)[-1] < 10


def test_a_step_of_a_fit_whose_information_is_singular_is_the_shortest() -> None:
    """Two parameters that do the same share the step."""
    alike = Quadratic(unit=np.ones((2, 2)), scale=np.ones(2), gradient=np.ones(2))
    np.testing.assert_allclose(alike.step(0.0), [0.5, 0.5], atol=1e-12)


def test_a_mode_that_is_hardly_known_stands_for_a_force_only_where_the_record_is_driven_before() -> None:
    """A decay from a little before its force ends: after driven motion later starts are tried, after rest not."""
    values, begin = motion(rolling(1)), round((DRIVEN - 0.05) * FS)
    whole = as_response(TIME, values[None], ["seat"])
    found = identify(as_response(TIME[begin:], values[None, begin:], ["seat"]))
    std = found.modes.wn_std
    assert std is not None
    assert np.any(std > 0.025 * found.modes.wn)
    # A start by which a flash is over is tried in any case; those by periods of the other mode are not.
    flash = 3 / float(np.max(-found.modes.poles.real))
    assert max(later_starts(whole, found)) > 2 * flash
    still = np.where(np.arange(COUNT) < begin, values[begin], values)
    assert max(later_starts(as_response(TIME, still[None], ["seat"]), found)) <= flash * (1 + 1e-9)
