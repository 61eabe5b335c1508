import math
import tracemalloc

import control
import numpy as np
import pytest
import pywt
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.special import erfc

from suspid import InputError, Morlet, Scalogram, best_bandwidth, cwt
from suspid.records import as_response
from suspid.signals import as_signal
from suspid.wavelets.scalogram import Normalization

TWO_PI = 2 * np.pi
# The spectrum is cut where it is 1e-13 of its peak: what is left out adds up over some hundred bins.
ROUNDING = 1e-11


def record(values: NDArray[np.float64], *, step: float = 0.01, start: float = 0.0) -> control.TimeResponseData:
    values = np.asarray(np.atleast_2d(values), float)
    return as_response(
        start + step * np.arange(values.shape[1], dtype=float), values, [f"y{i}" for i in range(len(values))]
    )


def white(channels: int, samples: int, seed: int = 0) -> NDArray[np.float64]:
    return np.random.default_rng(seed).standard_normal((channels, samples))


def dense_sum(
    values: NDArray[np.float64], *, step: float, omega: float, bandwidth: float, center: float
) -> NDArray[np.complex128]:
    """Eq. (12) term by term: no spectrum, no FFT."""
    scale, t = center / omega, step * np.arange(values.shape[1])
    out = np.empty(values.shape, complex)
    for k, tau in enumerate(t):
        u = (t - tau) / scale
        out[:, k] = values @ (np.exp(-1j * center * u) * np.exp(-(u**2) / bandwidth)) * step / np.sqrt(scale)
    return out


def assert_close(found: NDArray[np.complex128], expected: NDArray[np.complex128], *, rtol: float) -> None:
    """Rtol is relative to the largest expected coefficient."""
    np.testing.assert_allclose(found, expected, rtol=0, atol=rtol * np.max(np.abs(expected)))


class TestEquation12ByDenseSum:
    @pytest.mark.parametrize("samples", [64, 301, 500])
    @pytest.mark.parametrize(
        ("bandwidth", "center"), [(0.3, TWO_PI), (2.0, TWO_PI), (22.0, TWO_PI), (50.0, 3.0), (2.0, 60.0), (1.0, 1.0)]
    )
    # Nyquist is 314.2 rad/s; the last is 0.9995 of it, the first is a third of a cycle in the shortest record.
    @pytest.mark.parametrize("omega", [3.0, 20.0, 150.0, 300.0, 314.0])
    def test_every_coefficient(self, samples: int, bandwidth: float, center: float, omega: float) -> None:
        if Morlet(center=center, bandwidth=bandwidth).envelope(omega) > 10 * samples * 0.01:
            pytest.skip("the wavelet is longer than cwt accepts")
        values = white(2, samples)
        expected = dense_sum(values, step=0.01, omega=omega, bandwidth=bandwidth, center=center)
        found = cwt(record(values), omega=[omega], bandwidth=bandwidth, center=center, full_rate=True)
        assert_close(found.rows[0], expected, rtol=ROUNDING)

    @pytest.mark.parametrize("start", [-3.7, 12.0])
    def test_start_of_the_clock_does_not_matter(self, start: float) -> None:
        values = white(1, 201)
        expected = dense_sum(values, step=0.01, omega=20.0, bandwidth=4.0, center=TWO_PI)
        found = cwt(record(values, start=start), omega=[20.0], bandwidth=4.0, full_rate=True)
        assert_close(found.rows[0], expected, rtol=ROUNDING)
        np.testing.assert_allclose(found.timepts(0), start + 0.01 * np.arange(201), rtol=0, atol=1e-12)

    @pytest.mark.parametrize("normalization", ["paper", "amplitude"])
    def test_many_rows_in_any_order(self, normalization: Normalization) -> None:
        values, omega = white(3, 333), np.array([250.0, 8.0, 40.0, 9.0, 120.0])
        found = cwt(record(values), omega=omega, bandwidth=5.0, normalization=normalization, full_rate=True)
        for i, (w, s) in enumerate(zip(omega, found.scale, strict=True)):
            expected = dense_sum(values, step=0.01, omega=w, bandwidth=5.0, center=TWO_PI)
            divisor = 1.0 if normalization == "paper" else np.sqrt(np.pi * 5.0 * s) / 2
            assert_close(found.coefficients[:, i], expected / divisor, rtol=ROUNDING)


