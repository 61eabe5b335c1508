from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from suspid import IdentificationError, InputError, ModalSet, Ridge, Scalogram, Window, cwt, find_ridges, fit_ridges
from suspid.records import as_response
from suspid.signals import Signal
from suspid.wavelets import Morlet, fit_skeleton, sample_noise
from suspid.wavelets.scalogram import Normalization

TIME = np.arange(5000) / 500
OMEGA = np.geomspace(5, 300, 150)
WN, ZETA = 40.0, 0.015


def decay(wn: float = WN, zeta: float = ZETA, phase: float = 0.3, since: float = 0.0) -> NDArray[np.float64]:
    t = TIME - since
    pole = complex(-zeta * wn, wn * np.sqrt(1 - zeta**2))
    return np.asarray(np.where(t >= 0, np.exp(pole * np.maximum(t, 0) + 1j * phase).real, 0.0))


def noise(std: float, seed: int, channels: int = 1) -> NDArray[np.float64]:
    return std * np.random.default_rng(seed).standard_normal((channels, TIME.size))


def scalogram(
    values: NDArray[np.float64],
    bandwidth: float = 22.0,
    normalization: Normalization = "paper",
    omega: NDArray[np.float64] = OMEGA,
) -> Scalogram:
    values = np.atleast_2d(values)
    response = as_response(TIME, values, [f"y{i}" for i in range(len(values))])
    return cwt(response, omega=omega, bandwidth=bandwidth, normalization=normalization)


def stds(modes: ModalSet) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    assert modes.wn_std is not None
    assert modes.zeta_std is not None
    return modes.wn_std, modes.zeta_std


class TestLinesThroughAnExactSkeleton:
    def ridge(self, pole: complex, floor: float = 1e-6) -> Ridge:
        """A skeleton that is an exponential by construction: no transform is involved."""
        t = np.arange(400) / 50
        skeleton = np.array([[2.0], [0.3j]]) * np.exp(pole * t)
        return Ridge(
            omega=20.3,
            wavelet=Morlet(center=2 * np.pi, bandwidth=22.0),
            timepts=t,
            skeleton=skeleton,
            trace=np.full(t.size, 20.3),
            floor=np.full(2, floor),
            window=Window(onset_edge=1.0, record_end=6.0, noise_floor=np.inf),
            onset=0.0,
            channels=("a", "b"),
        )

    @pytest.mark.parametrize("pole", [-0.3 + 20j, -2 + 21j, 0.0 + 20j])
    def test_equation_21(self, pole: complex) -> None:
        modes = fit_ridges([self.ridge(pole)])
        assert modes.wn[0] == pytest.approx(abs(pole), rel=1e-12)
        assert modes.zeta[0] == pytest.approx(-pole.real / abs(pole), abs=1e-12)

    def test_origin_is_the_skeleton_at_the_onset(self) -> None:
        fit = fit_skeleton(self.ridge(-0.3 + 20j))
        np.testing.assert_allclose(np.exp(fit.origin), [2.0, 0.3j], rtol=1e-10)
        np.testing.assert_allclose(np.exp(fit.lines), np.exp(fit.logarithm), rtol=1e-10)

    def test_samples_outside_the_window_do_not_count(self) -> None:
        ridge = self.ridge(-0.3 + 20j)
        spoiled = np.where(ridge.trusted, ridge.skeleton, 7.0 + 3j)
        assert fit_skeleton(replace(ridge, skeleton=spoiled)).pole == pytest.approx(-0.3 + 20j, abs=1e-12)

    def test_weights_are_the_squared_modulus_over_the_squared_noise(self) -> None:
        # A disturbance of the log modulus, through the normal equations written out for one channel.
        ridge = self.ridge(-0.3 + 20j)
        keep = ridge.trusted
        bump = 1e-3 * np.sin(3 * ridge.timepts)
        first = replace(ridge, skeleton=ridge.skeleton[:1] * np.exp(bump), floor=np.ones(1), channels=("a",))
        t = ridge.timepts[keep]
        root = np.abs(first.skeleton[0, keep])
        line = np.linalg.lstsq(root[:, None] * np.column_stack([t, np.ones(t.size)]), root * np.log(root), rcond=None)[
            0
        ]
        assert fit_skeleton(first).pole.real == pytest.approx(line[0], abs=1e-12)

    def test_no_ridges(self) -> None:
        with pytest.raises(InputError, match="no ridges"):
            fit_ridges([])


