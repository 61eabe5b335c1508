"""Time and memory of identification, against the length of the record and relative to other libraries."""

from __future__ import annotations

import importlib
import os
import time
import tracemalloc
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from itertools import compress
from typing import Any

import numpy as np
from tabulate import tabulate

from suspid import Scalogram, eigenmodes, free_decay, identify, statespace
from suspid.records import as_response
from suspid.signals import Signal, as_signal
from suspid.units import ComplexArray, Hertz, RealArray
from suspid.wavelets import Morlet
from suspid.wavelets.best_bandwidth import ENTROPY_CUT
from suspid.wavelets.transform import CUT, transform
from validation import cars
from validation.peer_methods import mwdi
from validation.peer_skeletons import RATE
from validation.peers import START, missing_module, record, silence
from validation.speed_everyday import everyday_table

CHANNELS = ("seat", "chassis", "tire")
LENGTHS = (1_000, 10_000, 100_000, 1_000_000)
# The transform: the paper's wavelet, on rows from four cycles in the record to 0.9 of the Nyquist frequency.
SAMPLES, ROWS, BANDWIDTH, CENTER = 100_000, 300, 22.0, 2 * np.pi
# Default settings of ssqueezepy's cwt.
PEER_DEFAULT = "ssqueezepy, float32, reflect padding, parallel on"
# Distance from the ends in envelopes, beyond which the padding of a library has no effect.
CLEAR = 6.0


