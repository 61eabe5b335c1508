"""Durations of the main calls relative to plain numpy work, kept beside the report and compared with those of a run.

A bare time says more about the machine than about the code. Every duration is therefore divided by that of a fixed
piece of numpy work (`yardstick`) measured next to it in the same process.
"""

from __future__ import annotations

import json
import multiprocessing
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from tabulate import tabulate

from suspid import clean, cwt, denoise, find_decays, identify, read_recording, reconstruct
from suspid.errors import InputError
from suspid.records import as_response
from suspid.units import Ratio, RealArray
from validation import cars
from validation.speed import CHANNELS, decay

if TYPE_CHECKING:
    import control

EXAMPLE = Path(__file__).parents[1] / "examples" / "quarter_car.csv"

# Fresh processes for each measurement: memory layout and hash seeds differ between processes, so the scatter between
# rounds in one process is too small. Fewer than four leave the t-test with little power; each takes about 5 s.
PROCESSES = 5
# Rounds in each process, of which the shortest counts: interruptions only lengthen a call.
ROUNDS = 3
# Probability of a false alarm of one comparison, all calls together. A higher level cries wolf more often.
LEVEL = 0.01
# A slowdown below this share is not reported, however certain it is: nobody would act on it.
WORTH_TELLING = 0.1


@dataclass(frozen=True, kw_only=True, slots=True)
class Change:
    """One call in the run and in the committed figures.

    Parameters
    ----------
    name : str
        The call.
    before, now : float or None
        Geometric means of its duration over that of the yardstick [1]; None where it was not measured.
    p_value : float
        Probability of this slowdown or a larger one if nothing had changed, by Welch's t-test on logarithms [1].
    slower : bool
        Whether the call got slower by more than the scatter.
    """

    name: str
    before: float | None
    now: float | None
    p_value: float
    slower: bool


def measured(*, processes: int = PROCESSES, rounds: int = ROUNDS) -> dict[str, list[float]]:
    """Return the duration of each call over that of the yardstick, once for each fresh process."""
    context = multiprocessing.get_context("spawn")
    runs: list[dict[str, float]] = []
    for _ in range(processes):
        with ProcessPoolExecutor(max_workers=1, mp_context=context) as pool:
            runs.append(pool.submit(_in_process, rounds).result())
    return {name: [run[name] for run in runs] for name in runs[0]}


def ratios(timed: Mapping[str, Callable[[], object]], *, rounds: int) -> dict[str, float]:
    """Return the CPU time of each call over that of the yardstick measured next to it, each the least of all rounds."""
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in timed}
    for _ in range(rounds + 1):
        for name, call in timed.items():
            found[name].append((_seconds(call), _seconds(yardstick)))
    # The first round imports and fills caches.
    least = {name: np.min(pairs[1:], axis=0) for name, pairs in found.items()}
    return {name: float(ours / theirs) for name, (ours, theirs) in least.items()}


def calls() -> dict[str, Callable[[], object]]:
    """Return the calls that are timed, each without arguments."""
    seat = _record(5000, 1)
    three, long = _record(5000, 3), _record(50_000, 3)
    # Ten seconds of noise alone, then the decay.
    quiet = 1e-4 * np.random.default_rng(2).standard_normal((3, 5000))
    late = as_response(np.arange(10_000) / 500.0, np.hstack([quiet, np.asarray(three.y)]), CHANNELS)
    return {
        "identify, 1 channel, 5000 samples": partial(identify, seat),
        "identify, 3 channels, 5000 samples": partial(identify, three),
        "identify, 3 channels, 50000 samples": partial(identify, long),
        "find_decays, 3 channels, 10000 samples": partial(find_decays, late),
        "reconstruct, 3 modes": partial(reconstruct, identify(three).modes, cars.PAPER),
        "cwt, 3 channels, 5000 samples, 100 rows": partial(cwt, three, omega=np.geomspace(3, 1000, 100), bandwidth=22),
        "denoise, 3 channels, 5000 samples": partial(denoise, three),
        "read_recording and clean, 5000 rows of text": lambda: clean(read_recording(EXAMPLE)),
    }


def _record(samples: int, channels: int) -> control.TimeResponseData:
    """Return a noisy free decay of the paper's car at 500 Hz."""
    timepts, values = decay(samples, 500.0)
    return as_response(timepts, values[:channels], CHANNELS[:channels])


