"""Exports of TwinCAT Scope."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from suspid import analyse, read_recording
from suspid.io.text.twincat import with_scope_names

FIRST = 133327233574060000


def text(*names: str, mark: str = ",", step_ms: int = 5, rows: int = 900, project: str = "Scope Project1") -> str:
    """Two oscillations a second that die away, in counts."""

    def pairs(label: str, *values: object) -> str:
        return mark.join(f"{label}{mark}{value}" for value in values)

    time = step_ms / 1000 * np.arange(rows)
    swing = np.round(9000 * np.exp(-0.4 * time) * np.cos(12 * time)).astype(int)
    head = [
        f"Name{mark}{project}{mark}", f"Starttime of export{mark}{FIRST}{mark}Sonntag{mark} 2. Juli 2023", "", "",
        pairs("Name", *names), pairs("Data-Type", *["INT32"] * len(names)),
        pairs("SampleTime[ms]", *[step_ms] * len(names)), pairs("Unit", *["(None)"] * len(names)),
        pairs("Unit Offset", *[0] * len(names)), "",
    ]  # fmt: skip
    lines = [
        mark.join(f"{FIRST + 10_000 * step_ms * k}{mark}{value + n}" for n in range(len(names)))
        for k, value in enumerate(swing)
    ]
    return "\n".join([*head, *lines, ""])


@pytest.mark.parametrize("mark", [",", ";", "\t"])
@pytest.mark.parametrize("names", [("seat",), ("seat", "tire", "body")])
def test_channels_have_names_and_times(tmp_path: Path, mark: str, names: tuple[str, ...]) -> None:
    (tmp_path / "s.csv").write_text(text(*names, mark=mark), encoding="utf-8")
    found = read_recording(tmp_path / "s.csv")
    assert found.names == names
    assert found[names[-1]].values[0] == 9000 + len(names) - 1
    np.testing.assert_allclose(np.diff(found[names[-1]].timepts), 0.005, atol=1e-5)
    assert "lines 1 to 9" in dict(found.left_out)


def test_the_first_command_finds_the_mode(tmp_path: Path) -> None:
    (tmp_path / "s.csv").write_text(text("seat", "tire"), encoding="utf-8")
    found = analyse(tmp_path / "s.csv")
    assert found.modes.wn[0] == pytest.approx(np.hypot(12, 0.4), rel=1e-3)


@pytest.mark.parametrize(
    "other",
    [
        "time,seat\n0,1\n1,2\n",
        "Name,seat\n0,1\n1,2\n",
        text("seat").replace("SampleTime[ms]", "Comment"),
        text("seat").replace("\n\n133", "\nEnd\n133"),
        "Name,Scope,\n",
    ],
)
def test_other_texts_stay_as_they_are(other: str) -> None:
    assert with_scope_names(other.encode()) == (other.encode(), {})
