from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from suspid import (
    Identification,
    IdentificationError,
    ModalSet,
    RecordError,
    Suspension,
    add_noise,
    eigenmodes,
    free_decay,
    identify,
    quarter_car,
    statespace,
)
from suspid.records import as_response
from suspid.signals import as_signal
from validation import cars

Real = NDArray[np.float64]
ALL = ("seat", "chassis", "tire")
CARS = {"paper": cars.PAPER, "hatchback": cars.HATCHBACK, "saloon": cars.SALOON, "van": cars.VAN}


def record(
    car: Suspension, *, fs: float = 500.0, duration: float = 10.0, channels: tuple[str, ...] = ALL
) -> tuple[Real, Real]:
    """Times and exact samples after an impulse on the tire."""
    time = np.arange(round(duration * fs)) / fs
    response = free_decay(statespace(car, outputs=channels), time, initial_state={"v_tire": 1.0})
    return time, as_signal(response).values


def found(time: Real, values: Real, *, modes: int | None = None) -> Identification:
    return identify(as_response(time, values, [f"y{i}" for i in range(len(values))]), modes=modes)


def noisy(values: Real, seed: int, snr_db: float) -> Real:
    std = np.sqrt(np.mean(values**2, axis=1, keepdims=True) * 10 ** (-snr_db / 10))
    return np.asarray(values + std * np.random.default_rng(seed).standard_normal(values.shape), float)


def spread_of(modes: ModalSet) -> tuple[Real, Real]:
    wn_std, zeta_std = modes.wn_std, modes.zeta_std
    assert wn_std is not None
    assert zeta_std is not None
    return wn_std, zeta_std


def assert_near(modes: ModalSet, truth: ModalSet, *, std: float = 4.5) -> None:
    """All modes, and no others, within a number of their own standard deviations."""
    assert len(modes) == len(truth), (modes.wn, truth.wn)
    wn_std, zeta_std = spread_of(modes)
    assert np.all(np.abs(modes.wn - truth.wn) <= std * wn_std), (modes.wn, truth.wn, wn_std)
    assert np.all(np.abs(modes.zeta - truth.zeta) <= std * zeta_std), (modes.zeta, truth.zeta, zeta_std)


def assert_exact(modes: ModalSet, truth: ModalSet, *, rtol: float = 1e-8) -> None:
    assert len(modes) == len(truth), (modes.wn, truth.wn)
    np.testing.assert_allclose(modes.wn, truth.wn, rtol=rtol)
    np.testing.assert_allclose(modes.zeta, truth.zeta, rtol=rtol)


class TestWithoutNoise:
    @pytest.mark.parametrize("name", CARS)
    @pytest.mark.parametrize(("fs", "duration"), [(200.0, 5.0), (500.0, 10.0), (2000.0, 4.0)])
    def test_exact_at_any_sampling_rate(self, name: str, fs: float, duration: float) -> None:
        assert_exact(found(*record(CARS[name], fs=fs, duration=duration)).modes, eigenmodes(CARS[name]))

    @pytest.mark.parametrize("name", CARS)
    @pytest.mark.parametrize("channel", ["seat", "chassis", "tire"])
    def test_exact_from_one_channel(self, name: str, channel: str) -> None:
        assert_exact(found(*record(CARS[name], channels=(channel,))).modes, eigenmodes(CARS[name]))

    def test_exact_for_cars_at_random(self) -> None:
        rng = np.random.default_rng(2024)
        for _ in range(12):
            car = cars.random_car(rng)
            assert_exact(found(*record(car, duration=4.0)).modes, eigenmodes(car))

    @pytest.mark.parametrize("bits", [10, 12, 16])
    @pytest.mark.parametrize("name", CARS)
    def test_a_converter_invents_nothing(self, name: str, bits: int) -> None:
        time, values = record(CARS[name])
        step = 2 * np.max(np.abs(values), axis=1, keepdims=True) / 2**bits
        self.assert_none_invented(found(time, step * np.round(values / step)).modes, eigenmodes(CARS[name]))

    @pytest.mark.parametrize("decimals", [4, *(pytest.param(each, marks=pytest.mark.slow) for each in (6, 8)), 11])
    @pytest.mark.parametrize("name", CARS)
    def test_printed_decimals_invent_nothing(self, name: str, decimals: int) -> None:
        time, values = record(CARS[name])
        peak = np.max(np.abs(values), axis=1, keepdims=True)
        modes = found(time, peak * np.round(values / peak, decimals)).modes
        self.assert_none_invented(modes, eigenmodes(CARS[name]))

    def assert_none_invented(self, modes: ModalSet, truth: ModalSet) -> None:
        # Rounding is no white noise once a channel rests within one step: the modes may be off by a few deviations,
        # but there must be no others. A hundredth of each is far less than they are apart.
        assert 2 <= len(modes) <= len(truth)
        for pole in modes.poles:
            assert np.min(np.abs(truth.poles - pole) / np.abs(truth.poles)) < 1e-2


