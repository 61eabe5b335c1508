"""Whether results hang on rounding: records are changed in their last digits and identified again."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

import numpy as np
from tabulate import tabulate

from suspid import Decays, Identification, find_decays, free_decay, identify
from suspid.records import as_response
from suspid.units import Hertz, RealArray
from validation import cars, close_modes

# Seeds that were not used during development, records in a row, and changes of each.
FIRST_SEED = 790_000
RECORDS, CHANGES = 40, 2
RATE: Hertz = 200.0
# Rounding of a few operations in double precision, over each sample.
CHANGE = 1e-14
# Results are the same within this share of a standard deviation besides what the change itself says, and standard
# deviations within this share of themselves.
SAME = 1e-6


@dataclass(frozen=True, kw_only=True, slots=True)
class Kept:
    """What a record that is changed in its last digits keeps; all of it under each change."""

    modes: bool  # their number, and their values
    intervals: bool  # their standard deviations
    verdict: bool  # in every word
    decays: bool  # their starts, ends and doubts


def _quarter(car: Callable[[np.random.Generator], RealArray], rng: np.random.Generator) -> tuple[RealArray, RealArray]:
    """Return times and samples (channel, sample) of a quarter car with white noise of 10 to 60 dB."""
    values = car(rng)
    return _noisy(values, snr_db=rng.uniform(10, 60), noise=rng.standard_normal(values.shape))


def _noisy(
    values: RealArray, *, snr_db: float, noise: RealArray, std: RealArray | float = 1.0
) -> tuple[RealArray, RealArray]:
    """Return times, and samples with noise of given standard deviation scaled to a signal-to-noise ratio."""
    size = np.std(values, axis=1, keepdims=True) * 10 ** (-snr_db / 20)
    return np.arange(values.shape[1]) / RATE, values + size * noise / std


def _light(rng: np.random.Generator) -> RealArray:
    times = np.arange(int(rng.integers(400, 2000))) / RATE
    return np.asarray(free_decay(cars.PAPER, times, initial_state={"v_tire": 1.0}).y)


def _heavy(rng: np.random.Generator) -> RealArray:
    times = np.arange(int(rng.integers(200, 2000))) / RATE
    return np.asarray(free_decay(cars.random_car(rng), times, initial_state={"v_tire": 1.0}).y)


def _decay(source: Callable[..., close_modes.Decay], rng: np.random.Generator) -> tuple[RealArray, RealArray]:
    times, values, _ = close_modes.record(source(rng), rng)
    return times, values


def _one_channel(rng: np.random.Generator) -> tuple[RealArray, RealArray]:
    times, values = _quarter(_heavy, rng)
    return times, values[:1]


def _coloured(rng: np.random.Generator) -> tuple[RealArray, RealArray]:
    from scipy.signal import lfilter

    values = _heavy(rng)
    noise = lfilter([1], [1, -rng.uniform(0.3, 0.95)], rng.standard_normal(values.shape), axis=1)
    return _noisy(values, snr_db=rng.uniform(10, 60), noise=noise, std=np.std(noise, axis=1, keepdims=True))


WORLDS: dict[str, Callable[[np.random.Generator], tuple[RealArray, RealArray]]] = {
    "quarter car of the paper": lambda rng: _quarter(_light, rng),
    "quarter cars": lambda rng: _quarter(_heavy, rng),
    "their seat alone": _one_channel,
    "in coloured noise": _coloured,
    "two modes 3 % apart": lambda rng: _decay(close_modes.pair, rng),
    "half cars": lambda rng: _decay(close_modes.half, rng),
    "full cars": lambda rng: _decay(close_modes.full, rng),
}


def kept(world: str, seed: int) -> Kept:
    """Return what one record of a world keeps when it is changed in its last digits."""
    times, values = WORLDS[world](np.random.default_rng(seed))
    names = [f"y{k}" for k in range(len(values))]
    before, decays = _results(times, values, names)
    each = []
    for change in range(CHANGES):
        signs = np.random.default_rng([seed, change]).choice([-1.0, 1.0], values.shape)
        after, others = _results(times, values * (1 + CHANGE * signs), names)
        same, alike = _same_modes(before, after, values)
        told = [[(d.start, d.stop, [x.code for x in d.doubts]) for d in found] for found in (decays, others)]
        each.append((same, alike, str(before.verdict) == str(after.verdict), told[0] == told[1]))
    modes, intervals, verdict, same_decays = (all(part) for part in zip(*each, strict=True))
    return Kept(modes=modes, intervals=intervals, verdict=verdict, decays=same_decays)


def _results(times: RealArray, values: RealArray, names: list[str]) -> tuple[Identification, Decays]:
    record = as_response(times, values, names)
    return identify(record), find_decays(record)


def _same_modes(one: Identification, other: Identification, values: RealArray) -> tuple[bool, bool]:
    """Return whether modes are the same, and whether their standard deviations are as well."""
    if len(one.modes) != len(other.modes):
        return False, False
    if not len(one.modes):
        return True, True
    # What the change itself says of a pole, in its standard deviations: its size over that of the noise.
    bound = SAME + 3 * CHANGE * np.sqrt(np.sum(values**2 / one.noise_std[:, None] ** 2))
    same = alike = True
    for quantity in ("wn", "zeta"):
        std, again = (np.asarray(getattr(found.modes, f"{quantity}_std")) for found in (one, other))
        apart = np.abs(getattr(one.modes, quantity) - getattr(other.modes, quantity))
        same &= bool(np.all(apart <= bound * std))
        alike &= bool(np.all(np.abs(again - std) <= SAME * std))
    return same, alike


def report(*, records: int = RECORDS, seed: int = FIRST_SEED) -> str:
    """Return the report as markdown."""
    rows = []
    with ProcessPoolExecutor() as pool:
        for number, world in enumerate(WORLDS):
            seeds = range(seed + 1000 * number, seed + 1000 * number + records)
            found = list(pool.map(kept, [world] * records, seeds, chunksize=5))
            counts = [sum(getattr(one, name) for one in found) for name in ("modes", "intervals", "verdict", "decays")]
            rows.append([world, records, *counts])
    headers = ["world", "records", "same modes", "same intervals", "same verdict", "same decays"]
    told = (
        f"Every sample is changed by {CHANGE:g} of itself, up or down at random, {CHANGES} times a record. How many "
        "records then have the same modes (their number; wn and zeta within a millionth of a standard deviation "
        "besides what the change says itself), the same standard deviations (within a millionth), the same verdict "
        "in every word by `identify`, and the same decays by `find_decays` (starts, ends, doubts); noise of 10 to "
        f"60 dB for quarter cars, 20 to 60 dB for the others; seeds from {seed} on."
    )
    return "\n\n".join(["# Rounding", told, tabulate(rows, headers, tablefmt="github")]) + "\n"
