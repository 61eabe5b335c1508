"""
Decays in a long recording
==========================

Half a minute of recording with three bumps in it: the decays found, identified jointly, and a page on them.

Run it as ``python examples/long_recording.py [page.html]``.
"""

import sys
import tempfile
from pathlib import Path

import control
import numpy as np

from suspid import (
    content_of,
    eigenmodes,
    find_decays,
    free_decay,
    identify,
    identify_repeats,
    quarter_car,
    report,
    statespace,
)

# A small car whose body and wheel carry accelerometers.
car = quarter_car(
    chassis_mass=320.0,
    tire_mass=38.0,
    chassis_stiffness=18e3,
    tire_stiffness=190e3,
    chassis_damping=1300.0,
)
system = statespace(car, outputs=["chassis_acceleration", "tire_acceleration"])

# At 200 Hz: noise of 0.02 m/s2, and three times the car is dropped from a few centimetres.
rng = np.random.default_rng(7)
times = np.arange(0, 36, 0.005)
values = 0.02 * rng.standard_normal((2, times.size))
for start, height in ((6.0, 0.03), (15.0, 0.02), (25.0, 0.04)):
    after = times >= start
    dropped = free_decay(system, times[: after.sum()], initial_state={"z_chassis": height, "z_tire": 0.3 * height})
    values[:, after] += dropped.y

# A recording is a control.TimeResponseData, like any response.
recording = control.TimeResponseData(times, values, output_labels=list(system.output_labels), issiso=False)

decays = find_decays(recording)
print(decays, "\n")

repeats = identify_repeats(recording, decays)
print(repeats, "\n")
print("Truth:")
print(eigenmodes(car))

drawn = repeats.each[0].plot()

# The page is on the best decay; the repeats stand beside it.
best = repeats.each[0]
page = Path(sys.argv[1] if len(sys.argv) > 1 else Path(tempfile.mkdtemp(), "page.html"))
page.write_text(report(content_of(best, decays=decays, repeats=repeats), title="Three drops"), encoding="utf-8")
print(f"\n{len(identify(best.response).modes)} modes in the best decay; page written to {page}")