class TestRowsAtTheirOwnRate:
    @pytest.mark.parametrize("samples", [257, 1000, 4099])
    @pytest.mark.parametrize("bandwidth", [0.5, 22.0, 300.0])
    def test_equal_the_full_rate_rows_at_their_samples(self, samples: int, bandwidth: float) -> None:
        response, omega = record(white(2, samples)), np.geomspace(12.0, 313.0, 40)
        own, full = (cwt(response, omega=omega, bandwidth=bandwidth, full_rate=rate) for rate in (False, True))
        assert bandwidth < 22 or max(own.strides) > 1
        for i, stride in enumerate(own.strides):
            assert_close(own.rows[i], full.rows[i][:, ::stride], rtol=ROUNDING)
            np.testing.assert_allclose(own.timepts(i), full.timepts(i)[::stride], rtol=0, atol=1e-10)

    def test_every_sample_of_the_record_counts_once(self) -> None:
        scalogram = cwt(record(white(1, 1003)), omega=np.geomspace(12, 313, 30), bandwidth=50.0)
        for i in range(30):
            assert np.sum(scalogram.weights(i)) == pytest.approx(1003, abs=1e-9)

    def test_energy_is_that_of_the_full_rate_row(self) -> None:
        # A row holds no energy beyond its band, so the trapezoidal sum over a smooth decay to zero is exact.
        t = 0.01 * np.arange(4096)
        values = np.exp(-((t - 20) ** 2) / 8) * np.cos(40 * t)
        own, full = (cwt(record(values), omega=[40.0], bandwidth=60.0, full_rate=rate) for rate in (False, True))
        assert own.strides[0] >= 8
        energy = [float(np.abs(s.rows[0][0]) ** 2 @ s.weights(0)) for s in (own, full)]
        assert energy[0] == pytest.approx(energy[1], rel=1e-10)

    def test_coefficients_of_uneven_rows_are_refused(self) -> None:
        with pytest.raises(InputError, match="full_rate=True"):
            _ = cwt(record(white(1, 1000)), omega=[20.0], bandwidth=22.0).coefficients


class TestLinearity:
    def test_of_the_sum_is_the_sum(self) -> None:
        x, y = white(2, 700, seed=1), white(2, 700, seed=2)
        parts = [cwt(record(v), omega=[15.0, 200.0], bandwidth=9.0) for v in (x, y, 3 * x - 2 * y)]
        for row in range(2):
            a, b, both = (s.rows[row] for s in parts)
            assert_close(both, 3 * a - 2 * b, rtol=1e-13)

    def test_channels_do_not_mix(self) -> None:
        values = white(3, 500)
        together = cwt(record(values), omega=[30.0], bandwidth=9.0).rows[0]
        for i in range(3):
            assert_close(together[i], cwt(record(values[i]), omega=[30.0], bandwidth=9.0).rows[0][0], rtol=1e-13)


class TestShiftCovariance:
    def test_a_later_signal_has_a_later_transform(self) -> None:
        pulse, late = np.zeros(1500), 187
        pulse[300:500] = white(1, 200)[0]
        rows = [
            cwt(record(v), omega=[25.0, 280.0], bandwidth=6.0, full_rate=True).coefficients[0]
            for v in (pulse, np.roll(pulse, late))
        ]
        assert_close(rows[1][:, late:], rows[0][:, :-late], rtol=ROUNDING)


class TestScalingLaw:
    @pytest.mark.parametrize("slower", [0.01, 3.0, 700.0])
    def test_a_slower_clock_scales_the_transform_by_its_root(self, slower: float) -> None:
        # x(t/a) at scale a s: CWT'(a s, a tau) = sqrt(a) CWT(s, tau).
        values, omega = white(1, 900), np.array([14.0, 99.0])
        here = cwt(record(values), omega=omega, bandwidth=8.0)
        there = cwt(record(values, step=0.01 * slower), omega=omega / slower, bandwidth=8.0)
        assert here.strides == there.strides
        for a, b in zip(here.rows, there.rows, strict=True):
            assert_close(b, np.sqrt(slower) * a, rtol=ROUNDING)


