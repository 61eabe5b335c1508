"""CPU time of the everyday calls, relative to one Fourier transform of the record and beside other libraries."""

from __future__ import annotations

import importlib
import itertools
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from tabulate import tabulate

from suspid import (
    ModalSet,
    Suspension,
    add_noise,
    analyse,
    cwt,
    denoise,
    eigenmodes,
    find_decays,
    free_decay,
    identify,
    read_record,
    read_recording,
    reconstruct,
    report,
    statespace,
)
from suspid.records import as_response
from validation import cars
from validation.fleet import make_records
from validation.peer_methods import mwdi
from validation.peer_skeletons import RATE
from validation.peers import missing_module, record, silence

EXAMPLE = Path(__file__).parents[1] / "examples" / "quarter_car.csv"
# What stands beside a run as what was before it, and the column that is compared.
REPORT, RATIO = Path(__file__).parent / "report" / "speed.md", "over one rfft"
# Rows of the text file.
LINES = 200_000
# Rows of the transform at full rate.
ROWS = 100
# What poles alone leave open in a full car.
HELD = (
    "front_antiroll.stiffness",
    "front_antiroll.damping",
    *(f"{side}_tire.damping" for side in ("front_left", "front_right", "rear_left", "rear_right")),
)


def everyday_table(rounds: int) -> str:
    """Return the table: each call over one `numpy.fft.rfft` of its record, and over the peer below the same record."""
    with tempfile.TemporaryDirectory() as folder:
        parts = []
        for title, samples, runs in _groups(Path(folder)):
            seconds = _least({"limit": partial(np.fft.rfft, samples, axis=-1), **runs}, rounds)
            limit, first = seconds["limit"], seconds[next(iter(runs))]
            parts.append([f"{title}: one rfft of the record", f"{1e3 * limit:.3g}", "1", f"{limit / first:.2g}"])
            for name in runs:
                row = [name, f"{1e3 * seconds[name]:.3g}", f"{seconds[name] / limit:.3g}"]
                parts.append([*row, f"{seconds[name] / first:.2f}"])
    before = committed(REPORT.read_text(encoding="utf-8")) if REPORT.exists() else {}
    parts = [[*row[:3], before.get(row[0], ""), row[3]] for row in parts]
    headers = ["call", "CPU ms", RATIO, "before", "over the first of the record"]
    return tabulate(parts, headers=headers, tablefmt="github", disable_numparse=True)


def committed(text: str) -> dict[str, str]:
    r"""Return what each call took over one transform of its record in an earlier report.

    Examples
    --------
    >>> committed("| call | CPU ms | over one rfft |\n|---|---|---|\n| cwt | 10.5 | 87 |")
    {'cwt': '87'}
    """
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in text.splitlines() if line.startswith("|")]
    first = next((k for k, row in enumerate(rows) if row[2:3] == [RATIO]), len(rows))
    table = itertools.takewhile(lambda row: len(row) == len(rows[first]), rows[first + 2 :])
    return {row[0]: row[2] for row in table}


