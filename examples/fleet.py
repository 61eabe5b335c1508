"""
A fleet and its worn damper
===========================

Twelve tests of one car whose damper wears out: identified as a fleet, and the trend that its tables show.

Run it as ``python examples/fleet.py`` after ``pip install '.[fleet]'``.
"""

import tempfile
from pathlib import Path

import numpy as np

from suspid import add_noise, fleet_summary, free_decay, identify_many, quarter_car, write_record

folder = Path(tempfile.mkdtemp())
(folder / "records").mkdir()
car = quarter_car(
    chassis_mass=320.0,
    tire_mass=38.0,
    chassis_stiffness=18e3,
    tire_stiffness=190e3,
    chassis_damping=1300.0,
)

# One test a month; the damper loses three hundredths of its first value each time.
rows = ["record,vehicle,date"]
for month in range(12):
    worn = car.with_parameters(damping={"chassis": 1300.0 * (1 - 0.03 * month)})
    decay = free_decay(worn, np.arange(0, 4, 0.005), initial_state={"v_tire": 1.0})
    record = add_noise(decay, snr_db=30.0, rng=np.random.default_rng(month))
    write_record(record, folder / "records" / f"test{month:02}.csv")
    rows.append(f"test{month:02}.csv,van 7,2026-{month + 1:02}-01")
(folder / "tests.csv").write_text("\n".join(rows) + "\n")

# In a script, everything that starts processes stands below this line.
if __name__ == "__main__":
    run = identify_many(folder / "records", output=folder / "results", car=car, workers=2)
    print(run, "\n")
    summary = fleet_summary(folder / "results", table=folder / "tests.csv")
    print(summary)
    drawn = summary.plot()