class TestWaveletSpectrum:
    @pytest.mark.parametrize("bandwidth", [0.5, 2.0, 22.0])
    @pytest.mark.parametrize("away", [-1.5, 0.0, 0.3, 4.0])
    def test_is_the_fourier_integral_of_the_waveform(self, bandwidth: float, away: float) -> None:
        wavelet = Morlet(center=TWO_PI, bandwidth=bandwidth)
        omega, end = TWO_PI + away, 9 * np.sqrt(bandwidth)

        def part(t: float, turn: complex) -> float:
            return float((wavelet.waveform(t) * np.exp(-1j * omega * t) * turn).real)

        # e^-81 is left beyond the ends.
        real, imaginary = (quad(part, -end, end, args=(turn,), limit=500, epsabs=1e-12)[0] for turn in (1, -1j))
        assert real == pytest.approx(float(wavelet.spectrum(omega)), abs=1e-9)
        assert imaginary == pytest.approx(0.0, abs=1e-9)

    @pytest.mark.parametrize("name", ["center", "bandwidth"])
    @pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
    def test_impossible_wavelets_are_refused(self, name: str, value: float) -> None:
        given = {"center": TWO_PI, "bandwidth": 2.0, name: value}
        with pytest.raises(InputError, match=name):
            Morlet(center=given["center"], bandwidth=given["bandwidth"])


class TestGainOfAnExponential:
    @pytest.mark.parametrize("pole", [-0.3 + 20j, -1.5 + 25j, 1.0 + 20j, 0.0 + 17j, -0.5 + 5j])
    @pytest.mark.parametrize("bandwidth", [0.5, 2.0, 9.0])
    def test_interior_of_the_transform_is_gain_times_the_exponential(self, pole: complex, bandwidth: float) -> None:
        t = 0.002 * np.arange(6000) - 6.0
        found = cwt(
            record(np.exp(pole * t).real, step=0.002, start=-6.0), omega=[20.0], bandwidth=bandwidth, full_rate=True
        )
        # Re(e^pt) is half of e^pt and half of its conjugate; each goes through with its own gain.
        both = (pole, pole.conjugate())
        expected = sum(0.5 * found.wavelet.gain(p, found.scale[0]) * np.exp(p * t) for p in both)
        near = np.abs(t) < 0.5
        # The ends lie 5.5 s off, at least 5.8 cones, of which damping takes |Re p| cone / 2 = 0.7: e^-26. What is cut
        # off the spectrum, 1e-13 of its peak, and rounding are those of the record's loud end, e^9 at most.
        peak = float(np.abs(found.wavelet.gain(20j, found.scale[0])))
        np.testing.assert_allclose(found.rows[0][0, near], expected[near], rtol=0, atol=1e-8 * peak)

    def test_damping_does_not_bias_the_slopes(self) -> None:
        t = 0.002 * np.arange(10000)
        row = cwt(record(np.exp(-0.4 * t) * np.cos(30 * t), step=0.002), omega=[29.0], bandwidth=20.0, full_rate=True)
        inside = row.rows[0][0, 4000:6000]
        slope = np.log(inside[-1] / inside[0] * np.exp(-30j * 1999 * 0.002)) / (1999 * 0.002)
        # What is left is the mirror frequency -30: e^-(N (29 + 30)^2 s^2 / 4) is nothing.
        assert complex(slope) == pytest.approx(-0.4, abs=1e-9)


class TestNoiseGain:
    @pytest.mark.parametrize(("bandwidth", "omega"), [(2.0, 40.0), (22.0, 40.0), (4.0, 200.0)])
    def test_standard_deviation_of_white_noise_through_a_row(self, bandwidth: float, omega: float) -> None:
        sigma, step = 0.7, 0.005
        scalogram = cwt(record(sigma * white(20, 20000), step=step), omega=[omega], bandwidth=bandwidth)
        inside = scalogram.rows[0][:, scalogram.inside(0, cones=4)]
        # |W|^2 is exponential; correlated over a time of s sqrt(pi N), so this many independent values:
        independent = 20 * 100 / float(scalogram.scale[0] * np.sqrt(np.pi * bandwidth))
        expected = sigma * np.sqrt(step) * scalogram.wavelet.noise_gain()
        assert np.mean(np.abs(inside) ** 2) == pytest.approx(expected**2, rel=4 / np.sqrt(independent))


