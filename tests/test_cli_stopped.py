"""Commands that a signal stops, or whose output has no room, end in one line."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import click
import numpy as np
import pytest
from click.testing import CliRunner

from suspid.cli import start
from suspid.cli.commands import Commands


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_ends_in_one_line_and_the_code_of_shells(number: signal.Signals, code: int) -> None:
    # A shell that starts tests in the background makes them deaf to Ctrl-C.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    left = []

    @click.command("waits")
    def waits() -> None:
        try:
            os.kill(os.getpid(), number)
            time.sleep(5)
        finally:
            left.append("cleaned up")

    try:
        told = CliRunner().invoke(Commands("suspid", commands=[waits]), ["waits"])
    finally:
        signal.signal(signal.SIGINT, before)
    assert (told.exit_code, told.stderr, left) == (code, "suspid: stopped\n", ["cleaned up"])
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is full")
def test_help_that_finds_no_room_is_one_line() -> None:
    with open("/dev/full", "w", encoding="utf-8") as full:
        command = [sys.executable, "-m", "suspid", "fleet", "--help"]
        told = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert told.returncode == 1
    assert told.stderr == "suspid: error: the output cannot be written: No space left on device\n"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is full")
def test_a_result_that_finds_no_room_is_one_line(tmp_path: Path) -> None:
    t = np.arange(400) / 100
    path = tmp_path / "r.csv"
    np.savetxt(path, np.column_stack([t, np.exp(-t) * np.cos(20 * t)]), "%.6g", ",", header="t,seat", comments="")
    with open("/dev/full", "w", encoding="utf-8") as full:
        command = [sys.executable, "-m", "suspid", "identify", str(path), "--json", "-"]
        told = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert told.returncode == 1
    assert told.stderr.splitlines()[-1] == "suspid: error: the output cannot be written: No space left on device"
    assert "Traceback" not in told.stderr


def test_ctrl_c_during_the_imports_is_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    class Stopping:
        def find_spec(self, name: str, *_: object) -> None:
            if name == "suspid.cli":
                raise KeyboardInterrupt

    monkeypatch.delitem(sys.modules, "suspid.cli")
    monkeypatch.setattr(sys, "meta_path", [Stopping(), *sys.meta_path])
    with pytest.raises(SystemExit) as told:
        start.main()
    assert (told.value.code, capsys.readouterr().err) == (130, "suspid: stopped\n")
