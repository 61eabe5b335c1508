"""Motion that swells and fades as one smooth wave is not free; what a blow or a release sets in motion is no wave."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import cont2discrete, lfilter, ss2tf

from suspid import Settings, analyse, identify
from suspid.analysis.support import of_a_wave, supported
from suspid.analysis.swelling import LEFT_BY_WAVE, _lasts, _left_by_wave, _level, _top, beyond_wave
from suspid.analysis.used import Used
from suspid.records import as_response, cut
from suspid.units import RealArray
from suspid.words import Level, Reason

PERIOD = 48  # samples
TIME = np.arange(1000) / 100


def swept(seed: int = 1, *, channels: int = 1) -> RealArray:
    """Return a sine that is swept under a Gaussian: exactly one wave, and white noise."""
    rng = np.random.default_rng(seed)
    motion = np.exp(-(((TIME - 5) / 1.2) ** 2)) * np.cos(20 * TIME + 0.5 * (TIME - 5) ** 2)
    return np.outer(np.ones(channels), motion) + 1e-2 * rng.standard_normal((channels, len(TIME)))


def after_force(zeta: float, width: float, *, acceleration: bool) -> RealArray:
    """Return the motion of a mass after half a sine of force, some share of a period wide: exact, held by samples."""
    wn = 2 * np.pi / PERIOD
    a, b, c, d, _ = cont2discrete(
        (
            np.array([[0.0, 1.0], [-(wn**2), -2 * zeta * wn]]),
            np.array([[0.0], [1.0]]),
            np.array([[-(wn**2), -2 * zeta * wn]]) if acceleration else np.array([[1.0, 0.0]]),
            np.array([[float(acceleration)]]),
        ),
        1.0,
    )
    numerator, denominator = ss2tf(a, b, c, d)
    force = np.zeros(8 * PERIOD)
    last = max(2, round(width * PERIOD))
    force[2 * PERIOD : 2 * PERIOD + last] = np.sin(np.pi * np.arange(last) / last)
    return np.asarray(lfilter(numerator[0], denominator, force))[None]


class TestWaves:
    @pytest.mark.parametrize("acceleration", [False, True])
    @pytest.mark.parametrize("zeta", [0.02, 0.1, 0.35])
    @pytest.mark.parametrize("width", [0.05, 0.25, 0.5])
    def test_after_a_blow_of_up_to_half_a_period_no_wave_goes_through_the_top(
        self, zeta: float, width: float, acceleration: bool
    ) -> None:
        motion = after_force(zeta, width, acceleration=acceleration)
        turn = complex(-zeta, 1.0) * 2 * np.pi * 3
        middle = _top(_level(motion, PERIOD), 2 * PERIOD + round(width * PERIOD), PERIOD)
        part = motion[:, middle - PERIOD * 3 // 2 : middle + PERIOD * 3 // 2]
        assert _left_by_wave(part, turn) > LEFT_BY_WAVE * np.sum((part - part.mean()) ** 2)

    @pytest.mark.parametrize("reverse", [1, -1])
    def test_of_a_swept_sine_under_a_gaussian_a_wave_leaves_the_noise(self, reverse: int) -> None:
        """It has seven unknowns: the residual of 300 samples is a chi-square with 293 degrees of freedom."""
        part = swept()[:, 350:650][:, ::reverse] / 1e-2
        assert _left_by_wave(part, complex(-1.0, 60.0)) == pytest.approx(293, abs=4 * np.sqrt(2 * 293))

    def test_a_wave_of_another_frequency_is_none_of_a_mode(self) -> None:
        """As the foot of a fork that is struck: it swings far more, and is still long before the fork."""
        part = swept()[:, 350:650] / 1e-2
        assert _left_by_wave(part, complex(-1.0, 90.0)) == pytest.approx(293, abs=4 * np.sqrt(2 * 293))
        assert _left_by_wave(part, complex(-1.0, 240.0)) == np.inf

    def test_one_that_ends_is_none(self) -> None:
        """A wave that is cut off at its top has the energy of its other half left, of which it takes a part."""
        part = swept()[:, 350:650]
        part[:, 150:] = 0.0
        assert _left_by_wave(part, complex(-1.0, 60.0)) > 10 * LEFT_BY_WAVE * np.sum(part**2)


class TestWhatLasts:
    @pytest.mark.parametrize(("falls_for", "lasts"), [(40.0, False), (900.0, True)])
    @pytest.mark.parametrize("later", [0, 200])
    def test_a_push_by_hand_is_soon_over_and_the_swing_lasts(self, falls_for: float, lasts: bool, later: int) -> None:
        """The way back up a slow fall ends where it is level, which need not be where it began."""
        since = np.arange(-100.0, 2000.0)
        level = np.exp(np.minimum(since / 10, -since / falls_for))
        low = int(np.flatnonzero(level[:100] < 0.5)[-1])
        assert _lasts(level, low, 100 + (later if lasts else 0), 25) == lasts

    def test_for_fewer_than_ten_periods_it_may_be_a_wave(self) -> None:
        since = np.arange(-100.0, 2000.0)
        level = np.exp(np.minimum(since, -since / 900))
        low = int(np.flatnonzero(level[:100] < 0.5)[-1])
        assert _lasts(level, low, 100, 60)
        assert not _lasts(level, low, 100, 70)


class TestRecords:
    @pytest.mark.parametrize("channels", [1, 3])
    def test_the_fall_of_a_wave_is_no_free_decay(self, channels: int) -> None:
        record = as_response(TIME, swept(channels=channels), [f"y{k}" for k in range(channels)])
        found = identify(cut(record, start=5.3, stop=7.0), modes=1)
        stretch = Used(record=found.response, decays=(), used=(), notes=())
        assert of_a_wave(found, stretch, Settings(), record) == (True, True)
        left = supported(found, stretch, Settings(), wave=True)
        assert [c.remark.code for c in left.considered][:1] == [Reason.SWELLS]
        assert supported(found, stretch, Settings(start=5.3), wave=True) is found
        assert of_a_wave(found, stretch, Settings(start=5.3), record) == (False, False)

    @pytest.mark.parametrize("scale", [1e-6, 1e6])
    def test_units_do_not_matter(self, scale: float) -> None:
        record = as_response(TIME, scale * swept(), ["seat"])
        assert beyond_wave(record, identify(cut(record, start=5.3, stop=7.0), modes=1)) <= LEFT_BY_WAVE

    def test_with_few_samples_a_period_more_periods_are_looked_at(self) -> None:
        """Seven unknowns follow any nine samples, those of a release too."""
        free = np.where(TIME > 4, np.exp(4 - TIME) * np.sin(20 * (TIME - 4)), 0.0)[None]
        free = free + 1e-2 * np.random.default_rng(2).standard_normal(free.shape)
        records = [as_response(TIME[::11], motion[:, ::11], ["seat"]) for motion in (swept(), free)]
        left = [
            beyond_wave(one, identify(cut(one, start=start), modes=1))
            for one, start in zip(records, (5.3, 4.1), strict=True)
        ]
        assert left[0] <= LEFT_BY_WAVE
        assert left[1] == np.inf

    @pytest.mark.parametrize("zeta", [0.03, 0.1, 0.3])
    def test_a_release_is_no_wave(self, zeta: float) -> None:
        """It is held, and let go: neither the hold nor the fall of what moves since is the rise of a wave."""
        after = np.maximum(TIME - 4, 0.0)
        fall = np.exp(-20 * zeta * after) * np.cos(20 * after)
        noise = 1e-2 * np.random.default_rng(2).standard_normal(TIME.size)
        record = as_response(TIME, (fall + noise)[None], ["seat"])
        for start in (4.0, 4.2):
            assert beyond_wave(record, identify(cut(record, start=start), modes=1)) == np.inf


def swept_under_window(seed: int) -> RealArray:
    """Return a sine swept by half its frequency under a squared sine that fills half of the record."""
    rng = np.random.default_rng(seed)
    window = np.sin(np.pi * np.clip((TIME - 2) / 5, 0.0, 1.0)) ** 2
    first, rate = rng.uniform(15, 30), rng.uniform(0.5, 1.0)
    motion = np.cos(first * TIME + rate * TIME**2)
    return np.asarray(window * motion + 10 ** rng.uniform(-3, -1.5) * rng.standard_normal(TIME.size))


@pytest.mark.parametrize("seed", [1_200_000, 1_200_003])
def test_a_swept_sine_under_a_window_is_doubted(seed: int) -> None:
    found = analyse(as_response(TIME, swept_under_window(seed)[None], ["seat"]))
    assert found.verdict.level <= Level.DOUBTFUL
    assert any("one smooth wave" in str(check.remark) for check in found.verdict.checks) or not len(found.modes)


def test_what_is_driven_at_its_frequency_and_let_go_is_doubted_and_not_refused() -> None:
    """A stiffening mass after a force at its frequency: its fall is free, but a swept sine looks the same."""
    wn, zeta, end = 4 * np.pi, 0.03, 7.5

    def rate(time: float, state: RealArray) -> list[float]:
        push = 2 * zeta * np.sin(wn * time) if time < end else 0.0
        return [state[1], wn**2 * (push - state[0] - 0.15 * state[0] ** 3) - 2 * zeta * wn * state[1]]

    time = np.arange(0.0, 14.0, 0.005)
    motion = solve_ivp(rate, (0.0, 14.0), [0.0, 0.0], t_eval=time, rtol=1e-8, max_step=0.005).y[:1]
    noise = 1e-3 * np.max(np.abs(motion)) * np.random.default_rng(1).standard_normal(motion.shape)
    found = analyse(as_response(time, motion + noise, ["seat"]))
    assert found.verdict.level is Level.DOUBTFUL
    assert found.modes.wn == pytest.approx([wn], rel=0.02)


@pytest.mark.parametrize("cycles", [3, 5])
def test_what_was_pumped_up_is_doubted_and_not_refused(cycles: int) -> None:
    """A force in step with a mass builds its motion up smoothly; the damped fall after it leaves the noise alone."""
    wn, zeta = 2 * np.pi / 10, 0.1
    a, b, c, d, _ = cont2discrete(
        (
            np.array([[0.0, 1.0], [-(wn**2), -2 * zeta * wn]]),
            np.array([[0.0], [1.0]]),
            np.array([[1.0, 0.0]]),
            np.zeros((1, 1)),
        ),
        1.0,
    )
    numerator, denominator = ss2tf(a, b, c, d)
    force, steps = np.zeros(300), np.arange(10 * cycles)
    force[40 : 40 + len(steps)] = np.sin(wn * steps) * np.minimum(1.0, steps / 10)
    motion = lfilter(numerator[0], denominator, force)
    motion = motion / np.max(np.abs(motion)) + 3e-3 * np.random.default_rng(1).standard_normal((2, 300))
    record = as_response(np.arange(300) / 25, motion, ["seat", "chassis"])
    found = analyse(record)
    assert found.modes.wn == pytest.approx([25 * wn], rel=0.01)
    assert found.modes.zeta == pytest.approx([zeta], rel=0.05)
    assert found.verdict.level is Level.DOUBTFUL
    # The bar that doubts it would refuse it.
    assert 0 < beyond_wave(record, found.identification) <= LEFT_BY_WAVE
