"""Structures of records that are sampled far faster than they move are found in means."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from suspid import identify
from suspid.identification import ForceKind
from suspid.identification.noise import KnownNoise, WhiteNoise
from suspid.identification.nonlinear import rates
from suspid.identification.nonlinear.feedback import Record
from suspid.identification.nonlinear.forces import forces_of
from suspid.identification.nonlinear.motion import Structures
from suspid.identification.nonlinear.rates import _factor, at_full_rate
from suspid.identification.nonlinear.structure import StructureFit, evaluated
from suspid.records import as_response
from suspid.signals import block_means
from suspid.units import RealArray

FACTOR = 20
# Per mean: 30 and 11 in a cycle.
THETA = np.array([-0.004 + 0.21j, -0.012 + 0.57j])


def record(values: RealArray, theta: np.ndarray = THETA, sizes: tuple[float, ...] = (1.0, 0.3)) -> Record:
    amplitudes = np.array(sizes)[:, None] * np.array([[1.0, 0.6], [-0.7, 1.0]])[: len(sizes)]
    return Record(
        values=values,
        noise=WhiteNoise(least=np.full(len(values), 1e-12)),
        theta=theta[: len(sizes)],
        amplitudes=np.asarray(amplitudes, complex),
        nuisances=np.zeros(1),
    )


def in_means(kind: ForceKind, order: int, count: int = 200) -> StructureFit:
    """Return two modes under forces of a kind, per mean, that shift or damp them by a tenth."""
    shapes = np.array([[1.0, 0.6], [-0.2, 0.3]]) * THETA[:, None] ** -order
    follows = THETA if kind in (ForceKind.FRICTION, ForceKind.DRAG) else np.ones(2)
    forces = forces_of(kind, 2, most=2)
    scales = np.abs(shapes * follows[:, None]).sum(axis=0)
    gains = np.array([[0.02j, -0.01j], [0.01j, 0.02j]])
    structures = Structures(theta=THETA[None], shapes=shapes[None], gains=gains[None], forces=forces, scales=scales)
    return evaluated(record(np.zeros((2, count))), structures, order)


class TestFullRate:
    @pytest.mark.parametrize("order", [0, 1, 2])
    @pytest.mark.parametrize("kind", [ForceKind.FRICTION, ForceKind.CUBIC, ForceKind.DRAG])
    def test_means_of_the_motion_at_every_sample_are_the_motion_in_means(self, kind: ForceKind, order: int) -> None:
        short = in_means(kind, order)
        whole = at_full_rate(short, record(np.zeros((2, 200 * FACTOR))), FACTOR)
        # Without a record, the residual is the motion.
        means, size = block_means(whole.residual, FACTOR), np.max(np.abs(short.residual))
        off = means - means.mean(axis=1, keepdims=True) - short.residual + short.residual.mean(axis=1, keepdims=True)
        # A mass stops within a mean, whose friction then has its own mean.
        near = 0.05 if kind is ForceKind.FRICTION else 0.005
        assert np.max(np.abs(off)) < 3 * near * size
        assert np.sqrt(np.mean(off**2)) < near * np.sqrt(np.mean(short.residual**2))

    def test_a_linear_motion_is_exact(self) -> None:
        short = in_means(ForceKind.CUBIC, 1)
        free = evaluated(short.record, replace(short.structures, gains=0 * short.structures.gains), 1)
        whole = at_full_rate(free, replace(record(np.zeros((2, 200 * FACTOR))), nuisances=np.zeros(0)), FACTOR)
        powers = np.exp(np.outer(whole.theta, np.arange(200 * FACTOR)))
        means = block_means((whole.amplitudes.T @ powers).real, FACTOR)
        exact = (free.amplitudes.T @ np.exp(np.outer(THETA, np.arange(200)))).real
        np.testing.assert_allclose(means, exact, atol=1e-12 * np.max(np.abs(exact)))


class TestFactor:
    values = np.zeros((2, 100_000))

    def test_sixty_are_left_of_the_strongest_and_ten_of_the_fastest(self) -> None:
        alone = np.array([-1e-4 + 2j * np.pi / 905])
        assert _factor(record(self.values, alone, (1.0,))) == 15
        both = np.array([-1e-4 + 2j * np.pi / 905, -1e-4 + 2j * np.pi / 121])
        assert _factor(record(self.values, both)) == 12

    def test_a_weak_line_does_not_count(self) -> None:
        both = np.array([-1e-4 + 2j * np.pi / 905, -1e-4 + 2j * np.pi / 12])
        assert _factor(record(self.values, both, (1.0, 0.005))) == 1
        assert _factor(record(self.values, both, (1.0, 0.0005))) == 15

    def test_few_samples_and_what_never_turns_are_left_as_they_are(self) -> None:
        alone = np.array([-1e-4 + 2j * np.pi / 905])
        assert _factor(record(self.values[:, :2999], alone, (1.0,))) == 9
        assert _factor(record(self.values, np.array([-1e-4 + 0j]), (1.0,))) == 1


def test_noise_of_means() -> None:
    """Of n samples the variance is an n-th."""
    samples = np.random.default_rng(1).standard_normal((2, 40_000))
    noise = KnownNoise(least=np.var(samples, axis=1)).of_means(8)
    assert isinstance(noise, KnownNoise)
    np.testing.assert_allclose(np.var(block_means(samples, 8), axis=1), noise.least, rtol=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_many_samples_in_a_cycle_change_nothing(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two masses on springs that stiffen by a tenth, 700 samples in a cycle: the modes are those of all samples."""
    rng, t = np.random.default_rng(seed), np.arange(6000) / 2000

    def slope(_: float, s: RealArray) -> list[float]:
        below, above = s[0], s[1] - s[0]
        first = -400 * below * (1 + 250 * below**2) - 0.4 * s[2]
        second = -300 * above * (1 + 250 * above**2) - 0.3 * (s[3] - s[2])
        return [s[2], s[3], first - second, second / 0.8]

    start = [0.02, 0.03 * rng.uniform(0.6, 1.2), 0.0, 0.0]
    motion = solve_ivp(slope, (0, t[-1]), start, t_eval=t, rtol=1e-9, atol=1e-12).y[:2]
    response = as_response(t, motion + 2e-5 * rng.standard_normal(motion.shape), ["lower", "upper"])
    found = identify(response)
    assert [force.kind for force in found.forces] == [ForceKind.CUBIC] * len(found.forces)
    monkeypatch.setattr(rates, "_factor", lambda _record: 1)
    # Another record, so that nothing is taken from a cache.
    every = identify(as_response(t, 1.001 * response.y, ["lower", "upper"]))
    assert len(found.modes) == len(every.modes) == 2
    np.testing.assert_allclose(found.modes.wn, every.modes.wn, rtol=1e-4)
    np.testing.assert_allclose(found.modes.zeta, every.modes.zeta, rtol=1e-2)