class TestInvariances:
    """What does not change the motion does not change the modes."""

    @pytest.fixture(params=["paper", "hatchback"])
    def noise(self, request: pytest.FixtureRequest) -> tuple[Real, Real]:
        time, values = record(CARS[str(request.param)])
        return time, noisy(values, 17, 25.0)

    def same(self, one: ModalSet, other: ModalSet, *, std: float = 1e-2) -> None:
        wn_std, zeta_std = spread_of(one)
        assert len(one) == len(other)
        assert np.all(np.abs(one.wn - other.wn) < std * wn_std)
        assert np.all(np.abs(one.zeta - other.zeta) < std * zeta_std)
        np.testing.assert_allclose(spread_of(other)[0], wn_std, rtol=std)

    @pytest.mark.parametrize(
        "change",
        [
            lambda y: 1e-9 * y,
            lambda y: -1e7 * y,
            lambda y: y * np.array([[1e-3], [1.0], [1e4]]),
            lambda y: y[[2, 0, 1]],
        ],
        ids=["small unit", "large unit, upside down", "own units", "other order"],
    )
    def test_units_and_order(self, noise: tuple[Real, Real], change: Callable[[Real], Real]) -> None:
        self.same(found(*noise).modes, found(noise[0], change(noise[1])).modes)

    def test_a_constant(self, noise: tuple[Real, Real]) -> None:
        size = np.max(np.abs(noise[1]), axis=1, keepdims=True)
        self.same(found(*noise).modes, found(noise[0], noise[1] + 30 * size).modes)

    def test_the_start_of_the_clock(self, noise: tuple[Real, Real]) -> None:
        self.same(found(*noise).modes, found(noise[0] - 123.0, noise[1]).modes)

    @pytest.mark.parametrize("factor", [1e-3, 60.0])
    def test_the_unit_of_time(self, noise: tuple[Real, Real], factor: float) -> None:
        one, other = found(*noise).modes, found(factor * noise[0], noise[1]).modes
        assert len(one) == len(other)
        np.testing.assert_allclose(other.wn * factor, one.wn, rtol=1e-9)
        np.testing.assert_allclose(other.zeta, one.zeta, rtol=1e-9)
        np.testing.assert_allclose(spread_of(other)[0] * factor, spread_of(one)[0], rtol=1e-6)

    @pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
    def test_a_channel_of_noise_alone(self, noise: tuple[Real, Real], size: float) -> None:
        mute = size * np.random.default_rng(3).standard_normal((1, noise[1].shape[1]))
        one, more = found(*noise).modes, found(noise[0], np.vstack([noise[1], mute])).modes
        # It holds no information: the estimates move by what its chance correlations are worth, next to nothing.
        self.same(one, more, std=0.2)

    def test_a_channel_twice(self, noise: tuple[Real, Real]) -> None:
        # It is taken for news, so the claimed spread shrinks; the modes must be those there were.
        one, more = found(*noise).modes, found(noise[0], np.vstack([noise[1], noise[1][:1]])).modes
        assert len(one) == len(more)
        assert np.all(np.abs(one.wn - more.wn) < 3 * spread_of(one)[0])

    @pytest.mark.parametrize("name", CARS)
    def test_the_start_of_the_record(self, name: str) -> None:
        # A decay is a decay from any sample on.
        time, values = record(CARS[name])
        later = found(time[:-20], noisy(values, 5, 40.0)[:, 20:]).modes
        assert_near(later, eigenmodes(CARS[name]))


