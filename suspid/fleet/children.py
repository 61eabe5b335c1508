"""Worker processes on this machine: each analyses chunks of records, and its death costs one record at most.

A worker reads ``(job, chunk, known)`` from its standard input and writes `True` when its libraries are loaded and after
each record, then the tables of the chunk. The caller therefore knows which record a dead worker was busy with.
"""

from __future__ import annotations

import ctypes
import os
import pickle
import queue
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from typing import IO, TypeAlias

from suspid.errors import SuspidError
from suspid.fleet.failures import failure
from suspid.fleet.job import Job
from suspid.fleet.parts import Part
from suspid.fleet.records import Entry, Seen
from suspid.fleet.tables import Rows
from suspid.fleet.work import TIME_UP, check_versions, tables_of
from suspid.units import Second
from suspid.words import Failure, Remark, Step

# A process may die for a reason other than its record (the system was short of memory): one more try costs little.
RECORD_TRIES = 2
# BLAS threads of several workers would compete for the cores, and change the order of sums.
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS"), "1")

# How long a process may take beyond its own limits, on a machine that is busy with other things.
LATE_ANSWER: Second = 10.0

Process: TypeAlias = "subprocess.Popen[bytes]"


@dataclass(frozen=True, slots=True, eq=False)
class Children:
    """The worker processes of one run."""

    idle: queue.SimpleQueue[Process] = field(default_factory=queue.SimpleQueue)
    # All that were started and not seen to end.
    living: list[Process] = field(default_factory=list)
    # Those that were killed since a record took too long.
    overdue: list[Process] = field(default_factory=list)
    # Set when no more work is wanted.
    stopped: threading.Event = field(default_factory=threading.Event)


# The process of a worker of a cluster; it ends with that worker.
NEARBY_CHILDREN = Children()


def work_in_child(children: Children, job: Job, chunk: Sequence[Entry]) -> Part:
    """Return the tables of a chunk, made by a process of its own; a record that kills it is a failure.

    Raises
    ------
    SuspidError
        If workers end as they start.
    CancelledError
        If the run was stopped.
    ChildProcessError
        If a process does not outlive the making of the tables.
    """
    known: dict[int, Rows] = {}
    last, deaths = -1, 0
    while True:
        process = _idle(children)
        answer = _asked(children, process, job, chunk, known)
        if isinstance(answer, Part):
            children.idle.put(process)
            return answer
        code = _end(children, process)
        code = TIME_UP if process in children.overdue else code
        if children.stopped.is_set():
            raise CancelledError
        if answer in known:
            raise ChildProcessError(f"a process ends as it makes tables ({_how(code)})")
        deaths = deaths + 1 if answer == last else 1
        last = answer
        if deaths == RECORD_TRIES or code == TIME_UP:
            known[answer] = _death(job, chunk[answer], code)
            last, deaths = -1, 0


def work_apart(job: Job, chunk: Sequence[Entry]) -> Part:
    """Return the same as `work_in_child`, by a process that is started for this chunk alone."""
    check_versions(job)
    children = Children()
    try:
        return work_in_child(children, job, chunk)
    finally:
        close(children)


def work_nearby(job: Job, chunk: Sequence[Entry]) -> Part:
    """Return the same as `work_in_child`, by a process that stays with this one for further chunks."""
    check_versions(job)
    return work_in_child(NEARBY_CHILDREN, job, chunk)


def give_up(children: Children) -> None:
    """Kill all worker processes, whatever they are busy with."""
    children.stopped.set()
    for process in tuple(children.living):
        process.kill()


def close(children: Children) -> None:
    """End all worker processes."""
    give_up(children)
    for process in tuple(children.living):
        _end(children, process)


def child() -> None:
    """Be a worker process: answer chunks from standard input until it ends or the parent dies."""
    answers = os.fdopen(os.dup(1), "wb")
    # Output of libraries must not mix with the answers.
    os.dup2(2, 1)
    _end_with(os.getppid())
    _send(answers, True)
    while True:
        try:
            job, chunk, known = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        _send(answers, tables_of(job, chunk, known, done=lambda: _send(answers, True)))


