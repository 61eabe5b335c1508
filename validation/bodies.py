"""One accelerometer on the body: frequencies from drives on roads that nothing is known of.

The drives are those of `validation.tyres`, of which the body's acceleration alone is used.
"""

from __future__ import annotations

import numpy as np

from suspid import body_modes, eigenmodes
from suspid.signals import as_response, as_signal
from suspid.values import text_table
from validation.tyres import FIRST_SEED, SEEDS, TireRow, draw, rows

DRIVES = (
    "exponent 2",
    "exponent 1.5",
    "exponent 2.5",
    "bent, 1.5 to 2.5",
    "bent, 2.5 to 1.5",
    "unbalance, ±40 %, bent 1.5 to 2.5",
)

HEAD = f"""# One sensor on the body

Drives of five minutes on roads of class B, as in tyres.md, draws that were not used during development; of each the
body's acceleration alone is used, and nothing is known of road, speed and car. RMSE and width are in % of the natural
frequency of the true car; 'width' is the median half width of the 95 % interval, coverage how many hold. No damping is
reported. 'zeta would be' is the mean least and largest damping ratio of the models of road and damper that the records
do not rule out; the true one is 0.203. `SUSPID_SEEDS={SEEDS} python -m validation bodies` writes this page."""


def line(row: TireRow, *, seeds: int = SEEDS) -> dict[str, str]:
    """Return the line of the table of a drive."""
    errors, widths, held, zetas, none = [], [], [], [], 0
    for seed in range(FIRST_SEED, FIRST_SEED + seeds):
        record, _, car = draw(row, seed)
        signal = as_signal(record)
        (mode,) = body_modes(as_response(np.asarray(record.time, float), signal.values[:1], signal.channels[:1]))
        if not mode.models:
            none += 1
            continue
        true = float(eigenmodes(car).wn[0]) / (2 * np.pi)
        low, high = mode.interval()
        errors.append(mode.hertz / true - 1)
        widths.append((high - low) / 2 / true)
        held.append(low < true < high)
        zetas.append((min(mode.zetas), max(mode.zetas)))
    least, most = np.mean(zetas, axis=0)
    return {
        "drive": row.name,
        "draws": str(seeds),
        "no frequency": str(none),
        "f1 bias": f"{100 * np.mean(errors):+.1f}",
        "RMSE": f"{100 * np.sqrt(np.mean(np.square(errors))):.1f}",
        "width": f"{100 * np.median(widths):.1f}",
        "coverage": f"{100 * np.mean(held):.0f}",
        "zeta would be": f"{least:.2f} to {most:.2f}",
    }


def table(lines: list[dict[str, str]]) -> str:
    """Return lines as a table."""
    return text_table({name: [one[name] for one in lines] for name in lines[0]})


def report() -> str:
    """Return the report."""
    known = {row.name: row for row in rows()["Five minutes"]}
    return f"{HEAD}\n\n```\n{table([line(known[name]) for name in DRIVES])}\n```\n"