class TestAmplitudeNormalization:
    @pytest.mark.parametrize("omega", [12.0, 20.0, 90.0])
    @pytest.mark.parametrize("bandwidth", [3.0, 30.0])
    def test_modulus_is_the_amplitude_of_a_tone(self, omega: float, bandwidth: float) -> None:
        tone = record(2.5 * np.cos(omega * 0.01 * np.arange(4000) + 0.4))
        scalogram = cwt(tone, omega=[omega], bandwidth=bandwidth, normalization="amplitude")
        modulus = np.abs(scalogram.rows[0][0, scalogram.inside(0, cones=5.5)])
        assert modulus.size > 3
        # erfc(5.5) is below 1e-13; the mirror frequency brings e^(-N w0^2), 4e-52 at N = 3.
        np.testing.assert_allclose(modulus, 2.5, rtol=1e-11)

    def test_is_the_papers_over_half_the_gain(self) -> None:
        # Damping on, the row's gain is the law; amplitude norm is that at a pole of jw.
        scalogram = [
            cwt(record(white(1, 500)), omega=[10.0, 70.0], bandwidth=7.0, normalization=n, full_rate=True).coefficients
            for n in ("paper", "amplitude")
        ]
        for row, omega in enumerate((10.0, 70.0)):
            half = Morlet(center=TWO_PI, bandwidth=7.0).gain(1j * omega, TWO_PI / omega) / 2
            assert_close(scalogram[1][:, row] * half, scalogram[0][:, row], rtol=1e-12)


class TestCone:
    @pytest.mark.parametrize("cones", [0.5, 1.0, 2.0])
    @pytest.mark.parametrize("bandwidth", [4.0, 22.0])
    def test_an_edge_takes_half_erfc_of_the_distance(self, cones: float, bandwidth: float) -> None:
        step, omega = 1e-3, 20.0
        tone = record(np.cos(omega * step * np.arange(20000)), step=step)
        scalogram = cwt(tone, omega=[omega], bandwidth=bandwidth, normalization="amplitude", full_rate=True)
        reach = cones * float(scalogram.cone[0])
        modulus = np.abs(scalogram.rows[0][0])
        for end in (reach, 20.0 - reach):
            at = float(np.interp(end, scalogram.timepts(0), modulus))
            # The sum counts whole samples, so the edge lies within half a step; the mirror frequency adds
            # less than e^(-u^2) / (2 w0 sqrt(pi N)).
            slack = step / float(scalogram.cone[0]) + np.exp(-(cones**2)) / (2 * TWO_PI * np.sqrt(np.pi * bandwidth))
            assert at == pytest.approx(1 - erfc(cones) / 2, abs=slack)

    def test_inside_is_away_from_both_ends_of_any_record(self) -> None:
        scalogram = cwt(record(white(1, 1000), start=-4.0), omega=[30.0], bandwidth=9.0, full_rate=True)
        cone = TWO_PI / 30.0 * 3.0
        assert float(scalogram.cone[0]) == pytest.approx(cone)
        time = scalogram.timepts(0)[scalogram.inside(0, cones=2)]
        assert time[0] == pytest.approx(-4 + 2 * cone, abs=0.01)
        assert time[-1] == pytest.approx(6 - 2 * cone, abs=0.01)


class TestAgainstPyWavelets:
    @pytest.mark.parametrize("bandwidth", [1.5, 3.0])
    @pytest.mark.parametrize("omega", [8.0, 20.0, 60.0])
    def test_equal_in_the_interior(self, bandwidth: float, omega: float) -> None:
        """Ours is sqrt(h) sqrt(pi N) times theirs.

        Their psi is exp(2 pi j C t) exp(-t^2 / B) / sqrt(pi B), and their sum runs over samples with the scale
        a = s / h in samples: a^-1/2 sum x psi*(n / a). Ours is (a h)^-1/2 h sum x psi*. They take the mean of psi over
        a step of a staircase: that costs (w h)^2 / 24 in modulus and up to half a step in time, w h / 2 in phase.
        """
        step, samples = 0.002, 6000
        t = step * np.arange(samples)
        values = np.exp(-0.2 * t) * np.cos(omega * t) + 0.3 * np.cos(1.3 * omega * t + 1)
        ours = cwt(record(values, step=step), omega=[omega], bandwidth=bandwidth, full_rate=True)
        name = f"cmor{bandwidth}-1.0"
        theirs, _ = pywt.cwt(values, [TWO_PI / omega / step], name, method="fft", precision=16)
        inside = ours.inside(0, cones=4)
        ratio = ours.rows[0][0, inside] / (np.sqrt(step * np.pi * bandwidth) * theirs[0, inside])
        # Where the tones beat, the modulus changes at up to twice 0.3 w of itself, and the shift in time shows in it.
        # Besides: a staircase of 2^16 steps over 16, and the cut at +-8, e^(-64 / 3) = 5e-10.
        shift = omega * step / 2
        np.testing.assert_allclose(np.abs(ratio), 1.0, rtol=0, atol=0.6 * shift + (2 * shift) ** 2)
        assert np.max(np.abs(np.angle(ratio))) < 1.3 * shift + 1e-4

    def test_of_a_single_tone_to_second_order(self) -> None:
        step, omega = 0.002, 20.0
        values = np.cos(omega * step * np.arange(6000))
        ours = cwt(record(values, step=step), omega=[omega], bandwidth=2.0, full_rate=True)
        theirs, _ = pywt.cwt(values, [TWO_PI / omega / step], "cmor2.0-1.0", method="fft", precision=16)
        inside = ours.inside(0, cones=5)
        ratio = np.abs(ours.rows[0][0, inside] / (np.sqrt(step * np.pi * 2.0) * theirs[0, inside]))
        # sinc(w h / 2) = 1 - (w h)^2 / 24, here 6.7e-5, and nothing else.
        np.testing.assert_allclose(ratio, 1.0, rtol=0, atol=1.5 * (omega * step) ** 2 / 24)


