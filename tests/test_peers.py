"""The reports beside the peers: their signals, their scores, and that they run."""

from __future__ import annotations

import re

import numpy as np
import pytest

from suspid import eigenmodes
from suspid.records import as_response
from suspid.signals import as_signal
from suspid.units import RealArray
from suspid.wavelets import Morlet
from suspid.wavelets.transform import transform
from validation import cars, speed
from validation.peer_methods import METHODS, Method, slowed
from validation.peer_skeletons import RATE, Estimates
from validation.peers import bound, clean, hints, missing_module, nearest, record, report, score

PEERS = [method for method in METHODS if method.distribution != "suspid"]
# Keeps only modes that its indicators trust.
CAUTIOUS = {"pyyeti ERA, automatic"}


def truth() -> Estimates:
    modes = eigenmodes(cars.PAPER)
    return [(float(w), float(z)) for w, z in zip(modes.wn, modes.zeta, strict=True)]


class TestSignals:
    def test_seat_starts_at_rest_and_is_pushed_by_nothing_of_its_own(self) -> None:
        # The impulse is on the tire, two springs away: displacement, velocity and acceleration of the seat start at 0.
        samples = clean()
        assert len(samples) == 5000
        assert np.max(np.abs(samples[:3])) < 1e-4 * np.max(np.abs(samples))

    @pytest.mark.parametrize("snr_db", [20.0, 2.0])
    def test_noise_has_the_stated_power(self, snr_db: float) -> None:
        noise = record(snr_db, 3) - clean()
        # 5000 samples give their own power to 2 %, that is 0.09 dB; four of these.
        assert 10 * np.log10(np.mean(clean() ** 2) / np.mean(noise**2)) == pytest.approx(snr_db, abs=0.35)

    def test_bound_is_as_published(self) -> None:
        # Published with the table, to the digits given: mean absolute errors of normal errors.
        for snr_db, wn, zeta in ((20.0, 0.028, 0.038), (2.0, 0.226, 0.303)):
            least = bound(snr_db)
            assert np.sqrt(2 / np.pi) * np.mean(least.wn_std) == pytest.approx(wn, abs=6e-4)
            assert 100 * np.sqrt(2 / np.pi) * np.mean(least.zeta_std) == pytest.approx(zeta, abs=6e-4)

    def test_hints_are_within_five_percent_and_differ(self) -> None:
        off = np.array([hints(seed) / eigenmodes(cars.PAPER).wn - 1 for seed in range(50)])
        assert np.max(np.abs(off)) <= 0.05
        assert np.min(np.std(off, axis=0)) > 0.01

    def test_slowed_record_keeps_what_is_far_below_the_cut(self) -> None:
        time = np.arange(5000) / RATE
        tone = np.cos(2 * np.pi * 3 * time)
        inside = slice(50, -50)
        # The filter's ripple is 0.05 dB forth and 0.05 dB back: 1.2 %.
        np.testing.assert_allclose(slowed(tone)[inside], tone[::10][inside], atol=0.012)


class TestScore:
    def test_truth_has_no_error(self) -> None:
        np.testing.assert_array_equal(nearest(truth()), np.zeros((3, 2)))

    def test_modes_further_than_five_percent_are_not_found(self) -> None:
        (w1, z1), (w2, z2), _ = truth()
        errors = nearest([(1.049 * w1, z1), (1.051 * w2, z2), (np.nan, 0.1)])
        assert np.isfinite(errors[:, 0]).tolist() == [True, False, False]
        assert errors[0] == pytest.approx([0.049 * w1, 0.0])

    def test_the_nearer_of_two_counts(self) -> None:
        (w1, z1), *_ = truth()
        assert nearest([(1.03 * w1, z1), (0.99 * w1, 0.5)])[0] == pytest.approx([-0.01 * w1, 0.5 - z1])

    def test_exception_is_a_failure_with_a_name(self) -> None:
        def broken(samples: RealArray, near: RealArray) -> Estimates:
            raise ZeroDivisionError(f"no luck with {len(samples)} samples and {len(near)} hints")

        method = Method(name="broken", distribution="x", module="numpy", given="-", settings="", run=broken)
        result = score(method, 20.0, 2)
        assert (result.failed, result.returned, result.raised) == (
            6,
            0,
            "ZeroDivisionError: no luck with 5000 samples and 3 hints",
        )


