"""Which modes of a structure stand, what it explains, and what its forces are worth."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from suspid.identification.likelihood import bic_penalty
from suspid.identification.noise import WhiteNoise
from suspid.identification.nonlinear.descent import fitted
from suspid.identification.nonlinear.feedback import Record
from suspid.identification.nonlinear.forces import ForceKind, forces_of
from suspid.identification.nonlinear.standing import explains, misses, stands, worths_of
from suspid.identification.nonlinear.structure import StructureFit, gains_of, structure_of

Real = NDArray[np.float64]
SHAPES = np.array([[1.0, 0.8], [1.0, -0.6]])


def structure(theta: Sequence[complex], worth: Sequence[float], *, count: int = 400, hum: float = 0.0) -> StructureFit:
    """Return modes on which no force acts, as they are in a record, each of an energy in BIC penalties.

    The noise has a standard deviation of 1; with hum it is louder near the first mode.
    """
    poles, rng = np.array(theta), np.random.default_rng(1)
    powers, shapes = np.exp(np.outer(poles, np.arange(count))), SHAPES[: len(poles)]
    energy = np.sum(np.abs(powers) ** 2, axis=1) / 2 * np.sum(shapes**2, axis=1)
    amplitudes = shapes * np.sqrt(np.array(worth) * bic_penalty(2, 2 * count) / energy)[:, None] + 0j
    noise, more = rng.standard_normal((2, 2, count))
    near = np.abs(2 * np.pi * np.fft.rfftfreq(count) - poles[0].imag) < 0.25
    noise += np.fft.irfft(hum * near * np.fft.rfft(more), count)
    noise /= np.std(noise, axis=1, keepdims=True)
    record = Record(
        values=(amplitudes.T @ powers).real + noise,
        noise=WhiteNoise(least=np.full(2, 1e-20)),
        theta=poles,
        amplitudes=amplitudes,
        nuisances=np.zeros(1),
    )
    return structure_of(record, poles, amplitudes, forces_of(ForceKind.BENT_DAMPER, 2, most=2), 0)


class TestStands:
    def test_a_mode_whose_energy_is_above_its_penalty_where_it_leaves_white_noise(self) -> None:
        assert stands(structure([-0.02 + 0.6j, -0.02 + 1.5j], [3, 28])).tolist() == [True, True]
        assert stands(structure([-0.02 + 0.6j, -0.02 + 1.5j], [0.4, 28])).tolist() == [False, True]

    def test_not_what_goes_on(self) -> None:
        assert stands(structure([-0.02 + 0.6j, 1.5j], [500, 500])).tolist() == [True, False]

    def test_not_what_makes_less_than_a_cycle(self) -> None:
        cycle = 2 * np.pi / 400
        assert not stands(structure([-3 / 400 + 0.9j * cycle], [5000]))[0]
        assert stands(structure([-3 / 400 + 1.1j * cycle], [5000]))[0]

    def test_not_what_turns_faster_than_the_samples(self) -> None:
        assert not stands(structure([-0.02 + 3.3j], [500]))[0]

    def test_not_what_is_known_to_a_tenth_of_its_size_or_worse(self) -> None:
        """The deviation falls as the root of the energy: of a mode that falls by half a neper a cycle."""
        known = [stands(structure([-0.1 + 0.14j], [worth], count=60))[0] for worth in (25, 100)]
        assert known == [False, True]

    def test_beside_excess_noise_only_what_is_worth_it_there(self) -> None:
        """The noise near the mode has three times the power of white noise: 60 penalties (`WORTHWHILE`) are needed."""
        assert [stands(structure([-0.02 + 0.6j], [worth], hum=3.0))[0] for worth in (30, 200)] == [False, True]


class TestExplains:
    def test_a_record_of_white_noise_beside_its_modes_if_the_bic_is_below_the_highest(self) -> None:
        fit = structure([-0.02 + 0.6j], [200])
        assert not misses(fit)
        assert explains(fit, fit.bic + 1)
        assert not explains(fit, fit.bic - 1)

    def test_not_where_the_noise_has_three_times_its_power_near_a_mode(self) -> None:
        fit = structure([-0.02 + 0.6j], [200], hum=3.0)
        assert misses(fit)
        assert not explains(fit, fit.bic + 1)


def test_the_worth_of_a_force_is_the_fall_of_the_loss_that_it_brings() -> None:
    """Wald's statistic beside the likelihood ratio: they agree for weak forces."""
    plain = structure([-0.03 + 0.35j, -0.03 + 0.6j], [3e5, 3e5], count=120)
    of = plain.structures
    # Forces that slow each mass by 0.1 % of its acceleration where its speed is largest.
    slowed = np.array([0.001, 0.001]) * np.sum(np.abs(of.shapes[0] * of.theta[0][:, None] ** 2), axis=0)
    bent = plain.with_structures(replace(of, gains=gains_of(of.theta[0], of.shapes[0], np.diag(slowed))[None]))
    # What the forces move, and the noise.
    record = replace(plain.record, values=plain.record.values + plain.residual - bent.residual)
    fit = fitted(bent.with_record(record))
    for j in range(2):
        fewer = fitted(
            fit.with_structures(
                replace(
                    fit.structures,
                    gains=np.delete(fit.structures.gains, j, axis=2),
                    forces=tuple(np.delete(np.array(fit.forces, object), j)),
                    scales=np.delete(fit.structures.scales, j),
                )
            )
        )
        assert worths_of(fit)[j] == pytest.approx(fewer.loss - fit.loss, rel=0.1)


def test_a_motion_that_runs_away_has_no_covariance(capfd: pytest.CaptureFixture[str]) -> None:
    """LAPACK wrote a line on standard output before."""
    fit = structure([-0.01 + 0.3j], [1.0])
    away = replace(fit, nearby=replace(fit.nearby, apart=np.full_like(fit.nearby.apart, np.inf)))
    with pytest.raises(np.linalg.LinAlgError, match="runs away"):
        worths_of(away)
    assert capfd.readouterr().out == ""
