"""Comparison with other libraries on the same signals: the paper's car, seat alone."""

from __future__ import annotations

import contextlib
import importlib
import importlib.metadata
import io
import logging
import os
import time
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from tabulate import tabulate

from suspid import add_noise, eigenmodes, free_decay, statespace
from suspid.records import as_response
from suspid.units import Decibel, RealArray, Second
from validation import cars
from validation.bounds import Bound, cramer_rao, decay_amplitudes
from validation.peer_methods import METHODS, Method
from validation.peer_skeletons import RATE, Estimates

DURATION: Second = 10.0
START = {"v_tire": 1.0}
# A mode counts as found if its natural frequency is this near to the true one.
FOUND = 0.05
LEVELS: tuple[Decibel | None, ...] = (None, 20.0, 2.0)
ROUNDS = 7


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Score:
    """Errors and failures of one method at one level of noise.

    Parameters
    ----------
    wn, zeta : ndarray (record, mode)
        Errors of the mode nearest to each true one [rad/s], [1]; NaN where none is near.
    returned : int
        Modes in all records together, right or wrong.
    raised : str
        The first exception, if there was one.
    """

    wn: RealArray
    zeta: RealArray
    returned: int
    raised: str

    @property
    def failed(self) -> int:
        """How many modes were not found."""
        return int(np.sum(np.isnan(self.wn)))


def report(*, seeds: int = 10, methods: Sequence[Method] = METHODS, rounds: int = ROUNDS) -> str:
    """Return the report as markdown: accuracy, which is reproducible, then times, which are not."""
    problems = {method.name: missing_module(method.module) for method in methods}
    there = [method for method in methods if not problems[method.name]]
    scores = {m.name: [score(m, snr, seeds) for snr in LEVELS] for m in there}
    parts = [
        "# Comparison with other libraries",
        f"The paper's car, c = 300, 200, 100 N s/m; a unit impulse of velocity on the tire; seat displacement alone; "
        f"{RATE:g} Hz, {DURATION:g} s; white noise, seeds 0 to {seeds - 1}. Mean absolute error over the modes found "
        f"within {100 * FOUND:g} % of the true wn, wn in rad/s and zeta in percentage points: read it "
        f"together with the failures, because a method that finds only the easy modes has small errors. "
        f"Given: H, the true frequencies to {100 * FOUND:g} % (drawn evenly within, by the seed); "
        f"N, an order or the number of modes; -, nothing.",
        accuracy_table(methods, scores, problems),
        "Exceptions raised by peers, counted as failures: "
        + ("; ".join(_exceptions(scores)) or "none did")
        + ".\n\nSettings, with public functions alone (for mwdi, koma, pyOMA_2, sdypy-EMA and "
        "sippy_unipi chosen among a few by what they gave on these very records, to their advantage): "
        + "; ".join(f"{m.name}: {m.settings}" for m in there if m.distribution != "suspid")
        + ". The skeleton script takes the strongest of 33 rows within 8 % of the given frequency and fits lines, "
        "weighted by the squared modulus, from two envelopes after the start until the modulus is thrice the noise.",
        "## The same relative to the bound",
        "Mean absolute error over the least that an unbiased method can expect for the very modes that were found "
        "(1 is the bound; a few records scatter by about a tenth, or more where few modes were found; a biased method, "
        "or one that drops its worst estimates, may fall below), and the modes returned per record, right or wrong.",
        bound_table(there, scores, seeds),
        "## Time",
        times_text(there, rounds),
    ]
    return "\n\n".join(parts) + "\n"


def clean() -> RealArray:
    """Return the samples of the seat without noise."""
    system = statespace(cars.PAPER, outputs=("seat",))
    return np.ravel(free_decay(system, np.arange(int(RATE * DURATION)) / RATE, initial_state=START).y)


def record(snr_db: Decibel | None, seed: int) -> RealArray:
    """Return the samples of the seat with noise."""
    samples = clean()
    if snr_db is None:
        return samples
    response = as_response(np.arange(len(samples)) / RATE, samples[None], ("seat",))
    return np.ravel(add_noise(response, snr_db=snr_db, rng=np.random.default_rng(seed)).y)


def hints(seed: int) -> RealArray:
    """Return the true natural frequencies, each off by up to 5 % [rad/s]."""
    truth = eigenmodes(cars.PAPER).wn
    return np.asarray(truth * (1 + FOUND * np.random.default_rng([seed, 1]).uniform(-1, 1, len(truth))))


def bound(snr_db: Decibel) -> Bound:
    """Return the Cramér-Rao bound at a level of noise."""
    samples = clean()
    poles, amplitudes = decay_amplitudes(statespace(cars.PAPER, outputs=("seat",)), START)
    noise = np.sqrt(np.mean(samples**2) * 10 ** (-snr_db / 10))
    return cramer_rao(poles, amplitudes, np.arange(len(samples)) / RATE, noise_std=noise)


def missing_module(module: str) -> str:
    """Return why a module cannot be used; nothing if it can."""
    try:
        with silence():
            importlib.import_module(module)
    except ImportError as error:
        return f"not installed: {error}"
    except Exception as error:  # A peer may raise anything.
        return f"fails to import: {type(error).__name__}: {error}"
    return ""


def score(method: Method, snr_db: Decibel | None, seeds: int) -> Score:
    """Return the score of a method on the records at one level of noise."""
    errors, returned, raised = [], 0, ""
    for seed in range(1 if snr_db is None else seeds):
        try:
            with silence():
                found = method.run(record(snr_db, seed), hints(seed))
        except Exception as error:  # A peer may raise anything.
            found, raised = [], raised or f"{type(error).__name__}: {error}"
        returned += len(found)
        errors.append(nearest(found))
    wn, zeta = np.moveaxis(np.array(errors), 2, 0)
    return Score(wn=wn, zeta=zeta, returned=returned, raised=raised)