@pytest.mark.parametrize("method", PEERS, ids=[method.name for method in PEERS])
class TestPeers:
    def test_finds_the_modes_without_noise(self, method: Method) -> None:
        if problem := missing_module(method.module):
            pytest.skip(problem)
        result = score(method, None, 1)
        assert not result.raised
        if method.name in CAUTIOUS:
            assert result.failed < 3
            return
        assert result.failed == 0
        # The peers are used as they deserve if none of them is further off than its wavelets or filters explain.
        assert np.max(np.abs(result.wn)) < 0.2
        assert np.max(np.abs(result.zeta)) < 0.002


class TestReport:
    def test_runs_with_suspid_alone_and_says_who_is_missing(self) -> None:
        absent = Method(
            name="absent",
            distribution="no-such-thing",
            module="no_such_thing",
            given="N",
            settings="",
            run=METHODS[0].run,
        )
        text = report(seeds=1, methods=(METHODS[0], absent), rounds=1)
        assert "## Time" in text
        rows = [line for line in text.splitlines() if line.startswith("| absent")]
        assert len(rows) == 1
        assert "not installed" in rows[0]
        (own,) = [line for line in text.split("## The same")[0].splitlines() if line.startswith("| suspid")]
        cells = [cell.strip() for cell in own.strip("|").split("|")]
        assert cells[2:5:2] == ["0/3", "0/3"]

    def test_times_stand_apart_from_what_is_reproducible(self) -> None:
        texts = [report(seeds=1, methods=METHODS[:1], rounds=1).split("## Time")[0] for _ in range(2)]
        assert texts[0] == texts[1]
        assert not re.search(r"\bms\b", texts[0])


class TestSpeed:
    def test_direct_sum_of_a_tone_is_the_spectrum_of_the_wavelet(self) -> None:
        # Far from the ends exp(j w t) becomes exp(j w tau) sqrt(pi N) exp(-N (s w - w0)^2 / 4), Eq. (12) with 1 / s.
        omega, row, timepts = 40.0, 41.0, np.arange(20_000) / RATE
        wavelet = Morlet(center=speed.CENTER, bandwidth=speed.BANDWIDTH)
        signal = as_signal(as_response(timepts, np.cos(omega * timepts)[None], ("seat",)))
        expected = np.exp(1j * omega * timepts[9000]) / 2 * wavelet.spectrum(wavelet.center / row * omega)
        # The tone's negative half is exp(-N w0^2) of it, nothing.
        assert speed.direct_sum(signal, row, 9000) == pytest.approx(complex(expected), abs=1e-10)

    def test_direct_sum_is_the_transform(self) -> None:
        values = np.random.default_rng(5).standard_normal((1, 4000))
        signal = as_signal(as_response(np.arange(4000) / RATE, values, ("seat",)))
        wavelet = Morlet(center=speed.CENTER, bandwidth=speed.BANDWIDTH)
        scalogram = transform(signal, omega=np.array([60.0]), wavelet=wavelet)
        i = scalogram.rows[0].shape[1] // 2
        got = scalogram.rows[0][0, i] / np.sqrt(wavelet.center / 60.0)
        # The wavelet counts as zero below 1e-13 of its peak.
        assert speed.direct_sum(signal, 60.0, i * scalogram.strides[0]) == pytest.approx(complex(got), rel=1e-10)

    def test_runs_on_little(self) -> None:
        text = speed.report(rounds=1, lengths=(1000,), samples=2000, rows=12, everyday=str)
        for title in ("## Accuracy of the transforms", "## Times", "### Against the length of the record"):
            assert title in text
        errors = [float(e) for e in re.findall(r"\| suspid, own rates, to 1e-13 .*?\| (\de[-+]\d+)", text)]
        assert len(errors) == 1
        assert errors[0] < 1e-10