class TestOneMode:
    @pytest.mark.parametrize("zeta", [0.003, 0.015, 0.04])
    @pytest.mark.parametrize("bandwidth", [8.0, 22.0])
    def test_without_noise(self, zeta: float, bandwidth: float) -> None:
        modes = fit_ridges(find_ridges(scalogram(decay(zeta=zeta), bandwidth), count=1))
        # Of the edge is left what rounding is: in between lies the mirror frequency, e^(-N w0^2) at worst.
        assert modes.wn[0] == pytest.approx(WN, abs=1e-5)
        assert modes.zeta[0] == pytest.approx(zeta, abs=1e-6)

    def test_normalisation_does_not_matter(self) -> None:
        values = decay() + noise(0.01, 0)
        paper, amplitude = (fit_ridges(find_ridges(scalogram(values, 22.0, n))) for n in ("paper", "amplitude"))
        # The peaks of the two differ a little; both are then moved to the skeleton's own frequency.
        assert abs(paper.wn[0] - amplitude.wn[0]) < 0.1 * stds(paper)[0][0]

    def test_refined_between_the_rows(self) -> None:
        (ridge,) = find_ridges(scalogram(decay()), count=1)
        damped = WN * np.sqrt(1 - ZETA**2)
        assert np.min(np.abs(OMEGA - damped)) > 0.1
        assert ridge.omega == pytest.approx(damped, abs=1e-3)

    def test_trace_stays_on_the_row_nearest(self) -> None:
        (ridge,) = find_ridges(scalogram(decay()), count=1)
        nearest = OMEGA[np.argmin(np.abs(np.log(OMEGA / WN)))]
        spacing = np.log(OMEGA[1] / OMEGA[0])
        assert np.all(np.abs(np.log(ridge.trace[ridge.trusted] / nearest)) < 1.01 * spacing)

    def test_a_silent_channel_does_no_harm(self) -> None:
        modes = fit_ridges(find_ridges(scalogram(np.stack([decay(), np.zeros(TIME.size)])), count=1))
        assert modes.wn[0] == pytest.approx(WN, abs=1e-5)

    def test_a_second_channel_halves_the_variance(self) -> None:
        values = decay()
        one = stds(fit_ridges(find_ridges(scalogram(values + noise(0.02, 0)), count=1)))
        two = stds(fit_ridges(find_ridges(scalogram(values + noise(0.02, 0, channels=2)), count=1)))
        # The noise of each channel is estimated, to 1 / sqrt(2500) or so, and the window's end is rounded to a sample.
        np.testing.assert_allclose(np.array(one) / np.array(two), np.sqrt(2), rtol=0.1)


@pytest.mark.slow
class TestCalibration:
    @pytest.mark.parametrize("bandwidth", [8.0, 30.0])
    @pytest.mark.parametrize("std", [0.003, 0.03])
    def test_errors_are_as_large_as_they_say(self, bandwidth: float, std: float) -> None:
        deviates = []
        for seed in range(60):
            modes = fit_ridges(find_ridges(scalogram(decay() + noise(std, seed), bandwidth), count=1))
            wn_std, zeta_std = stds(modes)
            deviates.append([(modes.wn[0] - WN) / wn_std[0], (modes.zeta[0] - ZETA) / zeta_std[0]])
        rms = np.sqrt(np.mean(np.square(deviates), axis=0))
        # The rms of 60 normal deviates scatters by 9 %: three of those about 0.9 to 1.1.
        assert np.all((rms > 0.65) & (rms < 1.4)), rms


class TestNoiseOfTheSamples:
    @pytest.mark.parametrize("std", [1e-6, 0.02, 50.0])
    def test_is_that_of_white_noise_under_a_decay(self, std: float) -> None:
        values = decay() * std * 100 + noise(std, 0)
        signal = Signal(start=0.0, step=0.002, values=values, channels=("y",))
        # The median of 2500 details scatters by 1.17 / sqrt(5000).
        assert float(sample_noise(signal)[0]) == pytest.approx(std, rel=0.06)


