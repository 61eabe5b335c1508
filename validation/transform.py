"""Cost of the wavelet transform compared with other libraries, and errors of the ridges over the Cramér-Rao bound."""

from __future__ import annotations

import importlib
import importlib.util
import time
import tracemalloc
from collections.abc import Callable, Mapping

import numpy as np
from tabulate import tabulate

from suspid import ModalSet, SuspidError, add_noise, cwt, eigenmodes, free_decay, identify, quarter_car, statespace
from suspid.records import as_response
from suspid.signals import as_signal
from suspid.units import RealArray
from validation.bounds import cramer_rao, decay_amplitudes

ROWS, BANDWIDTH, CENTER = 100, 1.5, 2 * np.pi
# Longest record for the other libraries, which need memory for a hundred rows at full rate.
PEERS_UP_TO = 100_000
START = {"v_tire": 1.0}


def report(*, seeds: int = 100, lengths: tuple[int, ...] = (10_000, 100_000, 1_000_000)) -> str:
    """Return the whole report as markdown. Figures of cost are ratios within one run."""
    return "\n\n".join(["# The transform and its ridges", _cost(lengths), _ridges(seeds)]) + "\n"


def _cost(lengths: tuple[int, ...]) -> str:
    table = []
    first: tuple[float, float] | None = None
    for length in lengths:
        signal = np.random.default_rng(0).standard_normal(length)
        runs = _transforms(signal)
        if length > PEERS_UP_TO:
            runs = {name: run for name, run in runs.items() if name.startswith("suspid, own")}
        costs = {name: (_seconds(run), _peak_bytes(run)) for name, run in runs.items()}
        ours = costs["suspid, own rates"]
        first = first or ours
        for name, cost in costs.items():
            ratios = [f"{c / o:.1f}" for c, o in zip(cost, ours, strict=True)]
            growth = (
                [f"{o / f:.1f}" for o, f in zip(ours, first, strict=True)] if name == "suspid, own rates" else ["", ""]
            )
            table.append([f"{length:,}", name, *ratios, *growth])
    headers = ("samples", "transform", "time / ours", "memory / ours", "ours: time / first", "ours: memory / first")
    return (
        f"## Cost\n\n{ROWS} rows over five octaves, N = {BANDWIDTH}, w0 = 2 pi, white noise; least of three runs; "
        f"memory is the peak that Python traces.\n\n"
        + tabulate(table, headers=headers, tablefmt="github", disable_numparse=True)
    )


def _transforms(signal: RealArray) -> Mapping[str, Callable[[], object]]:
    import pywt

    response = as_response(np.arange(len(signal), dtype=float), signal[None], ("noise",))
    omega = 2.5 * 2.0 ** (-np.arange(ROWS) / 20)
    scales = CENTER / omega
    runs: dict[str, Callable[[], object]] = {
        "suspid, own rates": lambda: cwt(response, omega=omega, bandwidth=BANDWIDTH),
        "suspid, full rate": lambda: cwt(response, omega=omega, bandwidth=BANDWIDTH, full_rate=True),
        "pywt, fft": lambda: pywt.cwt(signal, scales, f"cmor{BANDWIDTH}-1.0", method="fft"),
        "pywt, default": lambda: pywt.cwt(signal, scales, f"cmor{BANDWIDTH}-1.0"),
    }
    if importlib.util.find_spec("ssqueezepy"):
        ssqueezepy = importlib.import_module("ssqueezepy")

        runs["ssqueezepy"] = lambda: ssqueezepy.cwt(signal, ("morlet", {"mu": 5.13}), scales=scales)
    return runs


def _seconds(run: Callable[[], object]) -> float:
    """Return the least time of three runs."""
    times = []
    for _ in range(3):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return min(times)


def _peak_bytes(run: Callable[[], object]) -> float:
    tracemalloc.start()
    try:
        run()
        return float(tracemalloc.get_traced_memory()[1])
    finally:
        tracemalloc.stop()


def _ridges(seeds: int) -> str:
    car = quarter_car(
        seat_mass=200,
        chassis_mass=200,
        tire_mass=200,
        seat_stiffness=200e3,
        chassis_stiffness=400e3,
        tire_stiffness=800e3,
        seat_damping=300,
        chassis_damping=200,
        tire_damping=100,
    )
    system = statespace(car)
    truth, time_points = eigenmodes(car), np.arange(5000) / 500
    record = as_signal(free_decay(car, time_points, initial_state=START))
    table = []
    for channels in (("tire",), ("seat", "chassis", "tire")):
        picked = [record.channels.index(name) for name in channels]
        clean = record.values[picked]
        response = as_response(time_points, clean, channels)
        std = np.sqrt(np.mean(clean**2, axis=1) * 10**-2.0)
        poles, amplitudes = decay_amplitudes(system, [START.get(name, 0.0) for name in system.state_labels])
        bound = cramer_rao(poles, amplitudes[picked], time_points, noise_std=std)
        errors, deviates, lost = [], [], 0
        for seed in range(seeds):
            noisy = add_noise(response, snr_db=20.0, rng=np.random.default_rng(seed))
            try:
                found = identify(noisy, modes=3, method="ridge").modes
            except SuspidError:
                lost += 1
                continue
            error = _errors(found, truth)
            errors.append(error)
            deviates.append(error / np.stack([np.asarray(found.wn_std), np.asarray(found.zeta_std)]))
        over = np.sqrt(np.mean(np.square(errors), axis=0)) / np.stack([bound.wn_std, bound.zeta_std])
        own = np.sqrt(np.mean(np.square(deviates), axis=0))
        for mode in range(3):
            ratios = [f"{x:.2f}" for x in (over[0, mode], over[1, mode], own[0, mode], own[1, mode])]
            table.append([", ".join(channels), f"{truth.wn[mode]:.3f}", *ratios, f"{lost} of {seeds}"])
    headers = ("channels", "mode [rad/s]", "wn: RMSE / bound", "zeta", "wn: RMSE / its own std", "zeta", "lost")
    return f"## Ridges at 20 dB, {seeds} seeds\n\n" + tabulate(
        table, headers=headers, tablefmt="github", disable_numparse=True
    )


def _errors(found: ModalSet, truth: ModalSet) -> RealArray:
    return np.stack([found.wn - truth.wn, found.zeta - truth.zeta])