class TestWaveletEntropy:
    def direct(self, values: NDArray[np.float64], omega: NDArray[np.float64], bandwidth: float) -> float:
        full = cwt(record(values), omega=omega, bandwidth=bandwidth, full_rate=True)
        energy = np.abs(full.coefficients) ** 2
        share = energy[energy > 0] / np.sum(energy)
        return float(-np.sum(share * np.log(share)))

    # What the docstring promises: at N = 400 the longest envelope lasts 10.5 s.
    @pytest.mark.parametrize(("bandwidth", "atol"), [(1.0, 2e-3), (7.0, 2e-3), (50.0, 2e-3), (400.0, 5e-3)])
    @pytest.mark.parametrize("samples", [500, 2001])
    def test_is_that_of_the_full_rate_transform(self, bandwidth: float, atol: float, samples: int) -> None:
        t, omega = 0.01 * np.arange(samples), np.geomspace(12, 300, 50)
        decay = np.atleast_2d(np.exp(-0.5 * t) * np.cos(40 * t))
        for values in (decay, decay + 0.01 * white(2, samples), white(1, samples)):
            found = best_bandwidth(record(values), omega=omega, candidates=[bandwidth]).entropy[0]
            assert found == pytest.approx(self.direct(values, omega, bandwidth), abs=atol)

    def test_of_a_click_is_that_of_a_gaussian(self) -> None:
        # |CWT|^2 of a click is exp(-2 t^2 / (N s^2)): a normal law of variance N s^2 / 4, on a grid of the step.
        click = np.zeros(4001)
        click[2000] = 1.0
        omega, bandwidth = 30.0, 16.0
        variance = bandwidth * (TWO_PI / omega) ** 2 / 4
        found = best_bandwidth(record(click), omega=[omega], candidates=[bandwidth]).entropy[0]
        assert found == pytest.approx(0.5 * np.log(2 * np.pi * math.e * variance) - np.log(0.01), abs=1e-3)

    def test_of_one_coefficient_is_zero(self) -> None:
        # A wavelet far shorter than the step sees the click at one sample only.
        click = np.zeros(200)
        click[77] = 1.0
        found = best_bandwidth(record(click), omega=[300.0], candidates=[1e-3]).entropy[0]
        assert found == pytest.approx(0.0, abs=1e-9)

    def test_of_equal_coefficients_is_the_logarithm_of_their_number(self) -> None:
        # A wavelet far shorter than the step makes |CWT| = |x|: uniform for alternating signs.
        values = np.where(np.arange(500) % 3 == 0, 1.0, -1.0)
        found = best_bandwidth(record(np.stack([values, -values])), omega=[300.0], candidates=[1e-3]).entropy[0]
        assert found == pytest.approx(np.log(1000), abs=1e-9)

    def test_never_exceeds_the_logarithm_of_the_number_of_coefficients(self) -> None:
        search = best_bandwidth(record(white(2, 700)), omega=np.geomspace(20, 300, 30), candidates=[1, 10, 100])
        assert np.all(search.entropy > 0)
        assert np.all(search.entropy <= np.log(2 * 30 * 700))

    def test_twins_add_the_logarithm_of_two(self) -> None:
        values, omega = white(1, 700), np.geomspace(20, 300, 30)
        one, two = (
            best_bandwidth(record(v), omega=omega, candidates=[2, 30]).entropy
            for v in (values, np.repeat(values, 2, 0))
        )
        np.testing.assert_allclose(two - one, np.log(2), rtol=0, atol=1e-9)

    @pytest.mark.parametrize("factor", [1e-9, 1e7])
    def test_does_not_depend_on_the_amplitude(self, factor: float) -> None:
        values, omega = white(1, 700), np.geomspace(20, 300, 30)
        one, other = (best_bandwidth(record(v), omega=omega, candidates=[2, 30]) for v in (values, factor * values))
        np.testing.assert_allclose(other.entropy, one.entropy, rtol=0, atol=1e-9)

    def test_best_is_the_least_and_ends_are_told(self) -> None:
        t = 0.02 * np.arange(500)
        decay = record(np.exp(-0.3 * t) * np.cos(20 * t), step=0.02)
        search = best_bandwidth(decay, omega=np.geomspace(10, 40, 60), candidates=[1, 8, 64, 512])
        assert search.best == search.candidates[np.argmin(search.entropy)]
        assert not search.at_end
        assert search.best == 64.0
        # The entropy falls up to 64 and rises beyond: any candidates on one side of it have the best at an end.
        for candidates in ([1, 2, 4], [64, 128, 512], [512, 128, 64], [4]):
            assert best_bandwidth(decay, omega=np.geomspace(10, 40, 60), candidates=candidates).at_end

    def test_no_candidates_or_no_signal_are_refused(self) -> None:
        with pytest.raises(InputError, match="candidates is empty"):
            best_bandwidth(record(white(1, 100)), omega=[30.0], candidates=[])
        with pytest.raises(InputError, match="zero throughout"):
            best_bandwidth(record(np.zeros(100)), omega=[30.0])


