"""Small fleets on disk: records of known cars, and what a run left."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from suspid import Suspension, add_noise, free_decay, quarter_car, write_record
from suspid.fleet.engine import Engine
from suspid.fleet.work import work

CAR = quarter_car(
    chassis_mass=400, tire_mass=40, chassis_stiffness=20e3, tire_stiffness=200e3, chassis_damping=1500, tire_damping=50
)


# A limit against hanging, far above what a test needs on a busy machine [s].
LONGEST_TEST = 1800.0


@contextmanager
def time_limit(seconds: float = LONGEST_TEST) -> Iterator[None]:
    """Raise `TimeoutError` in a test that hangs, where the system has alarms."""

    def ring(*_: object) -> None:
        raise TimeoutError(f"the test took longer than {seconds:g} s")

    if not hasattr(signal, "setitimer"):
        yield
        return
    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def write_decay(path: Path, seed: int, *, car: Suspension = CAR, samples: int = 300) -> None:
    """Write a record of a car at 100 Hz with noise of 30 dB; five digits, as a logger would."""
    rng = np.random.default_rng(seed)
    decay = free_decay(car, np.arange(samples) / 100, initial_state={"v_tire": 1.0, "v_chassis": 0.5})
    write_record(add_noise(decay, snr_db=30.0, rng=rng), path, digits=5)


def make_fleet(folder: Path, count: int, *, samples: int = 300) -> Path:
    """Write records into a folder, some of them below it."""
    (folder / "north").mkdir(parents=True)
    for k in range(count):
        write_decay(folder / ("north" if k % 3 else ".") / f"run{k:03d}.csv", k, samples=samples)
    return folder


def content(folder: Path) -> dict[str, bytes]:
    """Return every file of a folder of results, drafts and all, by its name."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def parts(folder: Path) -> int:
    """Return how many chunks are complete."""
    return len(list((folder / "modes").glob("part-*.parquet")))


@contextmanager
def own_process(workers: int | None) -> Iterator[Engine]:
    """Do the work in this process: what is tested is what becomes of it."""
    assert workers is None
    pool = ThreadPoolExecutor(1)
    yield Engine(
        submit=lambda job, chunk, _: pool.submit(work, job, chunk),
        stop=lambda now: pool.shutdown(wait=True, cancel_futures=now),
        workers=lambda: 1,
        alive=lambda: True,
    )
