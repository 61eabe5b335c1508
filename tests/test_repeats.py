"""Repeats identified jointly: at the bound of all together, in agreement, or said to disagree."""

from itertools import pairwise

import control
import numpy as np
import pytest
from bounds import modal_bound
from numpy.typing import NDArray

from suspid import IdentificationError, InputError, RecordError, Suspension, eigenmodes, free_decay, identify
from suspid.identification import covariance
from suspid.identification.identify_repeats import identify_repeats
from suspid.records import as_response
from validation import cars

Real = NDArray[np.float64]
MASSES = ("seat", "chassis", "tire")
FS = 250.0
LENGTHS = (1000, 1500, 800)
STATES = ({"v_tire": 1.0}, {"v_tire": -0.5, "v_chassis": 0.3}, {"v_tire": 0.8, "z_seat": 0.01})


def spans(lengths: tuple[int, ...] = LENGTHS) -> list[tuple[float, float]]:
    edges = np.cumsum((0, *lengths)) / FS
    return [(float(a), float(b) - 1 / FS) for a, b in pairwise(edges)]


def decays(car: Suspension = cars.PAPER, lengths: tuple[int, ...] = LENGTHS) -> list[Real]:
    return [
        np.asarray(free_decay(car, np.arange(n) / FS, initial_state=x).y) for n, x in zip(lengths, STATES, strict=False)
    ]


def record(parts: list[Real], *, std: float, seed: int) -> control.TimeResponseData:
    values = np.hstack(parts)
    values = values + std * np.random.default_rng(seed).standard_normal(values.shape)
    return as_response(np.arange(values.shape[1]) / FS, values, MASSES)


class TestExact:
    """Without noise the joint modes are those of the model, shapes included."""

    def test_modes_and_shapes(self) -> None:
        found = identify_repeats(record(decays(), std=0.0, seed=0), spans()).modes
        truth = eigenmodes(cars.PAPER)
        # Rounding of the records, magnified by the closeness of the poles.
        np.testing.assert_allclose(found.poles, truth.poles, rtol=1e-6)
        assert found.shapes is not None
        assert truth.shapes is not None
        np.testing.assert_allclose(found.shapes, truth.shapes, atol=1e-6)