class TestCost:
    OMEGA = np.geomspace(10, 300, 200)

    def peak(self, samples: int) -> tuple[int, Scalogram]:
        response = record(white(1, samples))
        tracemalloc.start()
        try:
            scalogram = cwt(response, omega=self.OMEGA, bandwidth=22.0)
            return tracemalloc.get_traced_memory()[1], scalogram
        finally:
            tracemalloc.stop()

    def test_memory_grows_with_the_record(self) -> None:
        self.peak(1000)  # what is imported on the first call is no part of it
        short, _ = self.peak(10_000)
        long, scalogram = self.peak(100_000)
        # Lengths fit for FFTs lie up to a tenth above the least.
        assert long <= 11 * short
        stored = sum(row.size for row in scalogram.rows)
        # The widths of the rows, 4 sqrt(30 / N) / s, take 0.094 of the whole on average; halving up to twice that.
        assert stored < 0.19 * 200 * 100_000

    def test_storage_follows_the_width_of_the_rows(self) -> None:
        # A row spans 4 sqrt(30 / N) / s rad/s of the 2 pi / h of the record; halving stops within a factor of two.
        scalogram = cwt(record(white(1, 50_000)), omega=self.OMEGA, bandwidth=100.0)
        for row, scale in zip(scalogram.rows, scalogram.scale, strict=True):
            share = 4 * np.sqrt(-np.log(1e-13) / 100.0) / scale * 0.01 / TWO_PI
            assert row.shape[1] <= 2.1 * share * 50_000 + 2


class TestRefusals:
    @pytest.mark.parametrize("omega", [0.0, -3.0, 314.16, 1e6, np.nan])
    def test_frequencies_out_of_range(self, omega: float) -> None:
        with pytest.raises(InputError, match="Nyquist frequency 314.159"):
            cwt(record(white(1, 100)), omega=[20.0, omega], bandwidth=2.0)

    def test_no_frequencies(self) -> None:
        with pytest.raises(InputError, match="at least one"):
            cwt(record(white(1, 100)), omega=[], bandwidth=2.0)

    def test_a_wavelet_far_longer_than_the_record(self) -> None:
        with pytest.raises(InputError, match="10 times"):
            cwt(record(white(1, 100)), omega=[0.1], bandwidth=22.0)

    def test_signal_is_not_kept_open_to_change(self) -> None:
        response = record(white(1, 100))
        scalogram = cwt(response, omega=[20.0], bandwidth=2.0)
        before = as_signal(response).values.copy()
        response.y[...] = 0.0
        np.testing.assert_array_equal(scalogram.signal.values, before)
        with pytest.raises(ValueError, match="read-only"):
            scalogram.rows[0][0, 0] = 0
