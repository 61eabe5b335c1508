"""Free decay: time relative to python-control, error against fifty digits, memory."""

from __future__ import annotations

import statistics
import time
import tracemalloc
from collections.abc import Callable

import control
import mpmath
import numpy as np

from suspid import free_decay, quarter_car, statespace

SAMPLES = 200_000
STEP = 0.002
REPEATS = 5


def report() -> str:
    """Return the report of one run: times as a ratio, errors relative to the peak of each channel."""
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
    undamped = statespace(car.with_parameters(damping={"seat": 0, "chassis": 0, "tire": 0}))
    times, start = STEP * np.arange(SAMPLES), np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    # In turns, so that a busy machine slows both alike.
    pairs = [
        (
            _seconds(lambda: free_decay(system, times, initial_state=start)),
            _seconds(lambda: control.initial_response(system, times, start)),
        )
        for _ in range(REPEATS)
    ]
    ours, theirs = (statistics.median(column) for column in zip(*pairs, strict=True))
    tracemalloc.start()
    free_decay(system, times, initial_state=start)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return "\n".join(
        [
            f"Free decay, {SAMPLES} samples x 3 outputs, median of {REPEATS} runs taken in turn",
            f"  time, free_decay / control.initial_response: {ours / theirs:.4f} (asked: below 0.1)",
            f"  largest error against 50 digits, Table 1 with c = 300, 200, 100: {_error(system, times, start):.1e}",
            f"  the same without damping: {_error(undamped, times, start):.1e} (asked: below 1e-9)",
            f"  peak memory / size of the result: {peak / (3 * SAMPLES * 8):.2f}",
        ]
    )


def _seconds(call: Callable[[], object]) -> float:
    begin = time.perf_counter()
    call()
    return time.perf_counter() - begin


def _error(system: control.StateSpace, times: np.ndarray, start: np.ndarray) -> float:
    """Return the largest error at selected samples, relative to the peak of its channel."""
    found = free_decay(system, times, initial_state=start).y
    worst = 0.0
    for k in (1, 1000, 65_537, 131_072, SAMPLES - 1):
        with mpmath.workdps(50):
            exponent = mpmath.matrix(np.asarray(system.A).tolist()) * mpmath.mpf(float(times[k]))
            state = mpmath.expm(exponent, method="pade") * mpmath.matrix(start.tolist())
        expected = np.asarray(system.C) @ np.array([float(x) for x in state])
        worst = max(worst, float(np.max(np.abs(found[:, k] - expected) / np.max(np.abs(found), axis=1))))
    return worst


if __name__ == "__main__":
    print(report())
