"""The rest before a release against its definition, sample by sample."""

import numpy as np
import pytest

from suspid import find_decays
from suspid.decays.envelopes import finest
from suspid.decays.predictions import freed_at, released_at
from suspid.decays.rests import rests_until
from suspid.records import as_response
from suspid.units import RealArray

# Standard deviation of the error of rounding to whole numbers.
ROUNDED = 12**-0.5


def stretches(rng: np.random.Generator, channels: int) -> RealArray:
    """Return rounded samples that rest, rest but for noise, or swing, in turns of any length."""
    parts, level = list[RealArray](), np.zeros((channels, 1))
    while sum(part.shape[1] for part in parts) < 200:
        count = int(rng.integers(1, 60))
        swing = np.sin(0.3 * np.arange(count)) * rng.normal(0, 10, (channels, 1))
        noise = rng.normal(0, 0.3, (channels, count)) * (rng.random() < 0.4)
        parts.append(np.asarray(np.round(level + (noise if rng.random() < 0.5 else swing)), float))
        level = parts[-1][:, -1:]
    return np.concatenate(parts, axis=1)


def by_definition(values: RealArray, within: float) -> int:
    """Return the last sample of the last rest that lasts longer than the motion after it takes for half of its way."""
    count = values.shape[1]
    for end in range(count - 3, -1, -1):
        still, moves = (np.abs(values[:, k + 1] - values[:, k]) for k in (end, end + 1))
        if not (np.all(still <= within) and np.any(moves > within)):
            continue
        before, after = values[:, : end + 2], values[:, end + 1 :]
        rest = 1
        while rest < before.shape[1] and np.all(np.ptp(before[:, -rest - 1 :], axis=1) <= within):
            rest += 1
        sizes = np.ptp(after, axis=1)
        far = np.any(np.abs(after - after[:, :1]) > 0.5 * np.where(sizes > within, sizes, np.inf)[:, None], axis=0)
        if np.any(sizes > np.maximum(np.ptp(before, axis=1), within)) and rest - 1 > max(8, int(np.argmax(far))):
            held = 0
            while held + 1 < after.shape[1] and np.all(np.ptp(after[:, : held + 2], axis=1) <= within):
                held += 1
            return end + held + 1
    return 0


@pytest.mark.parametrize("channels", [1, 2])
def test_as_it_is_defined(channels: int) -> None:
    rng, found = np.random.default_rng(channels), list[int]()
    for _ in range(150):
        values = stretches(rng, channels)
        found.append(released_at(values, np.full(channels, ROUNDED)))
        assert found[-1] == by_definition(values, 1.5)
    assert 20 < np.count_nonzero(found) < 130


def test_the_last_sample_of_a_rest_counts_as_moved_before() -> None:
    """It creeps by one step, as far as the motion after it reaches; one further is growth."""
    for lowest, held in ((0.0, 0), (-1.0, 13)):
        values = np.array([0.0, *[10.0] * 12, 11.0, lowest, lowest, lowest])[None]
        assert released_at(values, np.array([ROUNDED])) == by_definition(values, 1.5) == held


@pytest.mark.parametrize("seed", range(6))
def test_noise_tells_no_force(seed: int) -> None:
    """A long tail of noise alone is fitted where its sum is by chance the largest: all motion is an error of that."""
    time = np.arange(4000) / 250
    motion = 8e-3 * np.exp(-1.0 * time) * np.sin(6.5 * time)
    values = np.stack([motion, 0.6 * motion]) + 5e-4 * np.random.default_rng(seed).standard_normal((2, time.size))
    first, _ = freed_at(values, finest(values), step=1 / 250)
    assert first < 125


@pytest.mark.parametrize("seed", range(12))
def test_a_rest_within_noise_ends_where_the_mass_is_let_go(seed: int) -> None:
    """Two masses at rest for 3 s, a motion of 150 times the noise: the decay begins with it, but for some samples."""
    time = np.arange(0, 12, 0.003)
    since, wn, zeta = np.maximum(time - 3.0, 0.0), np.array([[10.43], [42.85]]), np.array([[0.039], [0.024]])
    free = np.exp(-zeta * wn * since) * (np.cos(wn * since) + zeta * np.sin(wn * since))
    values = np.array([[150.0, 6.0], [90.0, -8.0]]) @ free
    values += np.random.default_rng(seed).standard_normal(values.shape)
    (decay, *_) = find_decays(as_response(time, values, ["left", "right"]))
    assert abs(decay.start - 3.0) < 0.02


@pytest.mark.parametrize("noise", [0.0, 1e-4, 1e-2])
def test_motion_that_begins_with_the_first_sample_has_no_rest(noise: float) -> None:
    place = np.arange(500)
    for seed in range(100):
        rng = np.random.default_rng(seed)
        turn, zeta = 2 * np.pi * rng.uniform(0.005, 0.2), rng.uniform(0.01, 0.4)
        values = np.exp(-zeta * turn * place) * np.cos(turn * place + rng.uniform(0, 2 * np.pi))
        assert rests_until((values + noise * rng.standard_normal(500))[None]) == 0