def _groups(folder: Path) -> list[tuple[str, Any, dict[str, Callable[[], object]]]]:
    """Return records with the calls on each; the library's own call comes first."""
    seat = record(20.0, 0)
    short = as_response(np.arange(len(seat)) / RATE, seat[None], ("seat",))
    rng = np.random.default_rng(0)
    long = as_response(np.arange(1_000_000) / RATE, rng.standard_normal((1, 1_000_000)), ("seat",))
    omega = np.geomspace(3.0, 0.9 * np.pi * RATE, ROWS)
    three = rng.standard_normal((3, LINES))
    path = folder / "rows.csv"
    table = np.column_stack([np.arange(LINES) / RATE, *three])
    np.savetxt(path, table, delimiter=",", header="time [s],a [m],b [m],c [m]", comments="", fmt="%.6g")
    events, hour = _events(600_000), _events(3_600_000)
    members = make_records(folder / "fleet", 4)
    from validation.speed import decay

    modes, full = eigenmodes(cars.PAPER), _full_car()
    times, decays = decay(1_000_000, RATE)
    return [
        (
            "5000 samples",
            seat,
            {
                "identify": partial(identify, short),
                **_if("mwdi", "mwdi, three modes near given frequencies", lambda: mwdi(seat, modes.wn)),
                "analyse and report, the page of a file": lambda: report(analyse(EXAMPLE)),
                "reconstruct from poles and shapes": partial(reconstruct, modes, cars.PAPER),
                "reconstruct from poles alone, half car": _from_poles(cars.TWO_AXLES),
                "reconstruct from poles alone, full car": _from_poles(cars.FOUR_WHEELS, fixed=HELD),
            },
        ),
        (
            "7 channels of a full car, 3000 samples",
            np.asarray(full.y),
            {"identify, full car": partial(identify, full)},
        ),
        (
            "3 channels, 1,000,000 samples, as float32",
            np.asarray(decays, np.float32),
            {"identify, 3 channels": partial(identify, as_response(times, decays, ("seat", "chassis", "tire")))},
        ),
        (
            f"5000 samples, {ROWS} rows at full rate",
            seat,
            {
                "cwt": partial(cwt, short, omega=omega, bandwidth=22.0, full_rate=True),
                **_if("fcwt", "fCWT, errors 3e-4", partial(_fcwt, seat, float(omega[0]), float(omega[-1]))),
            },
        ),
        (
            "1,000,000 samples",
            np.asarray(long.y),
            {
                "denoise, decimated": partial(denoise, long, transform="decimated"),
                **_if("skimage", "scikit-image, denoise_wavelet", partial(_skimage, np.asarray(long.y[0]))),
            },
        ),
        (
            f"text, {LINES} rows of 4",
            three,
            {
                "read_recording": partial(read_recording, path),
                **_if("pandas", "pandas.read_csv", partial(_pandas, path)),
            },
        ),
        (
            "text, 5000 rows of 4",
            seat,
            {
                "read_recording, small": partial(read_recording, EXAMPLE),
                **_if("pandas", "pandas.read_csv, small", partial(_pandas, EXAMPLE)),
            },
        ),
        (
            "four records of a fleet, each 3 channels, 2000 samples, Parquet",
            np.concatenate([read_record(member).y for member in members]),
            {"analyse, four times": lambda: [analyse(member).verdict for member in members]},
        ),
        ("ten minutes, 3 channels, 1 kHz", np.asarray(events.y), {"find_decays": partial(find_decays, events)}),
        ("an hour, 3 channels, 1 kHz", np.asarray(hour.y), {"find_decays, all 62 of them": partial(find_decays, hour)}),
    ]


def _from_poles(car: Suspension, fixed: Sequence[str] = ()) -> Callable[[], object]:
    """Return the reconstruction from poles that are a thousandth off."""
    return partial(reconstruct, ModalSet(poles=1.001 * eigenmodes(car).poles), car, fixed=fixed)


def _full_car() -> Any:
    """Return the decay of a heavily damped full car at 40 dB."""
    system = statespace(cars.FOUR_WHEELS)
    speeds = [name for name in system.state_labels if name.startswith("v_")]
    start = dict(zip(speeds, (1.0, -0.4, 0.7, 0.2, -0.9, 0.5, 0.3), strict=True))
    response = free_decay(system, np.arange(3000) / RATE, initial_state=start)
    return add_noise(response, snr_db=40.0, rng=np.random.default_rng(40))


def _if(module: str, name: str, call: Callable[[], object]) -> dict[str, Callable[[], object]]:
    """Return a call of a peer, if it is installed."""
    return {} if missing_module(module) else {name: call}


def _fcwt(samples: Any, low: float, high: float) -> object:
    package = importlib.import_module("fcwt")
    # Its sigma is the square root of N / 2 over 2 pi cycles.
    wavelet = package.Morlet(float(np.sqrt(22.0 / 2)))
    scales = package.Scales(wavelet, package.FCWT_LOGSCALES, int(RATE), low / (2 * np.pi), high / (2 * np.pi), ROWS)
    out = np.zeros((ROWS, len(samples)), np.complex64)
    package.FCWT(wavelet, 1, False, False).cwt(np.asarray(samples, np.float32), scales, out)
    return out


def _skimage(samples: Any) -> object:
    return importlib.import_module("skimage.restoration").denoise_wavelet(samples, wavelet="sym8")


def _pandas(path: Path) -> object:
    return importlib.import_module("pandas").read_csv(path)


def _events(count: int) -> Any:
    """Return a recording at 1 kHz in which the saloon is released every 58 s."""
    rate = 1000.0
    once = np.asarray(free_decay(cars.SALOON, np.arange(8000) / rate, initial_state={"v_tire": 1.0}).y)
    values = 0.01 * np.std(once, axis=1)[:, None] * np.random.default_rng(0).standard_normal((len(once), count))
    for first in range(10_000, count - 10_000, 58_000):
        values[:, first : first + 8000] += once
    return as_response(np.arange(count) / rate, values, [f"c{k}" for k in range(len(once))])


def _least(runs: Mapping[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """Return the least CPU seconds of each run, taken in turns after one round to warm up."""
    seconds: dict[str, list[float]] = {name: [] for name in runs}
    for _ in range(rounds + 1):
        for name, run in runs.items():
            start = time.process_time()
            with silence():
                run()
            seconds[name].append(time.process_time() - start)
    return {name: min(values[1:]) for name, values in seconds.items()}