class TestNoise:
    @pytest.mark.parametrize("name", CARS)
    @pytest.mark.parametrize("snr_db", [10.0, 30.0, 60.0])
    def test_every_mode_within_its_own_spread(self, name: str, snr_db: float) -> None:
        time, values = record(CARS[name])
        for seed in range(3):
            assert_near(found(time, noisy(values, 300 + seed, snr_db)).modes, eigenmodes(CARS[name]))

    def test_the_spread_is_the_bound(self) -> None:
        from validation.bounds import cramer_rao, decay_amplitudes

        for car in CARS.values():
            time, values = record(car)
            system = statespace(car)
            start = [1.0 if label == "v_tire" else 0.0 for label in system.state_labels]
            std = np.sqrt(np.mean(values**2, axis=1) * 1e-4)
            bound = cramer_rao(*decay_amplitudes(system, start), time, noise_std=std, offset=True)
            wn_std, zeta_std = spread_of(found(time, noisy(values, 8, 40.0)).modes)
            # The level of the noise is known to a hundredth from 5000 samples, and the poles are not the true ones.
            np.testing.assert_allclose(wn_std, bound.wn_std, rtol=0.1)
            np.testing.assert_allclose(zeta_std, bound.zeta_std, rtol=0.1)

    @pytest.mark.parametrize("channels", [1, 2, 3])
    def test_alone_has_no_modes(self, channels: int) -> None:
        invented = 0
        for seed in range(20):
            values = np.random.default_rng(50 * channels + seed).standard_normal((channels, 2000))
            invented += len(found(np.arange(2000) / 400, values).modes)
        assert invented <= 1

    def test_alone_is_refused_where_modes_are_asked_for(self) -> None:
        values = np.random.default_rng(1).standard_normal((1, 2000))
        with pytest.raises(IdentificationError, match="requested"):
            found(np.arange(2000) / 400, values, modes=1)

    @pytest.mark.parametrize("count", [64, 100, 200, 300])
    def test_short_records_invent_nothing(self, count: int) -> None:
        wrong, returned = 0, 0
        for seed in range(10):
            time, values = record(cars.PAPER, fs=200.0, duration=count / 200)
            modes, truth = found(time, noisy(values, seed, 30.0)).modes, eigenmodes(cars.PAPER)
            if len(modes):
                wn_std, _ = spread_of(modes)
                away = np.min(np.abs(modes.wn[:, None] - truth.wn) / wn_std[:, None], axis=1)
                wrong, returned = wrong + int(np.sum(away > 5)), returned + len(modes)
        assert returned >= 10
        assert wrong == 0


class TestAskedFor:
    def test_so_many_come_back(self) -> None:
        time, values = record(cars.PAPER)
        for modes in (1, 2, 3):
            assert len(found(time, noisy(values, 2, 20.0), modes=modes).modes) == modes

    def test_fewer_are_an_error_that_holds_them(self) -> None:
        time, values = record(cars.PAPER)
        with pytest.raises(IdentificationError, match="4 modes were requested, 3") as info:
            found(time, noisy(values, 2, 20.0), modes=4)
        assert info.value.found is not None
        assert_near(info.value.found, eigenmodes(cars.PAPER))


