"""The workers of a fleet: processes on this machine, or a Dask cluster."""

from __future__ import annotations

import importlib
import os
import re
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from suspid.errors import InputError, SuspidError
from suspid.files import printable
from suspid.fleet.children import Children, close, give_up, work_apart, work_in_child, work_nearby
from suspid.fleet.engine import ASK, CLUSTER_LOST, Engine
from suspid.fleet.job import Job
from suspid.fleet.manifest import INSTALL
from suspid.fleet.parts import Part
from suspid.fleet.records import Entry
from suspid.fleet.work import work
from suspid.units import Second

if TYPE_CHECKING:
    from distributed import Client

# How long to wait for the scheduler to answer and for the first worker: a queue of jobs may start workers late.
FIRST_WORKER: Second = 60.0


@contextmanager
def local_engine(workers: int | None) -> Iterator[Engine]:
    """Give worker processes on this machine, one for each core by default; a thread waits for each."""
    if workers is not None and (isinstance(workers, bool) or not isinstance(workers, int) or workers < 1):
        raise InputError(f"{workers=} must be a number of processes, 1 or more")
    # The cores that this process may use, where the system tells.
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    number = workers or cores or 1
    children, threads = Children(), ThreadPoolExecutor(number, thread_name_prefix="suspid-fleet")

    def stop(now: bool) -> None:
        if now:
            give_up(children)
        threads.shutdown(wait=True, cancel_futures=now)
        close(children)

    yield Engine(
        submit=lambda job, chunk, _: threads.submit(work_in_child, children, job, chunk),
        stop=stop,
        workers=lambda: number,
        alive=lambda: True,
    )


@contextmanager
def dask_engine(scheduler: str | Client) -> Iterator[Engine]:
    """Give the workers of a Dask cluster, by the address of its scheduler or a client that is connected."""
    try:
        connect: Any = importlib.import_module("distributed").Client
    except ImportError:
        raise InputError(f"a cluster needs dask.distributed: {INSTALL}") from None
    if not isinstance(scheduler, (str, connect)):
        raise InputError(f"{scheduler=!r:.80} must be the address of a Dask scheduler or a dask.distributed.Client")
    client: Any = _connected(connect, scheduler) if isinstance(scheduler, str) else scheduler
    try:
        with _lost():
            try:
                client.wait_for_workers(1, timeout=FIRST_WORKER)
            except TimeoutError:
                raise InputError(f"the cluster has no worker, and none came within {FIRST_WORKER:g} s") from None
        yield _engine_of(client)
    finally:
        if client is not scheduler:
            client.close()


def _connected(connect: Any, address: str) -> object:
    # A client that has no port to call waits for minutes when it is closed.
    if not re.search(r":\d+/?$", address) and not address.startswith("inproc"):
        raise InputError(f"{printable(address)}: the address of a Dask scheduler has a port, such as tcp://HOST:8786")
    try:
        return connect(address, set_as_default=False, timeout=FIRST_WORKER)
    except (OSError, ValueError, TimeoutError) as refusal:
        raise InputError(f"{printable(address)}: no Dask scheduler answers: {printable(str(refusal))}") from None


def _engine_of(client: Any) -> Engine:
    with _lost():
        threads = client.nthreads()
    asked = [time.monotonic(), float(sum(threads.values()))]
    pool = client.get_executor(pure=False)

    def workers() -> int:
        # The cluster may grow and shrink.
        if time.monotonic() - asked[0] > ASK:
            with _lost():
                asked[:] = time.monotonic(), float(sum(client.nthreads().values()))
        return max(1, int(asked[1]))

    note = ""
    if max(threads.values()) > 1:
        note = (
            f"workers have up to {max(threads.values())} threads, but a process takes one record at a time: start "
            f"them with --nthreads 1 and one process per core"
        )
    return Engine(
        submit=lambda job, chunk, died: pool.submit(_way(job, died=died), job, chunk),
        stop=lambda now: pool.shutdown(wait=not now),
        workers=workers,
        alive=lambda: client.status == "running",
        note=note,
    )


def _way(job: Job, *, died: bool) -> Callable[[Job, tuple[Entry, ...]], Part]:
    """Return how a worker of a cluster does a chunk: with a time limit by another process, which can be ended."""
    if died:
        return work_apart
    return work if job.time_limit is None else work_nearby


@contextmanager
def _lost() -> Iterator[None]:
    """Say that the cluster is lost, however its library says so."""
    try:
        yield
    except SuspidError:
        raise
    # What a scheduler that dies raises depends on what the client was waiting for.
    except Exception as refusal:
        raise SuspidError(CLUSTER_LOST) from refusal