def nearest(found: Estimates) -> RealArray:
    """Return the errors of wn and zeta of the estimate nearest to each true mode, NaN if none is near, (mode, 2)."""
    truth = eigenmodes(cars.PAPER)
    usable = np.array([pair for pair in found if np.all(np.isfinite(pair))]).reshape(-1, 2)
    out = np.full((len(truth), 2), np.nan)
    for k, (wn, zeta) in enumerate(zip(truth.wn, truth.zeta, strict=True)):
        if len(usable):
            best = usable[np.argmin(np.abs(usable[:, 0] - wn))]
            if abs(best[0] - wn) <= FOUND * wn:
                out[k] = best[0] - wn, best[1] - zeta
    return out


def accuracy_table(methods: Sequence[Method], scores: dict[str, list[Score]], problems: dict[str, str]) -> str:
    """Return the table of mean absolute errors and failures."""
    rows = []
    expected = [f"{_expected(b.wn_std):.3f} / {100 * _expected(b.zeta_std):.3f}" for b in (bound(20.0), bound(2.0))]
    rows.append(["the bound, all three modes found", "", "", expected[0], "", expected[1], ""])
    for method in methods:
        title = f"{method.name}{_version(method)}"
        if problems[method.name]:
            rows.append([title, method.given, problems[method.name], "", "", "", ""])
            continue
        exact, *noisy = scores[method.name]
        cells = [f"{exact.failed}/{exact.wn.size}"]
        for s in noisy:
            cells += [f"{_mean(s.wn)} / {_mean(100 * s.zeta)}", f"{s.failed}/{s.wn.size}"]
        rows.append([title, method.given, *cells])
    headers = ["method", "given", "clean fail", "20 dB wn / zeta", "fail", "2 dB wn / zeta", "fail"]
    return tabulate(rows, headers=headers, tablefmt="github", disable_numparse=True)


def bound_table(methods: Sequence[Method], scores: dict[str, list[Score]], seeds: int) -> str:
    """Return the table of mean absolute errors over those expected from the bound for the same modes."""
    rows = []
    for method in methods:
        cells = []
        for snr, s in zip(LEVELS[1:], scores[method.name][1:], strict=True):
            assert snr is not None
            least = bound(snr)
            for errors, std in ((s.wn, least.wn_std), (s.zeta, least.zeta_std)):
                there = np.isfinite(errors)
                expected = np.sqrt(2 / np.pi) * np.broadcast_to(std, errors.shape)[there]
                cells.append(f"{np.sum(np.abs(errors[there])) / np.sum(expected):.2f}" if there.any() else "-")
            cells.append(f"{s.returned / seeds:.1f}")
        rows.append([method.name, *cells])
    headers = ["method", "20 dB wn", "zeta", "returned", "2 dB wn", "zeta", "returned"]
    return tabulate(rows, headers=headers, tablefmt="github", disable_numparse=True)


def times_text(methods: Sequence[Method], rounds: int) -> str:
    """Return the table of times, all taken in turns in one process on one record."""
    samples, near = record(20.0, 0), hints(0)
    seconds: dict[str, list[float]] = {method.name: [] for method in methods}
    for _ in range(rounds + 1):
        for method in methods:
            start = time.perf_counter()
            with silence(), contextlib.suppress(Exception):
                method.run(samples, near)
            seconds[method.name].append(time.perf_counter() - start)
    # The first round compiles and fills caches.
    medians = {name: float(np.median(values[1:])) for name, values in seconds.items()}
    ours = medians[methods[0].name]
    rows = [[name, f"{1e3 * value:.1f}", f"{value / ours:.2f}"] for name, value in medians.items()]
    headers = ["method", "ms", f"over {methods[0].name}"]
    threads = os.environ.get("OMP_NUM_THREADS", "as many as the machine has")
    return (
        f"One call on the record at 20 dB, seed 0: median of {rounds} rounds in one process, the methods in turns, "
        f"after one round to warm up; BLAS threads: {threads}. The milliseconds hold for this machine only; "
        f"compare the ratios. Reading and filtering the record counts where a method needs it.\n\n"
        + tabulate(rows, headers=headers, tablefmt="github", disable_numparse=True)
    )


@contextlib.contextmanager
def silence() -> Iterator[None]:
    """Suppress output, log entries and warnings of peers."""
    before = logging.root.manager.disable
    logging.disable(logging.CRITICAL)
    try:
        with (
            warnings.catch_warnings(),
            np.errstate(all="ignore"),
            contextlib.redirect_stdout(io.StringIO()),
            contextlib.redirect_stderr(io.StringIO()),
        ):
            warnings.simplefilter("ignore")
            yield
    finally:
        logging.disable(before)


def _expected(std: RealArray) -> float:
    """Return the mean absolute error of normal errors of these standard deviations."""
    return float(np.sqrt(2 / np.pi) * np.mean(std))


def _mean(errors: RealArray) -> str:
    there = np.abs(errors[np.isfinite(errors)])
    return f"{np.mean(there):.3f}" if there.size else "-"


def _version(method: Method) -> str:
    if method.distribution == "suspid":
        return ""
    try:
        return f" ({method.distribution} {importlib.metadata.version(method.distribution)})"
    except importlib.metadata.PackageNotFoundError:
        return ""


def _exceptions(scores: dict[str, list[Score]]) -> list[str]:
    """Return which methods raised, where, and what."""
    return [
        f"{name} ({'without noise' if snr is None else f'{snr:g} dB'}: {s.raised.splitlines()[0][:120]})"
        for name, by_level in scores.items()
        for snr, s in zip(LEVELS, by_level, strict=True)
        if s.raised
    ]