class TestOverdamped:
    CAR = quarter_car(
        chassis_mass=320, tire_mass=40, chassis_stiffness=22e3, tire_stiffness=190e3,
        chassis_damping=6000, tire_damping=50,
    )  # fmt: skip

    def test_real_poles_are_found_as_such(self) -> None:
        truth = eigenmodes(self.CAR)
        assert truth.kinds == ("real", "pair", "real")
        assert_exact(found(*record(self.CAR, channels=("chassis", "tire"))).modes, truth, rtol=1e-7)

    @pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2))])
    def test_under_noise_too(self, seed: int) -> None:
        truth, (time, values) = eigenmodes(self.CAR), record(self.CAR, channels=("chassis", "tire"))
        modes = found(time, noisy(values, seed, 60.0)).modes
        assert len(modes) >= 2
        # Whichever are returned are there, within their spread.
        wn_std, _ = spread_of(modes)
        assert np.all(np.min(np.abs(modes.wn[:, None] - truth.wn) / wn_std[:, None], axis=1) < 4.5)

    @pytest.mark.slow
    def test_a_stiff_damper(self) -> None:
        car = quarter_car(
            seat_mass=80, chassis_mass=320, tire_mass=40,
            seat_stiffness=20e3, chassis_stiffness=22e3, tire_stiffness=190e3,
            seat_damping=900, chassis_damping=15000, tire_damping=50,
        )  # fmt: skip
        truth, (time, values) = eigenmodes(car), record(car)
        for seed in range(4):
            modes = found(time, noisy(values, seed, 40.0)).modes
            wn_std, _ = spread_of(modes)
            assert len(modes) >= 2
            assert np.all(np.min(np.abs(modes.wn[:, None] - truth.wn) / wn_std[:, None], axis=1) < 4.5)


class TestReport:
    def test_fitted_and_residual_are_the_record(self) -> None:
        time, values = record(cars.HATCHBACK)
        response = add_noise(as_response(time, values, ALL), snr_db=20.0, rng=np.random.default_rng(4))
        result = identify(response)
        total = as_signal(result.fitted).values + as_signal(result.residual).values
        np.testing.assert_allclose(total, as_signal(response).values, rtol=0, atol=1e-12 * np.max(np.abs(values)))
        std = np.sqrt(np.mean(values**2, axis=1)) * 0.1
        # A standard deviation from 5000 samples is known to a hundredth.
        np.testing.assert_allclose(result.noise_std, std, rtol=0.05)
        np.testing.assert_allclose(result.explained, 1 - 0.01 / 1.01, atol=2e-3)
        assert np.all(np.abs(result.whiteness) < 4.5 / np.sqrt(5000))
        assert all(name in str(result) for name in ALL)

    def test_shapes_are_those_of_the_car(self) -> None:
        truth, modes = eigenmodes(cars.SALOON), found(*record(cars.SALOON)).modes
        assert modes.shapes is not None
        assert truth.shapes is not None
        np.testing.assert_allclose(modes.shapes, truth.shapes, rtol=0, atol=1e-7)


