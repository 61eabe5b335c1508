"""Write the reports: ``python -m validation [NAME ...] [--out FOLDER]``."""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import os
from pathlib import Path

# In order; each module has report(), and pictures(folder) if it draws any.
REPORTS = ("paper", "accuracy", "springs", "peers", "speed", "denoising", "transform", "free_decay", "decays", "fleet")
FOLDER = Path(__file__).parent / "report"


def main(arguments: list[str] | None = None) -> int:
    """Write the reports that are asked for; return the exit code."""
    known = [name for name in REPORTS if importlib.util.find_spec(f"validation.{name}")]
    parser = argparse.ArgumentParser(prog="python -m validation", description="Write the reports that judge suspid.")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"which reports: {', '.join(known)} (default: all)")
    parser.add_argument(
        "--out", type=Path, default=FOLDER, metavar="FOLDER", help="where to write (default: %(default)s)"
    )
    given = parser.parse_args(arguments)
    unknown = [name for name in given.names if name not in known]
    if unknown:
        parser.error(f"there is no report {unknown[0]!r}; choose from {', '.join(known)}")
    given.out.mkdir(parents=True, exist_ok=True)
    for name in given.names or known:
        for path in write(name, given.out):
            print(path, flush=True)
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