class TestBound:
    """The joint information is the sum of the informations of the repeats, whatever their lengths."""

    def test_standard_deviations_are_the_joint_bound(self) -> None:
        """With equal lengths the repeats are further channels of one record, which the bound knows."""
        lengths, std, truth = (1000, 1000, 1000), 2e-4, eigenmodes(cars.PAPER)
        clean = decays(lengths=lengths)
        wn_std, zeta_std = modal_bound(truth.wn, truth.zeta, np.vstack(clean), np.arange(1000) / FS, np.full(9, std))
        found = identify_repeats(record(clean, std=std, seed=1), spans(lengths)).modes
        assert found.wn_std is not None
        assert found.zeta_std is not None
        # The level of the noise is estimated from 1000 samples in each channel, and the offset is free too.
        np.testing.assert_allclose(found.wn_std, wn_std, rtol=0.1)
        np.testing.assert_allclose(found.zeta_std, zeta_std, rtol=0.1)

    @pytest.mark.slow
    def test_errors_are_those_of_the_bound(self) -> None:
        std, truth = 3e-4, eigenmodes(cars.PAPER)
        clean, scores = decays(), []
        for seed in range(12):
            found = identify_repeats(record(clean, std=std, seed=seed), spans()).modes
            assert len(found) == 3
            assert found.wn_std is not None
            assert found.zeta_std is not None
            scores.append(np.r_[(found.wn - truth.wn) / found.wn_std, (found.zeta - truth.zeta) / found.zeta_std])
        # 72 squares of about unit variance: their mean lies within 0.6 and 1.5 but for one time in a thousand.
        assert 0.6 < float(np.mean(np.square(scores))) < 1.5

    def test_few_samples_are_counted_less_their_parameters(self) -> None:
        """The bound by differences, with the noise that is estimated: power of the residual by degree of freedom."""
        t, truth = np.arange(40) / 40, np.array([-3.0, 35.0, 0.5, 0.1, 0.6, 0.05, 0.0, 0.0])

        def motion(x: Real) -> Real:
            first = 2 * complex(*x[2:4]) * np.exp(complex(*x[:2]) * t)
            return np.stack([first.real + x[6], (first * complex(*x[4:6])).real + x[7]])

        noise = 1e-3 * np.random.default_rng(4).standard_normal((2, t.size))
        found = identify_repeats(as_response(t, motion(truth) + noise, ("seat", "tire")), [(0.0, 0.975)])
        assert len(found.modes) == 1
        assert found.modes.covariance is not None
        slopes = [(motion(truth + step) - motion(truth - step)) / 2e-6 for step in 1e-6 * np.eye(8)]
        J = np.stack([(slope / found.noise_std[0][:, None]).ravel() for slope in slopes], axis=1)
        std = np.sqrt(np.diag(np.linalg.inv(J.T @ J)))
        # The parameters take a tenth of the samples; without their count, 5 % would be missing.
        size = np.sqrt(np.diag(found.modes.covariance) / found.loudness[0])
        np.testing.assert_allclose(size[[0, 1, 4, 5]], std[[0, 1, 4, 5]], rtol=0.02)

    @pytest.mark.slow
    def test_shapes_keep_their_intervals(self) -> None:
        truth, clean, scores = eigenmodes(cars.PAPER), decays(), []
        assert truth.shapes is not None
        for seed in range(12):
            found = identify_repeats(record(clean, std=3e-4, seed=seed), spans()).modes
            assert found.shapes is not None
            assert found.covariance is not None
            strongest = np.argmax(np.abs(found.shapes), axis=0)
            apart = (found.shapes - truth.shapes / truth.shapes[strongest, [0, 1, 2]]).T.ravel()
            std = np.sqrt(np.diag(found.covariance)[6:])
            parts = np.stack([apart.real, apart.imag], axis=1).ravel()
            scores.append((parts[std > 0] / std[std > 0]) ** 2)
        # 144 squares, correlated in pairs.
        assert 0.6 < float(np.mean(scores)) < 1.5

    def test_shapes_of_a_pair_and_of_a_real_pole(self) -> None:
        """A real pole has real amplitudes: the variance of their imaginary part, none, took part in the weights."""
        t, scores = np.arange(400) / 50, []
        for seed in range(12):
            rng, parts = np.random.default_rng(seed), []
            for a, b in ((1.0, 0.5), (-0.7, 0.3), (0.4, 0.8)):
                swing, fall = a * np.exp(-0.3 * t) * np.cos(12 * t), b * np.exp(-1.5 * t)
                values = np.array([swing + fall, 0.5 * swing - 0.3 * fall]) + 1e-3 * rng.standard_normal((2, t.size))
                parts.append(as_response(t, values, ("seat", "tire")))
            found = identify_repeats(parts).modes
            # Noise of some seeds would let the real pole be a pair as well.
            if found.kinds != ("real", "pair"):
                continue
            assert found.shapes is not None
            assert found.covariance is not None
            np.testing.assert_allclose(found.shapes[1], [-0.3, 0.5], atol=3e-3)
            std = np.sqrt(np.diag(found.covariance))[[6, 10, 11]]
            apart = found.shapes[1] - [-0.3, 0.5]
            scores.append(np.array([apart[0].real, apart[1].real, apart[1].imag]) / std)
        # 24 squares or more of about unit variance.
        assert len(scores) >= 8
        assert 0.5 < float(np.mean(np.square(scores))) < 1.7

    def test_one_decay_alone_is_identify(self) -> None:
        noisy = record(decays()[:1], std=3e-4, seed=1)
        found, alone = identify_repeats(noisy, spans()[:1]).modes, identify(noisy).modes
        np.testing.assert_allclose(found.poles, alone.poles, rtol=1e-6)
        assert found.covariance is not None
        assert alone.covariance is not None
        size = np.sqrt(np.outer(np.diag(alone.covariance), np.diag(alone.covariance)))
        size[size == 0] = 1.0
        np.testing.assert_allclose(found.covariance / size, alone.covariance / size, atol=1e-3)

    def test_one_decay_alone_agrees_with_nothing(self) -> None:
        found = identify_repeats(record(decays()[:1], std=3e-4, seed=1), spans()[:1])
        (row,) = {line.split(None, 1)[1].strip() for line in found.details().splitlines() if line.count("–") == 3}
        assert row.split()[:3] == ["–"] * 3


