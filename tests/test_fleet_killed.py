"""Fleets that are killed with signal 9 half way: started again, the files are those of a run that was not."""

from __future__ import annotations

import importlib
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from fleets import CAR, content, make_fleet, parts, time_limit

from suspid import InputError, SuspidError, write_car
from suspid.fleet.identify_many import identify_many

pytestmark = pytest.mark.slow

COUNT, CHUNK = 32, 2
# Every wait for another process ends after this time [s].
LONG_ENOUGH = 900.0
psutil: Any = importlib.import_module("psutil")
CLIENT = """
import sys
from suspid import identify_many, read_car

folder, output, car, chunk, scheduler = sys.argv[1:]
who = {"scheduler": scheduler} if scheduler else {"workers": 2}
identify_many(folder, output=output, car=read_car(car), chunk=int(chunk), **who)
"""


@pytest.fixture(autouse=True)
def limited() -> Iterator[None]:
    with time_limit():
        yield


@pytest.fixture(scope="module")
def fleet(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fleet")
    write_car(CAR, folder / "car.toml")
    return make_fleet(folder / "in", COUNT)


@pytest.fixture(scope="module")
def expected(fleet: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    output = tmp_path_factory.mktemp("whole")
    run = identify_many(fleet, output=output, workers=2, car=CAR, chunk=CHUNK)
    assert (run.records, run.failed) == (COUNT, 0)
    return content(output)


def start(fleet: Path, output: Path, scheduler: str = "") -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-c", CLIENT, str(fleet), str(output), str(fleet.parent / "car.toml"), str(CHUNK), scheduler]
    )


def until(condition: Any, what: str) -> None:
    end = time.monotonic() + LONG_ENOUGH
    while not condition():
        assert time.monotonic() < end, f"in {LONG_ENOUGH:g} s it did not come to {what}"
        time.sleep(0.01)


def half_way(output: Path) -> None:
    until(lambda: parts(output) >= 4, "a fourth part")


def connected(address: str) -> Any:
    import distributed

    connect: Any = distributed.Client
    return connect(address, timeout=LONG_ENOUGH, set_as_default=False)


@dataclass(frozen=True)
class Cluster:
    """A Dask cluster of separate processes, as on several machines."""

    address: str
    scheduler: subprocess.Popen[bytes]
    workers: tuple[subprocess.Popen[bytes], ...]


@contextmanager
def cluster(*, nanny: bool) -> Iterator[Cluster]:
    """Start a Dask scheduler and two workers."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    address = f"tcp://127.0.0.1:{port}"
    dask = [sys.executable, "-m", "distributed.cli.dask_scheduler"]
    started: list[subprocess.Popen[bytes]] = []

    def run(*command: str) -> subprocess.Popen[bytes]:
        started.append(
            subprocess.Popen(
                list(command), stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
            )
        )
        return started[-1]

    try:
        scheduler = run(*dask, "--host", "127.0.0.1", "--port", str(port), "--no-dashboard", "--no-show")
        module = "distributed.cli.dask_worker"
        options = ["--nthreads", "1", "--no-dashboard", "--nanny" if nanny else "--no-nanny"]
        workers = tuple(run(sys.executable, "-m", module, address, *options) for _ in range(2))
        with connected(address) as client:
            client.wait_for_workers(2, timeout=LONG_ENOUGH)
        yield Cluster(address, scheduler, workers)
    finally:
        for process in started:
            for child in psutil.Process(process.pid).children(recursive=True) if process.poll() is None else []:
                child.kill()
            process.kill()
            process.wait(timeout=LONG_ENOUGH)


class TestKilledOnThisMachine:
    def test_the_client(self, fleet: Path, expected: dict[str, bytes], tmp_path: Path) -> None:
        process = start(fleet, tmp_path)
        half_way(tmp_path)
        workers = psutil.Process(process.pid).children(recursive=True)
        os.kill(process.pid, signal.SIGKILL)
        assert process.wait(timeout=LONG_ENOUGH) == -signal.SIGKILL
        done = parts(tmp_path)
        assert 4 <= done < COUNT // CHUNK, "it was not killed half way"
        # Whoever worked for it leaves: nobody is to work for a client that is no more.
        until(lambda: not any(w.is_running() and w.status() != psutil.STATUS_ZOMBIE for w in workers), "an end of them")
        run = identify_many(fleet, output=tmp_path, workers=1, car=CAR, chunk=CHUNK)
        assert (run.records, run.failed, run.kept) == (COUNT, 0, CHUNK * done)
        assert content(tmp_path) == expected

    @pytest.mark.parametrize(("number", "exit_code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
    def test_stopped_by_hand(
        self, fleet: Path, expected: dict[str, bytes], tmp_path: Path, number: signal.Signals, exit_code: int
    ) -> None:
        # A shell that starts these tests in the background makes their processes deaf to Ctrl-C; this one listens.
        listen = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
        code = f"{listen}; from suspid.cli import main; main()"
        command = [sys.executable, "-c", code, "fleet", str(fleet)]
        command += ["-o", str(tmp_path), "--car", str(fleet.parent / "car.toml"), "--chunk", str(CHUNK)]
        # Ctrl-C goes to everybody in the foreground: client and workers alike.
        process = subprocess.Popen(command, stderr=subprocess.PIPE, start_new_session=True)
        half_way(tmp_path)
        workers = psutil.Process(process.pid).children(recursive=True)
        os.killpg(process.pid, number) if number == signal.SIGINT else os.kill(process.pid, number)
        _, said = process.communicate(timeout=LONG_ENOUGH)
        assert process.returncode == exit_code
        assert workers
        assert not any(worker.is_running() for worker in workers)
        assert said.decode().splitlines() == [
            "suspid: stopped; the results so far are kept, and the same command continues"
        ]
        assert 4 <= parts(tmp_path) < COUNT // CHUNK, "it was not stopped half way"
        identify_many(fleet, output=tmp_path, car=CAR, workers=2, chunk=CHUNK)
        assert content(tmp_path) == expected

    def test_again_and_again(self, fleet: Path, expected: dict[str, bytes], tmp_path: Path) -> None:
        for more in range(1, 3):
            process = start(fleet, tmp_path)
            until(lambda more=more: parts(tmp_path) >= more, "another part")
            os.kill(process.pid, signal.SIGKILL)
            process.wait(timeout=LONG_ENOUGH)
        assert identify_many(fleet, output=tmp_path, workers=2, car=CAR, chunk=CHUNK).kept >= 2 * CHUNK
        assert content(tmp_path) == expected

    def test_a_worker(self, fleet: Path, expected: dict[str, bytes], tmp_path: Path) -> None:
        process = start(fleet, tmp_path)
        half_way(tmp_path)
        workers = psutil.Process(process.pid).children()
        assert len(workers) == 2
        os.kill(workers[0].pid, signal.SIGKILL)
        assert parts(tmp_path) < COUNT // CHUNK, "it was not killed half way"
        assert process.wait(timeout=LONG_ENOUGH) == 0
        assert content(tmp_path) == expected


class TestDask:
    def test_a_worker_is_killed(self, fleet: Path, expected: dict[str, bytes], tmp_path: Path) -> None:
        with cluster(nanny=False) as dask:
            process = start(fleet, tmp_path, dask.address)
            half_way(tmp_path)
            dask.workers[0].kill()
            assert parts(tmp_path) < COUNT // CHUNK, "it was not killed half way"
            assert process.wait(timeout=LONG_ENOUGH) == 0
            assert dask.workers[1].poll() is None
        assert content(tmp_path) == expected

    def test_the_client_is_killed(self, fleet: Path, expected: dict[str, bytes], tmp_path: Path) -> None:
        with cluster(nanny=True) as dask:
            process = start(fleet, tmp_path, dask.address)
            half_way(tmp_path)
            os.kill(process.pid, signal.SIGKILL)
            process.wait(timeout=LONG_ENOUGH)
            done = parts(tmp_path)
            assert 4 <= done < COUNT // CHUNK, "it was not killed half way"
            with connected(dask.address) as client:
                run = identify_many(fleet, output=tmp_path, scheduler=client, car=CAR, chunk=CHUNK)
            assert (run.records, run.failed, run.kept) == (COUNT, 0, CHUNK * done)
        assert content(tmp_path) == expected

    def test_the_scheduler_is_killed(self, fleet: Path, expected: dict[str, bytes], tmp_path: Path) -> None:
        with cluster(nanny=False) as dask:

            def kill(done: int, *_: object) -> None:
                if done == 4 * CHUNK:
                    dask.scheduler.kill()

            with pytest.raises(SuspidError, match="the cluster was lost; .* the same command continues"):
                identify_many(fleet, output=tmp_path, scheduler=dask.address, car=CAR, chunk=CHUNK, progress=kill)
        assert 4 <= parts(tmp_path) < COUNT // CHUNK
        identify_many(fleet, output=tmp_path, workers=2, car=CAR, chunk=CHUNK)
        assert content(tmp_path) == expected

    def test_nobody_answers(self, fleet: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr("suspid.fleet.workers.FIRST_WORKER", 0.5)
        with pytest.raises(InputError, match="no Dask scheduler answers"):
            identify_many(fleet, output=tmp_path, scheduler="tcp://127.0.0.1:9")
