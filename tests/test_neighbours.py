"""Whether a fitted pair has another beside it: what it promises, and what an interval then holds."""

import numpy as np
import pytest

from suspid import identify
from suspid.identification.exponentials import blocks_of
from suspid.identification.fitting import Fit, Problem
from suspid.identification.likelihood import evaluate
from suspid.identification.neighbours import neighbours
from suspid.identification.noise import WhiteNoise
from suspid.identification.poles import Poles
from suspid.records import as_response

SAMPLES = 400


def sampled(poles: np.ndarray, amplitudes: np.ndarray, *, noise: float, seed: int) -> np.ndarray:
    """Return ``Re sum_k a_ck exp(p_k t)`` in each channel, per sample, and white noise."""
    clean = (amplitudes @ np.exp(np.outer(poles, np.arange(SAMPLES)))).real
    return np.asarray(clean + noise * np.random.default_rng(seed).standard_normal(clean.shape))


def fitted(values: np.ndarray, pairs: np.ndarray, reals: np.ndarray) -> Fit:
    problem = Problem(values=values, blocks=blocks_of(values), noise=WhiteNoise(least=np.full(len(values), 1e-22)))
    fit = problem.fitted(Poles(pairs=pairs, reals=reals, nuisances=np.zeros(1)))
    assert fit is not None
    return problem.settled(fit)


@pytest.mark.parametrize("reals", [np.zeros(0), np.array([-0.012])])
@pytest.mark.parametrize("channels", [1, 3])
def test_the_promise_is_that_of_a_fit_with_one_more_pair(channels: int, reals: np.ndarray) -> None:
    rng = np.random.default_rng(4)
    pairs = np.array([-0.03 + 0.1j, -0.05 + 0.4j])
    every = np.concatenate([pairs, reals])
    amplitudes = rng.standard_normal((channels, len(every))) + 1j * rng.standard_normal((channels, len(every)))
    values = sampled(every, amplitudes, noise=0.01, seed=1)
    fit = fitted(values - values.mean(axis=1, keepdims=True), pairs, reals)
    found = neighbours(fit)
    assert np.all(np.abs(found.theta - fit.poles.pairs) < 1.01 * np.abs(fit.poles.pairs.real))
    for gain, theta in zip(found.gains, found.theta, strict=True):
        # The other way: its amplitudes exactly, then one step of the other poles, with the new one held.
        more = evaluate(fit.problem.blocks, fit.poles.with_pair(complex(theta)), fit.problem.noise)
        assert more is not None
        free = np.delete(np.arange(more.poles.free), [2 * len(pairs), 2 * len(pairs) + 1])
        step = np.linalg.solve(more.information[np.ix_(free, free)], more.gradient[free])
        loss = fit.problem.noise.loss(more.squares, SAMPLES)
        # The loss is a logarithm, the promise its first order.
        assert gain == pytest.approx(fit.loss - loss + float(step @ more.gradient[free]), rel=0.05, abs=0.02)


def test_an_interval_holds_a_second_mode_that_is_not_excluded() -> None:
    # One channel, two modes far from alike, and noise in which the second gains less than BIC asks of a mode.
    poles, amplitudes = np.array([-0.03 + 0.1j, -0.045 + 0.13j]), np.array([[1.0, 0.4 + 0.2j]])
    clean = sampled(poles, amplitudes, noise=0.0, seed=0)
    alone = fitted(clean - clean.mean(axis=1, keepdims=True), poles[:1], np.zeros(0))
    noise = float(np.sqrt(alone.squares[0] / 15.0))
    held, times = 0, np.arange(SAMPLES, dtype=np.float64)
    for seed in range(20):
        values = sampled(poles, amplitudes, noise=noise, seed=seed)
        # With a band, no forces are looked for.
        modes = identify(as_response(times, values, ["y"]), band_hz=(1e-3, 0.49)).modes
        assert len(modes) == 1
        low, high = modes.interval(0.95).wn[0]
        held += bool(low < abs(poles[0]) < high)
    # Without what a second pair would say it is 5 of 20.
    assert held >= 13, held
