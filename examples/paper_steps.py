"""
The paper's four steps
======================

The paper's four steps one by one, with a picture of each.

Run it with the name of a picture to write; without one it goes to the temporary folder.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from suspid import (
    best_bandwidth,
    cwt,
    find_ridges,
    fit_ridges,
    free_decay,
    plot_entropy,
    plot_scalogram,
    plot_skeletons,
    quarter_car,
)

masses = {"seat_mass": 200, "chassis_mass": 200, "tire_mass": 200}
springs = {"seat_stiffness": 200e3, "chassis_stiffness": 400e3, "tire_stiffness": 800e3}
car = quarter_car(**masses, **springs, seat_damping=300, chassis_damping=200, tire_damping=100)
record = free_decay(car, np.arange(0, 10, 0.002), initial_state={"v_tire": 1.0})

# Step 1: the bandwidth of least wavelet entropy. It depends on the record's length and on these rows.
omega = np.geomspace(10, 150, 100)
search = best_bandwidth(record, omega=omega, candidates=range(1, 101, 3))
print(f"least entropy at N = {search.best:g}{', an end of the range' * search.at_end}")

# Steps 2 and 3: the transform and its ridges. A shorter wavelet than that keeps the edges short.
scalogram = cwt(record, omega=omega, bandwidth=min(search.best, 8.0))
ridges = find_ridges(scalogram, count=3)

print(fit_ridges(ridges))  # step 4: lines through log modulus and phase

figure = Figure(figsize=(8, 10), layout="constrained")
top, middle, bottom = figure.subfigures(3, height_ratios=[2, 3, 3], squeeze=False)[:, 0]
plot_entropy(search, ax=top.subplots())
plot_scalogram(scalogram, ax=middle.subplots(), ridges=ridges)
plot_skeletons(ridges, axes=bottom.subplots(2, 3, sharex=True))
picture = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(tempfile.mkdtemp(), "paper_steps.png")
figure.savefig(picture, dpi=120)
print(f"drawn to {picture}")