def _idle(children: Children) -> Process:
    """Return a process that waits for a chunk: an idle one, or a new one."""
    try:
        return children.idle.get_nowait()
    except queue.Empty:
        pass
    for _ in range(RECORD_TRIES):
        process = _started()
        children.living.append(process)
        if children.stopped.is_set():
            raise CancelledError
        if _answer(process) is True:
            return process
        code = _end(children, process)
    raise SuspidError(
        f"a worker process ended as it started ({_how(code)}); to see why, run: "
        f"{sys.executable} -c 'import suspid.fleet.children'"
    )


def _started() -> Process:
    paths = os.pathsep.join(path for path in (os.environ.get("PYTHONPATH"), *sys.path) if path)
    return subprocess.Popen(
        [sys.executable, "-c", "from suspid.fleet.children import child; child()"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env={**os.environ, **ONE_THREAD, "PYTHONPATH": paths},
    )


def _asked(
    children: Children, process: Process, job: Job, chunk: Sequence[Entry], known: Mapping[int, Rows]
) -> Part | int:
    """Return the tables of a chunk, or the index of the record during which the process died."""
    assert process.stdin is not None
    try:
        _send(process.stdin, (job, tuple(chunk), dict(known)))
    except OSError:
        return 0
    if _answer(process) is None:
        return 0
    for k in range(len(chunk) + 1):
        # Tables take what libraries take to load; no record is to blame.
        with _killed_when_overdue(children, process, job.time_limit if k < len(chunk) else None):
            answer = _answer(process)
        if answer is not None and process in children.overdue:
            # It answered as it was killed: this record is done, and the next one is not to blame.
            children.overdue.remove(process)
        if isinstance(answer, Part):
            return answer
        if answer is None:
            # The last record also stands for the tables that follow it.
            return min(k, len(chunk) - 1)
    raise AssertionError("a worker answers a chunk with its tables")


@contextmanager
def _killed_when_overdue(children: Children, process: Process, limit: Second | None) -> Iterator[None]:
    """Kill a process that does not answer in time: native code may hold the interpreter and all inner limits."""
    if limit is None:
        yield
        return

    def kill() -> None:
        children.overdue.append(process)
        process.kill()

    timer = threading.Timer(2 * limit + LATE_ANSWER, kill)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def _answer(process: Process) -> object:
    """Return the next answer of a process; None if it died."""
    assert process.stdout is not None
    try:
        return pickle.load(process.stdout)
    except (EOFError, OSError, pickle.UnpicklingError):
        return None


def _end(children: Children, process: Process) -> int:
    """Close a process, wait for it and return its exit code."""
    for stream in (process.stdin, process.stdout):
        if stream is not None:
            try:
                stream.close()
            except OSError:
                # What was not sent to a dead process is sent to the next one.
                continue
    code = process.wait()
    if process in children.living:
        children.living.remove(process)
    return code


def _end_with(parent: int) -> None:
    """End this process soon after its parent, which may be killed without notice; Ctrl-C is left to the parent."""

    def watch() -> None:
        while os.getppid() == parent:
            # An orphan outlives a killed client by this much at most [s].
            time.sleep(1.0)
        os._exit(1)

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform == "linux":
        # The thread below cannot run where native code holds the interpreter; the system can.
        with suppress(OSError, AttributeError):
            # 1 is the request that a process be killed when its parent ends.
            ctypes.CDLL(None).prctl(1, int(signal.SIGKILL))
    if sys.platform != "win32":
        threading.Thread(target=watch, daemon=True).start()


def _send(stream: IO[bytes], message: object) -> None:
    """Write one message at once."""
    pickle.dump(message, stream)
    stream.flush()


def _death(job: Job, entry: Entry, code: int) -> Rows:
    why = Remark(Failure.WORKER_DIED, {"times": RECORD_TRIES, "how": _how(code)})
    if code == TIME_UP:
        why = Remark(Failure.TIME_NATIVE, {"limit": job.time_limit})
    return failure(job, entry, Seen(step=Step.WORK), why)


def _how(code: int) -> str:
    return f"signal {-code}" if code < 0 else f"exit code {code}"
