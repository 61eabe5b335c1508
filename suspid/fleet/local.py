"""The cores of this machine as workers of a fleet."""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

from suspid.errors import InputError
from suspid.fleet.children import Children, close, give_up, work_in_child
from suspid.fleet.engine import Engine


@contextmanager
def local_engine(workers: int | None) -> Iterator[Engine]:
    """Give worker processes on this machine, each minded by a thread that waits for it.

    Parameters
    ----------
    workers : int or None
        How many; None takes one for each core that this process may use.
    """
    if workers is not None and (isinstance(workers, bool) or not isinstance(workers, int) or workers < 1):
        raise InputError(f"{workers=} must be a number of processes, 1 or more")
    number = workers or cores()
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


def cores() -> int:
    """Return how many cores this process may use.

    Examples
    --------
    >>> cores() >= 1
    True
    """
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