class TestWindow:
    def test_starts_behind_the_edge_and_stops_before_the_end(self) -> None:
        (ridge,) = find_ridges(scalogram(decay(zeta=0.002)), count=1)
        cone = float(ridge.wavelet.envelope(ridge.omega))
        assert ridge.window.start > 3 * cone
        assert ridge.window.stop < 10.0 - 2 * cone
        assert ridge.window.reason == "record end"

    def test_stops_where_the_skeleton_meets_the_noise(self) -> None:
        std = 0.1
        (ridge,) = find_ridges(scalogram(decay() + noise(std, 0)), count=1)
        assert ridge.window.reason == "noise floor"
        # The law: |gain| e^(-zeta w t) / 2 = 3 sigma sqrt(h) noise_gain.
        gain = abs(ridge.wavelet.gain(complex(-ZETA * WN, WN), ridge.scale)) / 2
        floor = std * np.sqrt(1 / 500) * ridge.wavelet.noise_gain()
        meets = np.log(gain / (3 * floor)) / (ZETA * WN)
        # Noise at a third of the modulus moves the crossing by about log(1 + 1/3) / (zeta w), either way.
        assert ridge.window.stop == pytest.approx(meets, abs=2 * np.log(4 / 3) / (ZETA * WN))

    def test_more_noise_lets_it_start_and_stop_sooner(self) -> None:
        windows = [find_ridges(scalogram(decay() + noise(s, 0)), count=1)[0].window for s in (1e-3, 0.1, 0.3)]
        assert windows[0].start > windows[1].start > windows[2].start
        assert windows[0].stop > windows[1].stop > windows[2].stop

    def test_at_its_start_the_edge_is_of_the_size_of_the_noise(self) -> None:
        # Edge alone: the skeleton of the clean record less the exponential through its undisturbed part.
        std = 1e-3
        (ridge,) = find_ridges(scalogram(decay() + noise(std, 0)), count=1)
        clean = cwt(as_response(TIME, decay()[None], ["y"]), omega=[ridge.omega], bandwidth=22.0)
        pole = complex(-ZETA * WN, WN * np.sqrt(1 - ZETA**2))
        exact = 0.5 * np.exp(0.3j) * ridge.wavelet.gain(pole, ridge.scale) * np.exp(pole * clean.timepts(0))
        edge = np.abs(clean.rows[0][0] - exact)
        behind = (clean.timepts(0) >= ridge.window.start) & (clean.timepts(0) <= ridge.window.stop)
        assert np.max(edge[behind]) < 5 * ridge.floor[0]

    @pytest.mark.parametrize("since", [0.0, 1.0, 3.0])
    def test_follows_the_onset(self, since: float) -> None:
        values = decay(since=since) + noise(1e-3, 0)
        (ridge,) = find_ridges(scalogram(values), count=1)
        cone = float(ridge.wavelet.envelope(ridge.omega))
        assert abs(ridge.onset - since) < 0.7 * cone
        assert ridge.window.start > since + cone
        modes = fit_ridges([ridge])
        assert modes.wn[0] == pytest.approx(WN, abs=4.5 * stds(modes)[0][0])
        assert modes.zeta[0] == pytest.approx(ZETA, abs=4.5 * stds(modes)[1][0])


class TestSeveralModes:
    def test_a_weak_mode_beside_one_three_hundred_times_stronger(self) -> None:
        values = decay(60.0, 0.01) + decay(25.0, 0.01) / 300
        modes = fit_ridges(find_ridges(scalogram(values, 12.0), count=2))
        np.testing.assert_allclose(modes.wn, [25.0, 60.0], rtol=1e-5)
        np.testing.assert_allclose(modes.zeta, 0.01, rtol=1e-3)

    def test_the_most_energetic_are_returned_in_order_of_frequency(self) -> None:
        values = decay(20.0, 0.01) + 0.1 * decay(60.0, 0.01) + 3 * decay(150.0, 0.01)
        found = find_ridges(scalogram(values), count=2)
        np.testing.assert_allclose([r.omega for r in found], [20.0, 150.0], rtol=1e-3)

    def test_close_modes_need_a_longer_wavelet(self) -> None:
        # 4 % apart: the spectrum of N is e^(-N w0^2 0.04^2 / 4) down at the other mode, 0.7 at 22 and 2e-6 at 800.
        values, fine = decay(100.0, 0.0005) + decay(104.0, 0.0005), np.geomspace(80, 130, 200)
        modes = fit_ridges(find_ridges(scalogram(values, 800.0, omega=fine), count=2))
        np.testing.assert_allclose(modes.wn, [100.0, 104.0], rtol=1e-5)
        with pytest.raises(IdentificationError, match="of 2 ridges found"):
            find_ridges(scalogram(values, 22.0, omega=fine), count=2)


class TestWhatIsNoRidge:
    @pytest.mark.parametrize("count", [None, 1, 4])
    @pytest.mark.parametrize("seed", range(4))
    def test_noise(self, count: int | None, seed: int) -> None:
        with pytest.raises(IdentificationError):
            find_ridges(scalogram(noise(1.0, seed, channels=2)), count=count)

    @pytest.mark.parametrize("std", [0.0, 0.01])
    @pytest.mark.parametrize("bandwidth", [5.0, 22.0])
    def test_more_than_there_are(self, std: float, bandwidth: float) -> None:
        values = decay(21.0, 0.01) + decay(90.0, 0.01) + noise(std, 0)
        with pytest.raises(IdentificationError, match=r"2 of 3 ridges .* at 2\d.*, (90|89.99|90.01) rad/s") as info:
            find_ridges(scalogram(values, bandwidth), count=3)
        assert info.value.found is not None
        np.testing.assert_allclose(info.value.found.wn, [21.0, 90.0], rtol=1e-3)

    def test_a_click(self) -> None:
        values = np.zeros(TIME.size)
        values[2500] = 1.0
        with pytest.raises(IdentificationError):
            find_ridges(scalogram(values), count=1)

    def test_a_growing_oscillation(self) -> None:
        with pytest.raises(IdentificationError, match="0 of 1 ridges"):
            find_ridges(scalogram(decay()[::-1]), count=1)

    def test_impossible_wishes(self) -> None:
        with pytest.raises(InputError, match="count=0 must be a whole number"):
            find_ridges(scalogram(decay()), count=0)
        with pytest.raises(InputError, match="has 1 rows; a maximum over scale needs at least 3"):
            find_ridges(cwt(as_response(TIME, decay()[None], ["y"]), omega=[40.0], bandwidth=22.0))
