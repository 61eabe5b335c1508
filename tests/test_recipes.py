"""The README's recipes for newcomers, each tried in a copy of the library: the number of files it touches."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

import suspid
from suspid import identify, read_record

# Each copies the library and starts it anew.
pytestmark = pytest.mark.slow

RECORD = Path("examples/quarter_car.csv").resolve()


@dataclass(frozen=True)
class Copy:
    """A copy of the library, and the files of it that a newcomer touched."""

    folder: Path
    touched: set[str] = field(default_factory=set)

    def write(self, name: str, text: str) -> None:
        path = self.folder / "suspid" / name
        assert not path.exists()
        path.write_text(text, encoding="utf-8")
        self.touched.add(name)

    def insert(self, name: str, mark: str, text: str) -> None:
        """Put a text in front of the only mark in a file."""
        self.replace(name, mark, text + mark)

    def replace(self, name: str, old: str, new: str) -> None:
        path = self.folder / "suspid" / name
        before = path.read_text(encoding="utf-8")
        assert before.count(old) == 1, f"{name}: {old!r} stands there {before.count(old)} times"
        path.write_text(before.replace(old, new), encoding="utf-8")
        self.touched.add(name)

    def run(self, *arguments: str) -> str:
        """Return what Python prints with the copied library."""
        ended = subprocess.run(
            [sys.executable, *arguments],
            cwd=self.folder,
            env={**os.environ, "PYTHONPATH": str(self.folder)},
            capture_output=True,
            text=True,
            check=False,
        )
        assert ended.returncode == 0, ended.stderr
        return ended.stdout


@pytest.fixture
def copy(tmp_path: Path) -> Copy:
    shutil.copytree(Path(suspid.__file__).parent, tmp_path / "suspid")
    return Copy(tmp_path)


def test_a_file_format(copy: Copy) -> None:
    """A file of raw doubles at 100 Hz: found by its suffix and by its first bytes, read by commands and fleets."""
    copy.write(
        "io/raw.py",
        "import numpy as np\n"
        "from suspid.errors import RecordError\n"
        "from suspid.files import read_bytes\n"
        "from suspid.io.tables import Table\n"
        "def read_raw(path):\n"
        "    samples = np.frombuffer(read_bytes(path, error=RecordError)[8:])\n"
        "    return Table(sizes={'seat': len(samples)}, columns=lambda wanted: [samples for _ in wanted],\n"
        "                 rates={'rate': 100.0})\n",
    )
    copy.insert(
        "io/formats.py", '    Format("wav",', '    Format("raw", (".raw",), "raw samples", ((0, b"RAWFILE1"),)),\n'
    )
    assert len(copy.touched) == 2
    t = np.arange(600) / 100
    decay = np.exp(-0.5 * t) * np.cos(12 * t) + 1e-3 * np.random.default_rng(1).normal(size=len(t))
    for name in ("a.raw", "b.unknown"):
        (copy.folder / name).write_bytes(b"RAWFILE1" + decay.tobytes())
        assert "1 mode found" in copy.run("-m", "suspid", "identify", name)
    pytest.importorskip("pyarrow")
    (copy.folder / "day").mkdir()
    shutil.copy(copy.folder / "a.raw", copy.folder / "day")
    assert "results: 1 record, 0 of them with a failure" in copy.run("-m", "suspid", "fleet", "day", "-o", "results")


def test_a_noise_model(copy: Copy) -> None:
    """A variance four times that of white noise: the same poles, standard deviations twice as large."""
    copy.replace(
        "identification/noise/white.py",
        "return np.asarray(np.maximum(squares / count, self.least))",
        "return np.asarray(np.maximum(4 * squares / count, self.least))",
    )
    assert len(copy.touched) <= 2
    told = copy.run(
        "-c",
        "import suspid\n"
        f"found = suspid.identify(suspid.read_record({str(RECORD)!r})).modes\n"
        "print(*found.wn, *found.zeta, *found.wn_std, *found.zeta_std)\n",
    )
    wn, zeta, wn_std, zeta_std = np.array(told.split(), dtype=float).reshape(4, -1)
    white = identify(read_record(RECORD)).modes
    np.testing.assert_allclose(wn, white.wn, rtol=1e-6)
    np.testing.assert_allclose(zeta, white.zeta, rtol=1e-6)
    np.testing.assert_allclose(wn_std, 2 * np.asarray(white.wn_std), rtol=1e-3)
    np.testing.assert_allclose(zeta_std, 2 * np.asarray(white.zeta_std), rtol=1e-3)


def test_a_picture_in_the_report(copy: Copy) -> None:
    """The energy of the record over time, in colours that dark screens can exchange."""
    copy.write(
        "reporting/plot_energy.py",
        "from suspid.reporting.colours import Colour\n"
        "def plot_energy(found, *, ax):\n"
        "    ax.plot(found.response.time, (found.response.outputs ** 2).sum(axis=0), color=Colour.BLUE)\n"
        "    return ax\n",
    )
    module = "reporting/pictures.py"
    copy.insert(
        module,
        "from suspid.reporting.plot_entropy import",
        "from suspid.reporting.plot_energy import plot_energy\n",
    )
    copy.insert(module, "    entropy: Picture | None\n", "    energy: Picture\n")
    copy.insert(
        module,
        "            entropy=_entropy(found),\n",
        "            energy=picture(lambda figure: plot_energy(found, ax=figure.subplots()) and None, name='energy',\n"
        "                           described='Energy of the record', height=1.9),\n",
    )
    copy.insert(
        "reporting/templates/report.html.j2",
        "{% if pictures.entropy %}\n<figure>",
        "<figure>{{ figure(pictures.energy) }}</figure>\n",
    )
    assert len(copy.touched) == 3
    copy.run("-m", "suspid", "report", str(RECORD), "-o", "page.html")
    page = (copy.folder / "page.html").read_text(encoding="utf-8")
    assert page.count("Energy of the record") == 1


def test_an_estimator(copy: Copy) -> None:
    """The damping ratio of a decay from its peaks, with a verdict of its own code."""
    copy.write(
        "words/decrement.py",
        "from suspid.words.remarks import Code\n"
        "class DecrementCheck(Code):\n"
        '    """What speaks for and against a decrement."""\n'
        '    PEAKS = "peaks", "The decrement is the mean over {number} peaks."\n',
    )
    copy.write(
        "greybox/decrement.py",
        "import numpy as np\n"
        "from dataclasses import dataclass\n"
        "from suspid.cleaning import as_record\n"
        "from suspid.results import Result\n"
        "from suspid.words import Check, Level, Remark, Verdict\n"
        "from suspid.words.decrement import DecrementCheck\n"
        "@dataclass(frozen=True, kw_only=True, eq=False)\n"
        "class Decrement(Result):\n"
        "    zeta: float\n"
        "    verdict: Verdict\n"
        "    def __str__(self):\n"
        "        return f'zeta {self.zeta:.4f}\\n{self.verdict}'\n"
        "def decrement(record):\n"
        "    y = np.atleast_2d(as_record(record).outputs)[0]\n"
        "    peaks = y[1:-1][(y[1:-1] > y[:-2]) & (y[1:-1] > y[2:])]\n"
        "    delta = np.log(peaks[0] / peaks[-1]) / (len(peaks) - 1)\n"
        "    remark = Remark(DecrementCheck.PEAKS, {'number': len(peaks)})\n"
        "    checks = (Check(remark, Level.SOUND),)\n"
        "    zeta = delta / np.hypot(delta, 2 * np.pi)\n"
        "    return Decrement(zeta=zeta, verdict=Verdict(checks[0].remark, checks))\n",
    )
    line = "from suspid.greybox.decrement import Decrement, decrement\n"
    copy.insert("greybox/__init__.py", "from suspid.greybox.drives import", line)
    copy.insert("greybox/__init__.py", '    "Drive",\n', '    "Decrement",\n    "decrement",\n')
    copy.insert("__init__.py", "    Drive,\n", "    Decrement,\n    decrement,\n")
    copy.insert("__init__.py", '    "damper_curve", "DamperCurve",', '    "decrement", "Decrement",\n')
    assert len(copy.touched) == 4
    told = copy.run(
        "-c",
        "import numpy as np, suspid\n"
        "t = np.arange(4000) / 1000\n"
        "found = suspid.decrement(suspid.as_record([np.exp(-0.02 * 20 * t) * np.cos(20 * t)], timepts=t))\n"
        "print(repr(found)); print(found.details()); print(found._repr_html_())\n",
    )
    # zeta of exp(-a t) cos(w t) is a / hypot(a, w).
    assert f"zeta {0.02 / np.hypot(0.02, 1):.4f}" in told
    assert "The decrement is the mean over" in told


def test_a_ride_metric(copy: Copy) -> None:
    """A module of `performance` and its name there: `suspid` exports it, and what is said of one is not repeated."""
    copy.write("performance/crest.py", "def crest(peak: float, rms: float) -> float:\n    return peak / rms\n")
    copy.insert(
        "performance/__init__.py",
        "from suspid.performance.damper_rates import dampers_between",
        "from suspid.performance.crest import crest\n",
    )
    copy.insert("performance/__init__.py", '    "grip",\n', '    "crest",\n')
    assert len(copy.touched) == 2
    told = copy.run("-c", "from suspid import *; import suspid; print(crest(3.0, 1.5), 'crest' in suspid.__all__)")
    assert told == "2.0 True\n"
