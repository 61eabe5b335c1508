"""Write the reports: ``python -m validation [NAME ...] [--out FOLDER]``.

``python -m validation speed --against`` measures only the ratios of `validation.speed_ratios`, compares them with the
committed ones and ends with 1 if a call got slower. ``--ratios`` measures and writes them.
"""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import os
from pathlib import Path

# In this order. Each module has report(); modules with pictures have pictures(folder).
REPORTS = (
    "paper",
    "accuracy",
    "close_modes",
    "steadiness",
    "no_decay",
    "springs",
    "peers",
    "speed",
    "denoising",
    "transform",
    "free_decay",
    "decays",
    "rigs",
    "repeats",
    "pushed",
    "fleet",
    "fuzz",
    "greybox",
    "ride",
    "ride_records",
    "drives",
    "wear",
    "tyres",
    "dampers",
)
FOLDER = Path(__file__).parent / "report"
RATIOS = FOLDER / "speed.json"


def main(arguments: list[str] | None = None) -> int:
    """Write the reports that are asked for; return the exit code."""
    known = [name for name in REPORTS if importlib.util.find_spec(f"validation.{name}")]
    parser = argparse.ArgumentParser(prog="python -m validation", description="Write the reports that judge suspid.")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"which reports: {', '.join(known)} (default: all)")
    parser.add_argument(
        "--out", type=Path, default=FOLDER, metavar="FOLDER", help="where to write (default: %(default)s)"
    )
    only = parser.add_mutually_exclusive_group()
    only.add_argument(
        "--against", type=Path, nargs="?", const=RATIOS, metavar="FILE",
        help="with speed: compare with the ratios in FILE, write nothing (default FILE: %(const)s)",
    )  # fmt: skip
    only.add_argument(
        "--ratios", type=Path, nargs="?", const=RATIOS, metavar="FILE",
        help="with speed: write nothing but the ratios to FILE (default FILE: %(const)s)",
    )  # fmt: skip
    given = parser.parse_args(arguments)
    unknown = [name for name in given.names if name not in known]
    if unknown:
        parser.error(f"there is no report {unknown[0]!r}; choose from {', '.join(known)}")
    if given.against or given.ratios:
        if given.names != ["speed"]:
            parser.error("--against and --ratios belong to one report: python -m validation speed --against")
        return compare_speed(given.against) if given.against else write_speed(given.ratios)
    given.out.mkdir(parents=True, exist_ok=True)
    for name in given.names or known:
        for path in write(name, given.out):
            print(path, flush=True)
    return 0


def compare_speed(path: Path) -> int:
    """Print the ratios of this run beside those in a file; return 1 if a call got slower, else 0."""
    from validation import speed_ratios

    before = speed_ratios.read_ratios(path)
    found = speed_ratios.changes(before, speed_ratios.measured())
    print(speed_ratios.comparison_text(found))
    return int(any(change.slower for change in found))


def write_speed(path: Path) -> int:
    """Measure the ratios and write them to a file; return 0."""
    from validation import speed_ratios

    speed_ratios.write_ratios(path, speed_ratios.measured())
    print(path)
    return 0


def write(name: str, folder: Path) -> list[Path]:
    """Write one report and its pictures into a folder; return the files."""
    module = importlib.import_module(f"validation.{name}")
    path = folder / f"{name}.md"
    path.write_text(module.report(), encoding="utf-8")
    return [path, *(module.pictures(folder) if hasattr(module, "pictures") else [])]


if __name__ == "__main__":
    # Several processes share the work; more threads in each would only compete. This must stand before numpy loads.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    raise SystemExit(main())