class TestRoundedAndClipped:
    """What files do to numbers: digits cut off, values cut off."""

    @pytest.mark.parametrize("digits", [4, 6, 9])
    @pytest.mark.parametrize("car", [cars.PAPER, cars.HATCHBACK])
    def test_significant_digits_bring_no_modes(self, car: Suspension, digits: int) -> None:
        clean = free_decay(car, np.arange(5000) / 500, initial_state={"v_tire": 1.0})
        printed = np.array([[float(f"{value:.{digits}g}") for value in row] for row in clean.y])
        found = identify(as_response(clean.time, printed, clean.output_labels)).modes
        truth = eigenmodes(car)
        assert len(found) == len(truth)
        assert found.wn_std is not None
        # Five of its own standard deviations, in 18 values.
        assert np.all(np.abs(found.wn - truth.wn) < 5 * found.wn_std)

    @pytest.mark.parametrize("level", [0.5, 0.95])
    def test_clipping_is_refused_with_its_time(self, level: float) -> None:
        clean = free_decay(cars.SALOON, np.arange(5000) / 500, initial_state={"v_tire": 1.0})
        limit = level * np.max(np.abs(clean.y), axis=1, keepdims=True)
        with pytest.raises(RecordError, match=r"clipped: \d+ samples .* consecutive from t = "):
            identify(as_response(clean.time, np.clip(clean.y, -limit, limit), clean.output_labels))

    def test_a_start_after_the_last_clipped_sample_is_advised_where_samples_are_left(self) -> None:
        time = np.arange(1000) / 500
        swing = np.sin(12 * time) * np.exp(-0.5 * time)
        for values, advice in (
            (swing, "start the record after t = "),
            (swing[::-1], "record it again with a larger ra"),
        ):
            with pytest.raises(RecordError, match=advice):
                identify(as_response(time, np.clip(values, -0.6, 0.6)[None], ["seat"]))

    @pytest.mark.parametrize("bits", [8, 12])
    def test_a_coarse_converter_is_not_clipping(self, bits: int) -> None:
        clean = free_decay(cars.PAPER, np.arange(5000) / 500, initial_state={"v_tire": 1.0})
        step = np.max(np.abs(clean.y), axis=1, keepdims=True) / 2 ** (bits - 1)
        found = identify(as_response(clean.time, np.round(clean.y / step) * step, clean.output_labels)).modes
        assert len(found) == 3


class TestColouredNoise:
    def test_intervals_hold_in_autoregressive_noise(self) -> None:
        from scipy.signal import lfilter

        time = np.arange(5000) / 500
        clean = np.asarray(free_decay(cars.HATCHBACK, time, initial_state={"v_tire": 1.0}).y)
        std = np.sqrt(np.mean(clean**2, axis=1, keepdims=True) * 10**-2.6)
        truth, inside = eigenmodes(cars.HATCHBACK), list[bool]()
        for seed in range(15):
            white = np.random.default_rng(seed).standard_normal((3, len(time) + 500))
            noise = lfilter([1.0], [1.0, -0.5], white)[:, 500:] * np.sqrt(1 - 0.5**2)
            modes = identify(as_response(time, clean + std * noise, ["seat", "chassis", "tire"])).modes
            assert len(modes) == 3
            bounds = modes.interval(0.95)
            inside += list((bounds.wn[:, 0] < truth.wn) & (truth.wn < bounds.wn[:, 1]))
            inside += list((bounds.zeta[:, 0] < truth.zeta) & (truth.zeta < bounds.zeta[:, 1]))
        # 90 values at 95 %: fewer than 79 inside has a chance below 1e-3. Without widening it is about 70.
        assert sum(inside) >= 79


class TestSharedNoise:
    """A channel that stands there twice says nothing more than once."""

    def test_a_copy_narrows_no_interval(self) -> None:
        time, values = record(cars.HATCHBACK, channels=("seat", "chassis"))
        rough = noisy(values, 5, 30.0)
        once = found(time, rough).modes
        copied = found(time, np.vstack([rough, 2.5 * rough[1]]))
        assert "share noise" in str(copied)
        assert once.wn_std is not None
        assert copied.modes.wn_std is not None
        # The bound is that of the largest eigenvalue: never narrower, wider by the square root of two at most.
        ratio = copied.modes.wn_std / once.wn_std
        assert np.all(ratio > 0.999)
        assert np.all(ratio < 1.001 * np.sqrt(2))

    def test_channels_of_their_own_noise_are_left_alone(self) -> None:
        time, values = record(cars.HATCHBACK, channels=("seat", "chassis", "tire"))
        for seed in range(20):
            assert "share noise" not in str(found(time, noisy(values, seed, 20.0)))
