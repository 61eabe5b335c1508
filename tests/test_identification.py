from collections.abc import Sequence
from pathlib import Path

import control
import numpy as np
import pytest
from bounds import modal_bound
from numpy.typing import NDArray

from suspid import (
    Identification,
    IdentificationError,
    InputError,
    ModalSet,
    RecordError,
    RecordWarning,
    Suspension,
    add_noise,
    eigenmodes,
    free_decay,
    identify,
    quarter_car,
    read_record,
)
from suspid.records import as_response
from suspid.signals import as_signal
from suspid.words.identification import ModeCheck
from validation import cars

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
TIME = np.arange(5000) / 500


def paper_car() -> Suspension:
    return cars.PAPER


def other_cars() -> list[Suspension]:
    """Light damping, for which the ridge method is meant: zeta 0.3 to 3 %."""
    seatless = quarter_car(
        chassis_mass=400,
        tire_mass=40,
        chassis_stiffness=20e3,
        tire_stiffness=200e3,
        chassis_damping=80,
        tire_damping=20,
    )
    seated = quarter_car(
        seat_mass=80,
        chassis_mass=400,
        tire_mass=40,
        seat_stiffness=80e3,
        chassis_stiffness=100e3,
        tire_stiffness=400e3,
        seat_damping=60,
        chassis_damping=100,
        tire_damping=20,
    )
    return [seatless, seated]


def picked(response: control.TimeResponseData, channels: Sequence[str]) -> control.TimeResponseData:
    signal = as_signal(response)
    rows = [signal.channels.index(name) for name in channels]
    return as_response(signal.timepts, signal.values[rows], channels)


def changed(response: control.TimeResponseData, values: NDArray[np.float64]) -> control.TimeResponseData:
    signal = as_signal(response)
    return as_response(signal.timepts, values, signal.channels)


def kicked(car: Suspension, timepts: NDArray[np.float64] = TIME) -> control.TimeResponseData:
    return free_decay(car, timepts, initial_state={"v_tire": 1.0})


def noisy(response: control.TimeResponseData, seed: int, snr_db: float = 20.0) -> control.TimeResponseData:
    return add_noise(response, snr_db=snr_db, rng=np.random.default_rng(seed))


def ridge(response: control.TimeResponseData, modes: int | None = 3, bandwidth: float | None = None) -> Identification:
    return identify(response, modes=modes, method="ridge", bandwidth=bandwidth)


def bound(response: control.TimeResponseData, truth: ModalSet, snr_db: float) -> tuple[NDArray[np.float64], ...]:
    signal = as_signal(response)
    std = np.sqrt(np.mean(signal.values**2, axis=1) * 10 ** (-snr_db / 10))
    return modal_bound(truth.wn, truth.zeta, signal.values, signal.timepts - signal.start, std)


def assert_within(found: ModalSet, truth: ModalSet, *, std: float) -> None:
    """Errors below a number of the estimate's own standard deviations."""
    assert len(found) == len(truth)
    wn_std, zeta_std = found.wn_std, found.zeta_std
    assert wn_std is not None
    assert zeta_std is not None
    assert np.all(np.abs(found.wn - truth.wn) < std * wn_std), (found.wn, truth.wn, wn_std)
    assert np.all(np.abs(found.zeta - truth.zeta) < std * zeta_std), (found.zeta, truth.zeta, zeta_std)


class TestSize:
    """Multiplying a record by a power of two changes no pole, within the sizes that records have."""

    @pytest.mark.parametrize("exponent", [-80, 80])
    def test_poles_stay(self, exponent: int) -> None:
        rng = np.random.default_rng(1)
        decay = free_decay(cars.PAPER, np.arange(1250) * 0.004, initial_state={"v_tire": 1.0})
        signal = as_signal(add_noise(decay, snr_db=30.0, rng=rng))
        plain = identify(as_response(signal.timepts, signal.values, signal.channels), candidates=[4.0])
        values = np.ldexp(signal.values, exponent)
        scaled = identify(as_response(signal.timepts, values, signal.channels), candidates=[4.0])
        np.testing.assert_allclose(scaled.modes.poles, plain.modes.poles, rtol=1e-9)
        np.testing.assert_allclose(np.ldexp(scaled.noise_std, -exponent), plain.noise_std, rtol=1e-9)
        assert str(scaled.verdict) == str(plain.verdict)

    @pytest.mark.parametrize("factor", [1e-250, 1e250])
    def test_beyond_that_a_channel_is_refused_by_name(self, factor: float) -> None:
        signal = as_signal(free_decay(cars.PAPER, np.arange(1250) * 0.004, initial_state={"v_tire": 1.0}))
        values = signal.values * np.array([[1.0], [factor], [1.0]])
        with pytest.raises(RecordError, match="channel 'chassis' reaches"):
            identify(as_response(signal.timepts, values, signal.channels))


