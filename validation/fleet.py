"""Cost of a fleet: against a plain loop, with one worker and two, on Dask, against the number of records."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from tabulate import tabulate

from suspid import add_noise, free_decay, statespace, write_record
from validation import cars

RECORDS, GROWTH, ON_DASK = 2000, (100, 1000, 10_000), 1000
SAMPLES, RATE, SNR_DB = 2000, 500.0, 20.0
# Records that are made; larger fleets are hard links to them.
MADE = 1000
THREADS = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}

# Every run is a process of its own, from its start to its end: imports count, and memory is its own.
PLAIN = """
import os
from suspid import analyse

for name in sorted(os.listdir(folder)):
    analyse(os.path.join(folder, name)).verdict
"""
FLEET = """
from suspid.fleet import identify_many

run = identify_many(folder, output=output, workers=workers)
assert run.records == len(os.listdir(folder)) and not run.failed
"""
DASK = """
from distributed import LocalCluster
from suspid.fleet import identify_many

with LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster:
    run = identify_many(folder, output=output, scheduler=cluster.scheduler_address)
assert run.records == len(os.listdir(folder)) and not run.failed
"""
FRAME = """
import json, os, resource, sys, time

start = time.perf_counter()
folder, output, workers = sys.argv[1], sys.argv[2], int(sys.argv[3])
{body}
# The kernel's mark of this program alone; that of getrusage remembers the one that started it.
marks = [line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM")]
own, others = resource.getrusage(resource.RUSAGE_SELF), resource.getrusage(resource.RUSAGE_CHILDREN)
print(json.dumps({{
    "wall": time.perf_counter() - start,
    "cpu": own.ru_utime + own.ru_stime + others.ru_utime + others.ru_stime,
    "client": float(marks[0]) / 1024,
    "worker": others.ru_maxrss / 1024,
}}))
"""


@dataclass(frozen=True, kw_only=True, slots=True)
class Cost:
    """What one run took.

    Parameters
    ----------
    wall, cpu : float
        Seconds from start to end, and of all processors together.
    client, worker : float
        Peak memory of the process itself and of its largest child [MiB].
    parts, size : int
        Files of the table of modes that it left, and bytes of all results.
    """

    wall: float
    cpu: float
    client: float
    worker: float
    parts: int
    size: int


def report(*, records: int = RECORDS, growth: Sequence[int] = GROWTH, on_dask: int = ON_DASK) -> str:
    """Return the report as markdown."""
    with tempfile.TemporaryDirectory(prefix="suspid-fleet-") as scratch:
        made = make_records(Path(scratch, "made"), min(MADE, max(records, *growth)))
        folder = named(made, Path(scratch, "records"), records)
        plain = measured(PLAIN, folder, Path(scratch, "plain"))
        one = measured(FLEET, folder, Path(scratch, "one"), workers=1)
        two = measured(FLEET, folder, Path(scratch, "two"), workers=2)
        same = digest(Path(scratch, "one")) == digest(Path(scratch, "two"))
        few = named(made, Path(scratch, "few"), on_dask)
        dask = measured(DASK, few, Path(scratch, "dask"), workers=2)
        grown = {
            count: measured(
                FLEET, named(made, Path(scratch, f"in {count}"), count), Path(scratch, f"out {count}"), workers=2
            )
            for count in growth
        }
        record_bytes = sum(path.stat().st_size for path in made) / len(made)
    return (
        "\n\n".join(
            [
                "# Fleets",
                f"{records} records of seat-in-car models drawn from what is on the road, three channels, {SAMPLES} "
                f"samples "
                f"at {RATE:g} Hz, {SNR_DB:g} dB, Parquet. Every run is a process of its own, timed from its start "
                f"to its end "
                f"(imports and the start of workers count); BLAS has one thread. {os.cpu_count()} processors.",
                "## Beside a plain loop, and with two workers",
                "The plain loop calls `analyse(path).verdict` and keeps nothing. Processor time is that of "
                "all processes "
                "together: it is what work costs where other programs load the machine.",
                workers_table(records, plain, one, two, on_dask, dask),
                f"Two workers are {one.wall / two.wall:.2f} times as fast as one; one costs "
                f"{one.wall / plain.wall:.2f} times the "
                f"plain loop ({one.cpu / plain.cpu:.2f} times its processor time). The files of one worker and of "
                f"two are "
                f"{'the same, byte by byte' if same else 'NOT the same'}.",
                "## Against the number of records, two workers",
                growth_table(grown),
                memory_text(grown),
                "## Ten million records, on paper",
                estimate(records, one, grown, record_bytes),
            ]
        )
        + "\n"
    )


def make_records(folder: Path, count: int) -> list[Path]:
    """Write records of mixed cars; return the files."""
    folder.mkdir()
    rng = np.random.default_rng(6)
    timepts = np.arange(SAMPLES) / RATE
    paths = []
    for k in range(count):
        decay = free_decay(statespace(cars.random_car(rng)), timepts, initial_state={"v_tire": 1.0})
        paths.append(folder / f"{k:05d}.parquet")
        write_record(add_noise(decay, snr_db=SNR_DB, rng=rng), paths[-1])
    return paths


def named(made: Sequence[Path], folder: Path, count: int) -> Path:
    """Return a folder with ``count`` names of the records that were made."""
    folder.mkdir()
    for k in range(count):
        os.link(made[k % len(made)], folder / f"{k:06d}.parquet")
    return folder


def measured(body: str, folder: Path, output: Path, *, workers: int = 1) -> Cost:
    """Return what a run cost."""
    command = [sys.executable, "-c", FRAME.format(body=body), str(folder), str(output), str(workers)]
    done = subprocess.run(command, env={**os.environ, **THREADS}, check=True, capture_output=True, text=True)
    said = json.loads(done.stdout.splitlines()[-1])
    files = list(output.rglob("part-*.parquet"))
    parts = sum(path.parent.name == "modes" for path in files)
    return Cost(**said, parts=parts, size=sum(path.stat().st_size for path in files))


def digest(output: Path) -> str:
    """Return the sha256 of all tables."""
    content = hashlib.sha256()
    for path in sorted(output.rglob("part-*.parquet")):
        content.update(str(path.relative_to(output)).encode() + path.read_bytes())
    return content.hexdigest()


def workers_table(records: int, plain: Cost, one: Cost, two: Cost, on_dask: int, dask: Cost) -> str:
    """Return times and rates of the four ways."""
    rows = [
        [name, count, f"{cost.wall:.1f}", f"{count / cost.wall:.1f}", f"{count / cost.cpu:.1f}", ratio]
        for name, count, cost, ratio in (
            ("plain loop", records, plain, "1"),
            ("1 worker", records, one, f"{plain.wall / one.wall:.2f}"),
            ("2 workers", records, two, f"{plain.wall / two.wall:.2f}"),
            ("2 workers of a Dask cluster", on_dask, dask, f"{plain.wall / records / (dask.wall / on_dask):.2f}"),
        )
    ]
    headers = ["", "records", "s", "records/s", "records per s of a processor", "times as fast"]
    return tabulate(rows, headers=headers, tablefmt="github", disable_numparse=True)


def growth_table(grown: dict[int, Cost]) -> str:
    """Return what a record costs in fleets of several sizes."""
    rows = [
        [
            f"{count:,}",
            f"{cost.wall:.1f}",
            f"{1e3 * cost.wall / count:.1f}",
            f"{1e3 * cost.cpu / count:.1f}",
            f"{cost.client:.0f}",
            f"{cost.worker:.0f}",
            cost.parts,
            f"{cost.size / count:.0f}",
        ]
        for count, cost in grown.items()
    ]
    headers = ["records", "s", "ms per record", "processor ms per record", "client peak MiB", "worker peak MiB"]
    return tabulate(
        rows, headers=[*headers, "parts", "bytes of results per record"], tablefmt="github", disable_numparse=True
    )


def memory_text(grown: dict[int, Cost]) -> str:
    """Return how peak memory grows from the last but one fleet to the last."""
    if len(grown) < 2:
        return "One size alone: growth was not measured."
    (few, less), (many, more) = list(grown.items())[-2:]
    return (
        f"From {few:,} to {many:,} records the peak of the client grows by "
        f"{100 * (more.client / less.client - 1):.1f} %, "
        f"that of the largest worker by {100 * (more.worker / less.worker - 1):.1f} %."
    )


def estimate(records: int, one: Cost, grown: dict[int, Cost], record_bytes: float) -> str:
    """Return what ten million records would take on a cluster, with every assumption."""
    many, last = list(grown.items())[-1]
    per_core = records / one.cpu
    count, cores, chunk = 10_000_000, 256, 1000
    hours = count / per_core / 3600
    minutes = 60 * hours / cores
    return "\n".join(
        [
            f"- Work: {per_core:.0f} records per second and core (1 worker above) make {hours:.0f} core hours; on "
            f"{cores} such "
            f"cores {minutes:.0f} minutes. With a car or with long records more, in proportion.",
            f"- Scheduler: with `chunk={chunk}` there are {count // chunk:,} tasks of {chunk / per_core:.0f} s. "
            f"Assumed is 1 ms of "
            f"Dask's scheduler per task: {count // chunk / 1000:.0f} s in all, never the bottleneck; with the "
            f"default of 32 "
            f"records it would be {count / 32 / 1000 / 60:.0f} minutes, still hidden behind the work.",
            f"- Client: it alone writes. {last.size / many:.0f} bytes per record make "
            f"{count * last.size / many / 1e9:.1f} GB in "
            f"{count // chunk:,} parts; assumed are 20 ms of write and sync per part: "
            f"{count // chunk * 0.02 / 60:.0f} minutes, "
            f"beside the work. The list of records is a file of about 1 GB, read as the work goes; one folder's names "
            "are held at a time, so ten million belong into many folders (or an object store whose listing fits "
            f"memory: "
            f"about 3 GB).",
            f"- Store: {record_bytes / 1e3:.0f} kB per record are {count * record_bytes / 1e12:.1f} TB; to keep "
            f"{cores} cores "
            f"busy it must give {cores * per_core * record_bytes / 1e6:.0f} MB/s, and answer {cores * per_core:.0f} "
            f"requests "
            f"a second.",
            "- Start and end: imports of 2 s per worker; at the end the last tasks leave cores idle for "
            f"{chunk / per_core:.0f} s "
            f"at most. Assumed is one kind of processor: on several, results agree to rounding, not byte by byte.",
            "- A lost worker costs its chunk once more; a lost client nothing but the chunks under way.",
        ]
    )