def yardstick() -> float:
    """Do a fixed piece of numpy work, of the kinds that the library spends its time on; about 10 ms."""
    values = np.sin(np.arange(1 << 16) ** 1.5)
    spectrum = np.fft.rfft(values)
    basis = np.exp(1j * np.outer(np.arange(2000) / 500.0, np.arange(1, 21)))
    return float(np.abs(spectrum[1]) + np.linalg.svd(basis, compute_uv=False)[0])


def changes(before: Mapping[str, Sequence[float]], now: Mapping[str, Sequence[float]]) -> list[Change]:
    """Compare the ratios of two runs, call by call.

    A call is slower if Welch's one-sided t-test on the logarithms rejects equality at `LEVEL` over the number of calls
    and the geometric mean grew by more than `WORTH_TELLING`.

    Raises
    ------
    InputError
        If a call has fewer than two ratios or one that is not positive.
    """
    common = [name for name in before if name in now]
    found = [_change(name, _logs(name, before[name]), _logs(name, now[name]), LEVEL / len(common)) for name in common]
    found += [_alone(name, before[name], known=True) for name in before if name not in now]
    return found + [_alone(name, now[name], known=False) for name in now if name not in before]


def comparison_text(found: Sequence[Change]) -> str:
    """Return the comparison as a table and a sentence on each call that got slower."""
    rows = [
        [c.name, _text(c.before), _text(c.now), f"{c.now / c.before:.2f}" if c.now and c.before else "", _verdict(c)]
        for c in found
    ]
    headers = ["call, over the yardstick", "committed", "now", "now / committed", ""]
    told = [
        f"{c.name}: {c.now / c.before:.2f} times the committed duration (p = {c.p_value:.1g})"
        for c in found
        if c.slower and c.now and c.before
    ]
    summary = "\n".join(["Slower than the committed figures:", *told]) if told else "No call got slower."
    return tabulate(rows, headers=headers, tablefmt="github", disable_numparse=True) + f"\n\n{summary}"


def read_ratios(path: Path) -> dict[str, list[float]]:
    """Return the ratios of an earlier run.

    Raises
    ------
    InputError
        If the file is missing or is not of this kind.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        return {str(name): [float(ratio) for ratio in values] for name, values in content["ratios"].items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(f"{path}: no ratios to compare with ({error}); write them with --ratios") from None


def write_ratios(path: Path, found: Mapping[str, Sequence[float]]) -> None:
    """Write the ratios of a run, for `read_ratios`."""
    content = {
        "about": "duration of each call over that of validation.speed_ratios.yardstick, one ratio for each process",
        "ratios": {name: [round(ratio, 4) for ratio in values] for name, values in found.items()},
    }
    path.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def _change(name: str, before: RealArray, now: RealArray, level: Ratio) -> Change:
    from scipy.special import stdtr

    growth = float(np.mean(now) - np.mean(before))
    variances = np.array([np.var(x, ddof=1) / len(x) for x in (before, now)])
    total = float(np.sum(variances))
    if total > 0:
        freedom = total**2 / np.sum(variances**2 / (np.array([len(before), len(now)]) - 1))
        p_value = float(stdtr(freedom, -growth / np.sqrt(total)))
    else:
        p_value = 0.0 if growth > 0 else 1.0
    slower = bool(p_value < level and growth > np.log1p(WORTH_TELLING))
    means = [float(np.exp(np.mean(x))) for x in (before, now)]
    return Change(name=name, before=means[0], now=means[1], p_value=p_value, slower=slower)


def _alone(name: str, values: Sequence[float], *, known: bool) -> Change:
    mean = float(np.exp(np.mean(_logs(name, values))))
    before, now = (mean, None) if known else (None, mean)
    return Change(name=name, before=before, now=now, p_value=float("nan"), slower=False)


def _logs(name: str, values: Sequence[float]) -> RealArray:
    array = np.asarray(values, float)
    if array.size < 2 or not np.all(np.isfinite(array) & (array > 0)):
        raise InputError(f"{name}: ratios {list(values)}; at least two positive numbers are needed")
    return np.asarray(np.log(array))


def _verdict(change: Change) -> str:
    if change.before is None:
        return "not measured before"
    if change.now is None:
        return "no longer measured"
    return "slower" if change.slower else ""


def _in_process(rounds: int) -> dict[str, float]:
    return ratios(calls(), rounds=rounds)


def _seconds(call: Callable[[], object]) -> float:
    """Return the CPU time of this process: other processes on the machine lengthen the elapsed time."""
    start = time.process_time()
    call()
    return time.process_time() - start


def _text(ratio: float | None) -> str:
    return "" if ratio is None else f"{ratio:.3g}"