class TestBoundItself:
    def test_is_the_known_one_for_the_seat_at_20_db(self) -> None:
        seat = picked(kicked(paper_car()), ["seat"])
        wn, _ = bound(seat, eigenmodes(paper_car()), 20.0)
        # Published to the last digit printed.
        for found, published, digit in zip(wn, (0.0006, 0.016, 0.090), (1e-4, 1e-3, 1e-3), strict=True):
            assert found == pytest.approx(published, abs=digit / 2)

    def test_of_one_long_decay_is_the_closed_form(self) -> None:
        # A e^(-d t) cos(w t + phi): about their mean, weighted by e^(-2 d t), times scatter by 1 / (2 d). So
        # 1 / var = (A^2 / 2 s^2 h) (1 / 2 d) (1 / 4 d^2), and var w = var d = 16 d^3 h s^2 / A^2, at step h.
        h, d, w, amplitude, sigma = 1e-3, 0.8, 90.0, 3.0, 0.1
        t = h * np.arange(20000, dtype=float)
        wn, zeta = np.array([np.hypot(w, d)]), np.array([d / np.hypot(w, d)])
        found = modal_bound(wn, zeta, amplitude * np.exp(-d * t) * np.cos(w * t + 0.3)[None], t, np.array([sigma]))
        expected = np.sqrt(16 * d**3 * h) * sigma / amplitude
        assert found[0][0] == pytest.approx(expected, rel=0.02)
        assert found[1][0] * wn[0] == pytest.approx(expected, rel=0.02)


class TestTable1WithoutNoise:
    @pytest.mark.parametrize("bandwidth", [None, 22.0, 8.0])
    def test_mean_absolute_error(self, bandwidth: float | None) -> None:
        truth, found = eigenmodes(paper_car()), ridge(kicked(paper_car()), bandwidth=bandwidth).modes
        assert np.mean(np.abs(found.wn - truth.wn)) <= 1e-4
        assert 100 * np.mean(np.abs(found.zeta - truth.zeta)) <= 1e-3

    def test_every_mode_is_that_good_from_the_tire_alone(self) -> None:
        truth = eigenmodes(paper_car())
        found = ridge(picked(kicked(paper_car()), ["tire"])).modes
        np.testing.assert_allclose(found.wn, truth.wn, rtol=0, atol=1e-4)
        np.testing.assert_allclose(found.zeta, truth.zeta, rtol=0, atol=1e-5)

    def test_shapes_are_those_of_the_car(self) -> None:
        truth, found = eigenmodes(paper_car()), ridge(kicked(paper_car()), bandwidth=22.0).modes
        assert found.channels == ("seat", "chassis", "tire")
        assert found.shapes is not None
        assert truth.shapes is not None
        for ours, exact in zip(found.shapes.T, truth.shapes.T, strict=True):
            mac = abs(np.vdot(ours, exact)) ** 2 / (np.vdot(ours, ours).real * np.vdot(exact, exact).real)
            assert mac == pytest.approx(1.0, abs=1e-6)

    def test_the_fit_explains_the_record(self) -> None:
        found = ridge(kicked(paper_car()), bandwidth=22.0)
        assert np.all(found.explained > 1 - 1e-6)

    @pytest.mark.parametrize("rate", [100, 1000, 3000])
    def test_the_sampling_rate_does_not_matter(self, rate: int) -> None:
        truth = eigenmodes(paper_car())
        found = ridge(kicked(paper_car(), np.arange(10 * rate) / rate), bandwidth=22.0).modes
        np.testing.assert_allclose(found.wn, truth.wn, rtol=0, atol=1e-4)
        np.testing.assert_allclose(found.zeta, truth.zeta, rtol=0, atol=1e-5)

    def test_an_offset_does_not_matter(self) -> None:
        response, truth = kicked(paper_car()), eigenmodes(paper_car())
        # A thousand times the decay's own size: rounding of 1e-13 of that is 1e-10.
        found = ridge(changed(response, as_signal(response).values + np.array([[10.0], [-3.0], [0.5]]))).modes
        np.testing.assert_allclose(found.wn, truth.wn, rtol=0, atol=1e-4)
        np.testing.assert_allclose(found.zeta, truth.zeta, rtol=0, atol=1e-5)

    @pytest.mark.parametrize("factor", [1e-6, 1e6])
    def test_the_unit_does_not_matter(self, factor: float) -> None:
        response = noisy(kicked(paper_car()), seed=0)
        one = ridge(response, bandwidth=22.0).modes
        other = ridge(changed(response, factor * as_signal(response).values), bandwidth=22.0).modes
        np.testing.assert_allclose(other.poles, one.poles, rtol=1e-9)

    @pytest.mark.parametrize("start", [-20.0, 5.0])
    def test_the_start_of_the_clock_does_not_matter(self, start: float) -> None:
        response = noisy(kicked(paper_car()), seed=0)
        later = as_response(TIME + start, as_signal(response).values, response.output_labels)
        np.testing.assert_allclose(
            ridge(later, bandwidth=22.0).modes.poles, ridge(response, bandwidth=22.0).modes.poles, rtol=1e-8
        )