def report(
    *,
    rounds: int = 7,
    lengths: Sequence[int] = LENGTHS,
    samples: int = SAMPLES,
    rows: int = ROWS,
    everyday: Callable[[int], str] = everyday_table,
) -> str:
    """Return the report as markdown: accuracy, which is reproducible, then times, which are not."""
    noise = np.random.default_rng(0).standard_normal(samples)
    signal = as_signal(as_response(np.arange(samples) / RATE, noise[None], ("seat",)))
    low, high = 2 * np.pi * 4 / signal.duration, 0.9 * np.pi * RATE
    # Descending: ssqueezepy wants ascending scales.
    omega = np.geomspace(high, low, rows)
    runs = transforms(signal, omega)
    threads = os.environ.get("OMP_NUM_THREADS", "as many as the machine has")
    parts = [
        "# Speed and memory",
        "## Accuracy of the transforms",
        f"White noise, {samples:,} samples at {RATE:g} Hz; {rows} frequencies from {low:.3g} to {high:.4g} rad/s, "
        f"evenly spaced in the logarithm; the same wavelet for both, exp(2 pi j t) exp(-t^2 / {BANDWIDTH:g}). "
        f"Largest difference from the direct sum of Eq. (12) in double precision, over the row's RMS, at points "
        f"{CLEAR:g} envelopes or more from the ends, below 0.7 of the Nyquist frequency, after one common factor for "
        f"the normalisation.",
        accuracy_table(runs, signal, omega),
        "## Times",
        f"Medians of CPU time, of elapsed time where peers use several threads (transforms); all calls of one table "
        f"take turns in one process; BLAS threads: {threads}. The milliseconds hold for this machine only; compare "
        f"the ratios.",
        "### One call without hints, one channel, 5000 samples at 20 dB",
        identify_text(rounds),
        "### Everyday calls",
        "CPU time of the process, the least of several rounds in turns. The limit is one `numpy.fft.rfft` of the "
        "record: whoever looks at all samples in all frequencies takes as long. Peers that are installed stand below "
        "the call; `before` is the ratio of the report before this one.",
        everyday(max(2, rounds // 2)),
        "### Against the length of the record, three channels",
        "The paper's car; the noise is that of 20 dB over ten seconds, whatever the length. Memory is the peak that "
        "Python traces during the call, record excluded.",
        lengths_table(lengths, rounds),
        f"### The transform of {samples:,} samples at {rows} frequencies",
        "suspid keeps each row at the rate that its bandwidth needs, from which any other sample follows; ssqueezepy "
        "gives every sample of every row. Of its two ways, all rows at once or one by one, the faster is listed, and "
        'a row "kept" says what it takes when the wavelet\'s spectra are kept from an earlier call of the same '
        "length. suspid works in double precision on one thread and keeps nothing.",
        transforms_table(runs, max(1, rounds // 2)),
    ]
    return "\n\n".join(parts) + "\n"


def identify_text(rounds: int) -> str:
    """Return the table of `identify` and mwdi."""
    samples = record(20.0, 0)
    response = as_response(np.arange(len(samples)) / RATE, samples[None], ("seat",))
    truth = eigenmodes(cars.PAPER).wn
    runs: dict[str, Callable[[], object]] = {
        "suspid, identify(record)": lambda: identify(response),
        "suspid, identify(record, modes=3)": lambda: identify(response, modes=3),
    }
    if missing_module("mwdi"):
        return "mwdi is not installed.\n\n" + _ratios(_medians(runs, rounds))
    identifier = importlib.import_module("mwdi").MorletWave(samples, RATE)
    runs["mwdi, wn and zeta of three modes near given frequencies, as beside the peers"] = lambda: mwdi(samples, truth)
    runs["mwdi, zeta alone of three modes at their true frequencies, defaults"] = lambda: [
        identifier.identify_damping(w) for w in truth
    ]
    medians = _medians(runs, rounds)
    ours, _, modes, dampings = medians.values()
    return (
        f"`identify(record)` takes {ours / modes:.2f} times what mwdi takes for wn and zeta of three modes near given "
        f"frequencies, and {ours / dampings:.2f} times what it takes for zeta alone at the true ones.\n\n"
        f"{_ratios(medians)}"
    )


def lengths_table(lengths: Sequence[int], rounds: int) -> str:
    """Return the table of time and memory against the number of samples."""
    table = []
    for kind in ("longer", "faster"):
        before = 0.0
        for length in lengths:
            response = as_response(*decay(length, RATE if kind == "longer" else length / 10.0), CHANNELS)
            seconds = _medians({"": partial(identify, response)}, rounds if length <= 100_000 else 1)[""]
            tracemalloc.start()
            try:
                found = len(identify(response).modes)
                peak = tracemalloc.get_traced_memory()[1]
            finally:
                tracemalloc.stop()
            table.append(
                [
                    "500 Hz, longer" if kind == "longer" else "10 s, sampled faster",
                    f"{length:,}",
                    found,
                    f"{1e3 * seconds:.0f}",
                    f"{seconds / before:.1f}" if before else "",
                    f"{peak / 2**20:.1f}",
                    f"{peak / (8 * len(CHANNELS) * length):.1f}",
                ]
            )
            before = seconds
    headers = ["record", "samples", "modes", "ms", "over the one before", "peak MiB", "peak over the record's size"]
    return tabulate(table, headers=headers, tablefmt="github", disable_numparse=True)


def decay(length: int, rate: Hertz) -> tuple[RealArray, RealArray]:
    """Return times and noisy samples (channel, sample) of the paper's car."""
    system = statespace(cars.PAPER, outputs=CHANNELS)
    ten = np.asarray(free_decay(system, np.arange(5000) / 500, initial_state=START).y)
    timepts = np.arange(length) / rate
    clean = np.asarray(free_decay(system, timepts, initial_state=START).y)
    std = 0.1 * np.sqrt(np.mean(ten**2, axis=1))
    return timepts, clean + std[:, None] * np.random.default_rng(0).standard_normal(clean.shape)


def transforms(signal: Signal, omega: RealArray) -> Mapping[str, Callable[[], Any]]:
    """Return the ways to transform, each a function that gives a `Scalogram` or rows at full rate."""
    wavelet = Morlet(center=CENTER, bandwidth=BANDWIDTH)

    def ours(precision: float, full_rate: bool = False) -> Callable[[], Scalogram]:
        return lambda: transform(signal, omega=omega, wavelet=wavelet, precision=precision, full_rate=full_rate)

    runs: dict[str, Callable[[], Any]] = {
        f"suspid, own rates, to {CUT:g} (default)": ours(CUT),
        f"suspid, own rates, to {ENTROPY_CUT:g} (the search for N)": ours(ENTROPY_CUT),
        "suspid, own rates, to 1e-06": ours(1e-6),
        f"suspid, full rate, to {CUT:g}": ours(CUT, full_rate=True),
    }
    if missing_module("ssqueezepy"):
        return runs
    for threads in (False, True):
        for dtype in ("float32", "float64"):
            for padding in ("reflect", None):
                name = f"ssqueezepy, {dtype}, {padding or 'no'} padding, parallel {'on' if threads else 'off'}"
                for way, suffix in (("rows", ", row by row"), ("all", ""), ("kept", ", kept")):
                    runs[name + suffix] = _peer_run(signal, omega, dtype, padding, way, threads)
    return runs


def _peer_run(
    signal: Signal, omega: RealArray, dtype: str, padding: str | None, way: str, threads: bool
) -> Callable[[], Any]:
    """Return ssqueezepy's transform with a Morlet wavelet of the same shape."""
    package = importlib.import_module("ssqueezepy")
    # Its spectrum is exp(-(s w - mu)^2 / 2), ours exp(-N (s w - w0)^2 / 4).
    mu = CENTER * np.sqrt(BANDWIDTH / 2)
    with _parallel(threads):
        wavelet = package.Wavelet(("morlet", {"mu": mu, "dtype": dtype}))

    def run() -> Any:
        with _parallel(threads), silence():
            rows, _ = package.cwt(
                signal.values[0],
                wavelet,
                scales=mu / (omega * signal.step),
                padtype=padding,
                vectorized=way != "rows",
                cache_wavelet=way == "kept",
            )
        return rows

    return run


def accuracy_table(runs: Mapping[str, Callable[[], Any]], signal: Signal, omega: RealArray) -> str:
    """Return the table of errors against direct sums."""
    # The points where the rows of our default lie, so that all can be judged there.
    reference = next(iter(runs.values()))()
    points = list(_points(reference))
    exact = np.array([direct_sum(signal, omega[row], stride * i) for row, i, stride in points])
    # Divided by the root of the scale, a row of the paper's normalisation is that of the sum.
    root = np.sqrt(CENTER / omega)
    rms = np.array([np.sqrt(np.mean(np.abs(reference.rows[row]) ** 2)) / root[row] for row, _, _ in points])
    table = []
    for name, run in runs.items():
        if name.endswith(("row by row", "kept")) or "parallel on" in name:
            continue
        got = run()
        used = [True] * len(points)
        if isinstance(got, Scalogram):
            used = [i * stride % got.strides[row] == 0 for row, i, stride in points]
            where = [(row, i * stride // got.strides[row]) for row, i, stride in compress(points, used)]
            found = np.array([got.rows[row][0, i] / root[row] for row, i in where])
        else:
            found = np.array([got[row, i * stride] for row, i, stride in points], complex)
        factor = np.vdot(found, exact[used]).real / np.vdot(found, found).real
        error = np.max(np.abs(factor * found - exact[used]) / rms[used])
        table.append([name, f"{error:.0e}", sum(used)])
    return tabulate(table, headers=["transform", "largest error", "points"], tablefmt="github", disable_numparse=True)


def direct_sum(signal: Signal, omega: float, sample: int) -> complex:
    """Return ``s^-1 sum_n x(t_n) conj(psi((t_n - tau) / s)) h`` at one sample, summed directly."""
    scale = CENTER / omega
    elapsed = (np.arange(signal.values.shape[1]) - sample) * signal.step / scale
    wave: ComplexArray = np.exp(-1j * CENTER * elapsed - elapsed**2 / BANDWIDTH)
    return complex(np.sum(signal.values[0] * wave) * signal.step / scale)


def transforms_table(runs: Mapping[str, Callable[[], Any]], rounds: int) -> str:
    """Return the table of times of the transforms."""
    medians = _medians(runs, rounds, time.perf_counter)
    for name in [name for name in medians if name.endswith(", row by row")]:
        whole = name.removesuffix(", row by row")
        medians[whole] = min(medians[whole], medians.pop(name))
    ours, peers = list(medians)[:3], {name: v for name, v in medians.items() if name.startswith("ssqueezepy")}
    table = [
        [name, f"{1e3 * value:.0f}", *(f"{value / medians[base]:.2f}" for base in ours)]
        for name, value in medians.items()
    ]
    headers = ["transform", "ms", *(f"over suspid {base.split(', ')[2]}" for base in ours)]
    text = tabulate(table, headers=headers, tablefmt="github", disable_numparse=True)
    if not peers:
        return "ssqueezepy is not installed.\n\n" + text
    usual, best = peers[PEER_DEFAULT], min(peers, key=lambda name: peers[name])
    return (
        f"As both come ({PEER_DEFAULT}) ssqueezepy takes {usual / medians[ours[0]]:.1f} times as long as suspid, and "
        f"{usual / medians[ours[1]]:.1f} times as long as the transforms of the search for N; at its fastest ({best}) "
        f"{peers[best] / medians[ours[0]]:.1f} and {peers[best] / medians[ours[1]]:.1f} times.\n\n{text}"
    )


def _points(scalogram: Scalogram) -> Iterator[tuple[int, int, int]]:
    """Yield row, own sample and stride: up to eight points in each of a dozen rows clear of the ends."""
    # Near the Nyquist frequency the sum folds the wavelet's tail back, a spectrum that is cut there does not.
    below = scalogram.omega * scalogram.signal.step / np.pi < 0.7
    clear = [r for r in map(int, np.flatnonzero(below)) if np.any(scalogram.inside(r, cones=CLEAR))]
    for row in clear[:: max(1, len(clear) // 12)]:
        inside = np.flatnonzero(scalogram.inside(row, cones=CLEAR))
        for i in inside[:: max(1, len(inside) // 8)][:8]:
            yield row, int(i), scalogram.strides[row]


@contextmanager
def _parallel(on: bool) -> Iterator[None]:
    """Switch ssqueezepy's own threads on or off."""
    before = os.environ.get("SSQ_PARALLEL")
    os.environ["SSQ_PARALLEL"] = "1" if on else "0"
    try:
        yield
    finally:
        if before is None:
            del os.environ["SSQ_PARALLEL"]
        else:
            os.environ["SSQ_PARALLEL"] = before


def _medians(
    runs: Mapping[str, Callable[[], object]], rounds: int, clock: Callable[[], float] = time.process_time
) -> dict[str, float]:
    """Return the median seconds of each run, taken in turns after one round to warm up, by default of CPU time."""
    seconds: dict[str, list[float]] = {name: [] for name in runs}
    for _ in range(rounds + 1):
        for name, run in runs.items():
            start = clock()
            with silence():
                run()
            seconds[name].append(clock() - start)
    return {name: float(np.median(values[1:])) for name, values in seconds.items()}


def _ratios(medians: Mapping[str, float]) -> str:
    first = next(iter(medians.values()))
    rows = [[name, f"{1e3 * value:.1f}", f"{value / first:.2f}"] for name, value in medians.items()]
    return tabulate(rows, headers=["call", "ms", "over the first"], tablefmt="github", disable_numparse=True)
