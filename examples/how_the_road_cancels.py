r"""
How the road cancels
====================

In a drive nobody knows the road. But what the body of a car does depends on the wheel alone: with the measured motion
:math:`z_w` of the wheel as the cause, a quarter car obeys

.. math:: m_b \ddot z_b + c (\dot z_b - \dot z_w) + k (z_b - z_w) = 0,

in which neither road nor tire appears. `suspid.estimate` with ``given=["tire"]`` fits k and c to this, whatever the
road was. The noise of both sensors is in the likelihood, and so are gain and delay of the wheel's sensor.
"""

import numpy as np
from matplotlib.figure import Figure

from suspid import add_noise, estimate, plot_spectra, quarter_car, road, simulate

true = quarter_car(
    chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300, tire_damping=60
)
nominal = true.with_parameters(stiffness={"chassis": 16e3, "tire": 300e3}, damping={"chassis": 1700})
sensors = ["chassis_acceleration", "tire_acceleration"]

# %%
# The same car on a good road, fast, and on a bad one, slowly. The tire in the nominal car is wrong by 40 %; it does
# not matter.
times, found = np.arange(0, 60, 0.005), {}
for name, speed in (("A", 30.0), ("D", 10.0)):
    heights = road(name, speed=speed, under=true).heights(times, rng=np.random.default_rng(2))
    clean = simulate(true, times, heights, outputs=sensors, interpolation="cubic")
    record = add_noise(clean, snr_db=30.0, rng=np.random.default_rng(3))
    found[name] = estimate(record, nominal, given=["tire"])
    print(f"road {name} at {speed:g} m/s\n{found[name]}\n")

# %%
# The spectra of the body with the fit, on the bad road. What is left is noise.
page = Figure(figsize=(7, 3.4), layout="constrained")
plot_spectra(found["D"], axes=page.subplots(2, sharex=True))

# %%
# Both intervals hold the truth.
for name, one in found.items():
    low, high = one.interval(0.99)["chassis.damping"]
    print(f"road {name}: c between {low:.0f} and {high:.0f} N s/m, truth 1300")