class TestNoiseAt20Decibels:
    SEEDS = 8

    def errors(self, channels: Sequence[str]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Errors over the bound, and errors over their own standard deviations, (seed, quantity)."""
        response, truth = picked(kicked(paper_car()), channels), eigenmodes(paper_car())
        least = np.concatenate(bound(response, truth, 20.0))
        over_bound, over_own = [], []
        for seed in range(self.SEEDS):
            found = ridge(noisy(response, seed), bandwidth=40.0).modes
            assert len(found) == 3
            wn_std, zeta_std = found.wn_std, found.zeta_std
            assert wn_std is not None
            assert zeta_std is not None
            error = np.concatenate([found.wn - truth.wn, found.zeta - truth.zeta])
            over_bound.append(error / least)
            over_own.append(error / np.concatenate([wn_std, zeta_std]))
        return np.array(over_bound), np.array(over_own)

    @pytest.mark.parametrize("channels", [("tire",), ("seat", "chassis", "tire")])
    def test_within_four_times_the_bound_and_calibrated(self, channels: Sequence[str]) -> None:
        over_bound, over_own = self.errors(channels)
        rms = np.sqrt(np.mean(over_bound**2, axis=0))
        # 4 times over 100 seeds, see validation; measured there 1.2 to 3.0. 8 seeds scatter by a quarter.
        assert np.all(rms < 4.5), rms
        # Six quantities in 8 seeds: the rms of 48 normal deviates scatters by a tenth; 0.8 to 1.25 and thrice that.
        assert 0.65 < np.sqrt(np.mean(over_own**2)) < 1.45
        assert np.max(np.abs(over_own)) < 4.5


class TestOtherRecords:
    @pytest.mark.parametrize("which", [0, 1])
    @pytest.mark.parametrize("seed", [3, 4])
    def test_other_cars(self, which: int, seed: int) -> None:
        car = other_cars()[which]
        response, truth = kicked(car, np.arange(8000) / 400), eigenmodes(car)
        assert_within(ridge(noisy(response, seed, 30.0), len(truth), 22.0).modes, truth, std=4.5)

    @pytest.mark.parametrize("seed", [None, 0, 1])
    def test_two_quiet_seconds_before_the_release(self, seed: int | None) -> None:
        response, truth = kicked(paper_car()), eigenmodes(paper_car())
        values = as_signal(response).values
        late = changed(response, np.concatenate([np.zeros((3, 1000)), values[:, :-1000]], axis=1))
        found = ridge(late if seed is None else noisy(late, seed))
        for each in found.ridges:
            # The onset is told from the peak of the skeleton, to within an envelope or so.
            assert abs(each.onset - 2.0) < float(each.wavelet.envelope(each.omega))
            assert each.window.start > 2.0
        if seed is None:
            np.testing.assert_allclose(found.modes.wn, truth.wn, rtol=0, atol=1e-4)
            np.testing.assert_allclose(found.modes.zeta, truth.zeta, rtol=0, atol=1e-5)
        else:
            assert_within(found.modes, truth, std=4.5)

    def test_measured_beam(self) -> None:
        path = DATA / "vibtest_inout_mat" / "case1.mat"
        if not path.exists():
            pytest.skip(f"{path} is not there")
        # Its stamps are rounded to the millisecond or so.
        with pytest.warns(RecordWarning, match="rounded stamps"):
            beam = read_record(path, channels=["Time_chan_2"], fs=1280.0)
        found = identify(beam, modes=1, method="ridge").modes
        assert found.wn[0] / (2 * np.pi) == pytest.approx(212.1, abs=0.1)
        assert 8e-4 < found.zeta[0] < 1e-3


class TestFewerThanAsked:
    @pytest.mark.parametrize("seed", [None, 0, 1])
    def test_the_error_names_and_holds_those_found(self, seed: int | None) -> None:
        response, truth = kicked(paper_car()), eigenmodes(paper_car())
        with pytest.raises(IdentificationError, match=r"3 of 5 ridges found .* at 21\.27, 50\.1\d, 83\.8") as info:
            ridge(response if seed is None else noisy(response, seed), modes=5, bandwidth=22.0)
        assert info.value.found is not None
        np.testing.assert_allclose(info.value.found.wn, truth.wn, rtol=1e-3)

    @pytest.mark.parametrize("modes", [None, 1, 3])
    @pytest.mark.parametrize("channels", [1, 3])
    def test_noise_has_no_modes(self, modes: int | None, channels: int) -> None:
        values = np.random.default_rng(channels).standard_normal((channels, 3000))
        with pytest.raises(IdentificationError, match="ridges? found"):
            ridge(as_response(TIME[:3000], values, [f"y{i}" for i in range(channels)]), modes, 22.0)

    def test_all_that_stand_out_are_found_unasked(self) -> None:
        for response in (kicked(paper_car()), noisy(kicked(paper_car()), 5)):
            np.testing.assert_allclose(ridge(response, None, 22.0).modes.wn, eigenmodes(paper_car()).wn, rtol=1e-3)


class TestOptionsOfTheOtherMethod:
    def test_a_bandwidth_that_finds_no_modes_is_said(self) -> None:
        record = kicked(paper_car())
        plain, asked = identify(record, modes=3), identify(record, modes=3, bandwidth=8.0)
        assert np.array_equal(plain.modes.poles, asked.modes.poles)
        assert ModeCheck.BANDWIDTH not in {check.remark.code for check in plain.verdict.checks}
        assert "The bandwidth 8 is used only for the scalogram" in str(asked.verdict)

    def test_a_choice_that_finds_no_modes_is_said(self) -> None:
        record = kicked(paper_car())
        plain, asked = identify(record, modes=3), identify(record, modes=3, candidates=[4.0, 8.0])
        assert np.array_equal(plain.modes.poles, asked.modes.poles)
        assert ModeCheck.CANDIDATES not in {check.remark.code for check in plain.verdict.checks}
        assert "candidate bandwidths are used only for the scalogram" in str(asked.verdict)
        wavelet = identify(record, method="ridge", modes=3, candidates=[16.0, 24.0])
        assert ModeCheck.CANDIDATES not in {check.remark.code for check in wavelet.verdict.checks}

    def test_a_choice_beside_a_bandwidth_is_refused(self) -> None:
        with pytest.raises(InputError, match="candidates are not used with bandwidth=8"):
            identify(kicked(paper_car()), method="ridge", bandwidth=8.0, candidates=[2.0, 3.0])


class TestRefusals:
    def test_a_constant_record(self) -> None:
        with pytest.raises(IdentificationError, match="constant"):
            ridge(as_response(TIME, np.full((1, 5000), 3.0), ["seat"]))

    @pytest.mark.parametrize("band", [(0.0, 8.0), (10.0, 8.0), (2.0, 2e5)])
    def test_an_impossible_band(self, band: tuple[float, float]) -> None:
        with pytest.raises(InputError, match="Nyquist"):
            identify(kicked(paper_car()), band_hz=band, method="ridge")
