"""Records without a free decay: coloured noise, engines, pulses of force, braking, modulated noise.

A mode that is returned from such a record is false. Each kind is drawn from its own law.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor

import numpy as np
from tabulate import tabulate

from suspid import Level, analyse, identify
from suspid.records import as_response
from suspid.units import RealArray

# Seeds that were not used during development.
FIRST_SEED = 760_000
# Records of each kind.
SEEDS = int(os.environ.get("SUSPID_SEEDS", "100"))

Drawn = tuple[RealArray, RealArray]


def _clock(rng: np.random.Generator) -> RealArray:
    """Return the times of a record of 400 to 4000 samples [s]."""
    return np.asarray(np.arange(int(rng.uniform(400, 4000))) / float(rng.choice([100.0, 200.0, 500.0])), float)


def _channels(rng: np.random.Generator) -> int:
    return int(rng.integers(1, 5))


def autoregression(memory: float) -> Callable[[np.random.Generator], Drawn]:
    """Return the source of ``x_k = memory x_(k-1) + e_k``, stationary from the start."""
    from scipy.signal import lfilter

    def drawn(rng: np.random.Generator) -> Drawn:
        time = _clock(rng)
        run_in = int(20 / (1 - memory))
        noise = rng.standard_normal((_channels(rng), len(time) + run_in))
        return time, np.asarray(lfilter([1.0], [1.0, -memory], noise, axis=1)[:, run_in:])

    return drawn


def pink(rng: np.random.Generator) -> Drawn:
    """Return noise whose power density falls as 1 / f, of which the record is an eighth."""
    time = _clock(rng)
    count = 8 * len(time)
    spectrum = np.fft.rfft(rng.standard_normal((_channels(rng), count)), axis=1)
    spectrum[:, 1:] /= np.sqrt(np.arange(1, spectrum.shape[1]))
    spectrum[:, 0] = 0.0
    return time, np.asarray(np.fft.irfft(spectrum, count, axis=1)[:, : len(time)])


def walk(rng: np.random.Generator) -> Drawn:
    """Return a random walk."""
    time = _clock(rng)
    return time, np.asarray(np.cumsum(rng.standard_normal((_channels(rng), len(time))), axis=1))


def idle(rng: np.random.Generator) -> Drawn:
    """Return an engine at idle: orders of a shaft near 12 Hz whose speed wanders by a percent, and white noise."""
    time = _clock(rng)
    step, channels = float(time[1]), _channels(rng)
    pull = np.exp(-step / 1.0)
    wander = np.zeros(len(time))
    for k in range(1, len(time)):
        wander[k] = pull * wander[k - 1] + np.sqrt(1 - pull**2) * rng.standard_normal()
    shaft = 2 * np.pi * np.cumsum(12.0 * rng.uniform(0.9, 1.1) * (1 + 0.01 * wander)) * step
    values = 0.2 * rng.standard_normal((channels, len(time)))
    for order in (0.5, 1.0, 1.5, 2.0, 3.0, 4.0):
        size = rng.uniform(0.1, 1.0, (channels, 1))
        values += size * np.cos(order * shaft + rng.uniform(0, 2 * np.pi, (channels, 1)))
    return time, np.asarray(values)


def pulse(shape: Callable[[RealArray], RealArray]) -> Callable[[np.random.Generator], Drawn]:
    """Return the source of one pulse that leaves nothing moving, and white noise at 20 to 60 dB below its peak."""

    def drawn(rng: np.random.Generator) -> Drawn:
        time = _clock(rng)
        width = float(np.exp(rng.uniform(np.log(10 * time[1]), np.log(0.2 * time[-1]))))
        at = rng.uniform(0.0, 0.8) * time[-1]
        size = rng.uniform(-1.0, 1.0, (_channels(rng), 1))
        noise = np.max(np.abs(size)) * 10 ** (-rng.uniform(20.0, 60.0) / 20)
        values = size * shape(np.asarray((time - at) / width))
        return time, np.asarray(values + noise * rng.standard_normal(values.shape))

    return drawn


def gaussian(x: RealArray) -> RealArray:
    """Return ``exp(-x^2 / 2)``."""
    return np.asarray(np.exp(-(x**2) / 2))


def half_sine(x: RealArray) -> RealArray:
    """Return half a period of a sine between 0 and 1."""
    return np.where((x > 0) & (x < 1), np.sin(np.pi * np.clip(x, 0.0, 1.0)), 0.0)


def braking(rng: np.random.Generator) -> Drawn:
    """Return accelerations of a stop: a ramp to a level that varies slowly, and back to zero."""
    time = _clock(rng)
    start, stop = np.sort(rng.uniform(0.0, 1.0, 2)) * time[-1]
    rise, fall = rng.uniform(0.1, 0.6), rng.uniform(0.05, 0.3)
    level = np.clip((time - start) / rise, 0, 1) * np.clip((stop - time) / fall, 0, 1)
    level = level * (1 + 0.2 * np.cos(2 * np.pi * rng.uniform(0.1, 0.5) * time + rng.uniform(0, 6)))
    values = rng.uniform(-1, 1, (_channels(rng), 1)) * level
    return time, np.asarray(values + 0.02 * rng.standard_normal(values.shape))


def speech(rng: np.random.Generator) -> Drawn:
    """Return syllables: noise through two resonances, its size modulated at 2 to 6 Hz, with pauses."""
    from scipy.signal import lfilter

    time = _clock(rng)
    step, channels = float(time[1]), _channels(rng)
    sound = rng.standard_normal(len(time))
    for centre in rng.uniform(0.1, 0.8, 2):
        radius = rng.uniform(0.8, 0.97)
        sound = lfilter([1.0], [1.0, -2 * radius * np.cos(np.pi * centre), radius**2], sound)
    rate = rng.uniform(2.0, 6.0)
    size = np.clip(np.sin(2 * np.pi * rate * time + rng.uniform(0, 6)) + rng.uniform(-0.3, 0.8), 0.0, None)
    size = size * np.repeat(rng.uniform(0.2, 1.0, int(time[-1] * rate) + 2), int(1 / rate / step) + 1)[: len(time)]
    values = rng.uniform(0.2, 1.0, (channels, 1)) * sound / np.std(sound) * size
    return time, np.asarray(values + 0.01 * rng.standard_normal(values.shape))


KINDS: dict[str, Callable[[np.random.Generator], Drawn]] = {
    **{f"autoregression, {memory:g}": autoregression(memory) for memory in (0.5, 0.9, 0.99)},
    "1 / f": pink,
    "random walk": walk,
    "engine at idle, 12 Hz": idle,
    "Gaussian pulse": pulse(gaussian),
    "half-sine pulse": pulse(half_sine),
    "braking": braking,
    "speech-like modulation": speech,
}


def outcome(kind: str, seed: int) -> list[bool]:
    """Return whether `identify`, and `analyse`, find a mode that is called better than doubtful, and any mode."""
    time, values = KINDS[kind](np.random.default_rng(seed))
    record = as_response(time, values, [f"y{k}" for k in range(len(values))])
    out = []
    for found in (identify(record), analyse(record)):
        out += [len(found.modes) > 0 and found.verdict.level > Level.DOUBTFUL, len(found.modes) > 0]
    return out


def report(*, seeds: int = SEEDS) -> str:
    """Return the report as markdown."""
    rows = []
    with ProcessPoolExecutor(max_workers=2) as pool:
        for kind in KINDS:
            results = list(pool.map(outcome, [kind] * seeds, range(FIRST_SEED, FIRST_SEED + seeds), chunksize=5))
            rows.append([kind, str(seeds), *(f"{100 * share:.0f} %" for share in np.mean(results, axis=0))])
            # All rows take long.
            print("  ".join(rows[-1]), file=sys.stderr, flush=True)
    headers = ["record", "records", "identify: not doubtful", "any mode", "analyse: not doubtful", "any mode"]
    return (
        "\n\n".join(
            [
                "# Records without a free decay",
                f"1 to 4 channels, 400 to 4000 samples at 100 to 500 Hz, seeds {FIRST_SEED} and on: modes that "
                f"`identify` finds in the whole record, and `analyse` (the command) in the stretch that is the most "
                f"like a decay. Every mode is false.",
                tabulate(rows, headers=headers, tablefmt="github", disable_numparse=True),
            ]
        )
        + "\n"
    )