class TestAgreement:
    def test_linear_repeats_agree(self) -> None:
        """The chi-square has the mean of its degrees of freedom, two for each repeat but one."""
        values = []
        for seed in range(12):
            found = identify_repeats(record(decays(), std=1e-4, seed=seed), spans())
            assert [agreement.freedom for agreement in found.consistency] == [4, 4, 4]
            values += [agreement.chi_square for agreement in found.consistency]
        # The mean of 36 chi-squares of four degrees: standard deviation sqrt(8 / 36).
        assert abs(np.mean(values) - 4) < 3.3 * np.sqrt(8 / 36)

    def test_a_damper_that_changes_is_said(self) -> None:
        stiffer = cars.PAPER.with_parameters(damping={"seat": 360.0})
        parts = [decays()[0], decays(stiffer)[1], decays()[2]]
        found = identify_repeats(record(parts, std=1e-4, seed=1), spans())
        assert max(agreement.widening for agreement in found.consistency) > 1
        assert "disagree" in str(found)
        plain = identify_repeats(record(decays(), std=1e-4, seed=1), spans()).modes
        worst = int(np.argmax([agreement.widening for agreement in found.consistency]))
        assert found.modes.zeta_std is not None
        assert plain.zeta_std is not None
        assert found.modes.zeta_std[worst] > 1.5 * plain.zeta_std[worst]


class TestRefusals:
    def test_no_decay(self) -> None:
        with pytest.raises(InputError, match="no decay given"):
            identify_repeats(record(decays(), std=1e-4, seed=1), [])

    def test_more_modes_than_there_are(self) -> None:
        with pytest.raises(IdentificationError, match="3 could be found") as caught:
            identify_repeats(record(decays(), std=1e-4, seed=1), spans(), modes=5)
        assert caught.value.found is not None

    def test_a_stretch_outside_is_named(self) -> None:
        with pytest.raises(RecordError, match="the decay 90"):
            identify_repeats(record(decays(), std=1e-4, seed=1), [(90.0, 95.0)])


class TestSeveralRecords:
    """Decays of several recordings are those of one in which they stand one after another."""

    def test_same_as_stretches_of_one(self) -> None:
        noisy = record(decays(), std=1e-4, seed=5)
        values = np.asarray(noisy.y)
        edges = np.cumsum((0, *LENGTHS))
        # Each file begins at a time of its own.
        several = [
            as_response(7.0 * k + np.arange(b - a) / FS, values[:, a:b], MASSES)
            for k, (a, b) in enumerate(pairwise(edges.tolist()))
        ]
        one, many = identify_repeats(noisy, spans()), identify_repeats(several)
        np.testing.assert_allclose(many.modes.poles, one.modes.poles, rtol=1e-12)
        assert many.modes.covariance is not None
        assert one.modes.covariance is not None
        np.testing.assert_allclose(many.modes.covariance, one.modes.covariance, rtol=1e-6)
        assert [start for start, _ in many.spans] == pytest.approx([0.0, 7.0, 14.0])

    def test_other_channels_are_no_repeat(self) -> None:
        first = record(decays()[:1], std=1e-4, seed=5)
        second = as_response(np.asarray(first.time), np.asarray(first.y), ("seat", "tire", "chassis"))
        with pytest.raises(InputError, match="record 2 has the channels seat, tire, chassis"):
            identify_repeats([first, second])

    def test_another_rate_is_no_repeat(self) -> None:
        first = record(decays()[:1], std=1e-4, seed=5)
        second = as_response(1.001 * np.asarray(first.time), np.asarray(first.y), MASSES)
        with pytest.raises(InputError, match=r"record 2 is sampled at 249.7502 Hz, record 1 at 250 Hz"):
            identify_repeats([first, second])

    def test_stretches_belong_to_one_recording(self) -> None:
        first = record(decays()[:1], std=1e-4, seed=5)
        with pytest.raises(InputError, match="stretches of one recording"):
            identify_repeats([first], [(0.0, 1.0)])
        with pytest.raises(InputError, match="no decay given"):
            identify_repeats(first)


@pytest.mark.parametrize("size", [1.0, 0.2])
def test_steps_that_lead_away_from_common_shapes_are_not_taken(size: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Decays that share no mode had shapes of 1e121: slopes that are too small make each step miss by more."""
    rng = np.random.default_rng(1)
    amplitudes = np.array([[1.0, 0.5], [0.3, 0.2]]) * np.exp(0.1 * rng.standard_normal((3, 2, 2))) + 0j
    exact = covariance._slopes
    monkeypatch.setattr(covariance, "_slopes", lambda *given: size * exact(*given))
    variances = np.diag(10.0 ** rng.uniform(-4, 0, 24))
    shapes, _ = covariance._common_shapes(amplitudes, variances)
    assert np.max(np.abs(shapes)) == pytest.approx(1.0)
    assert shapes[1] == pytest.approx([0.3, 0.4], rel=0.3)
