"""
What denoising does
===================

What denoising does to a record, and what it does to the damping found in it.

A denoised record looks better. It holds no more information on the modes than before, and where the tail of
a decay is taken for noise the damping comes out too high. So: denoise to look, identify from the raw record.
"""

import numpy as np
from matplotlib.figure import Figure

from suspid import add_noise, denoise, eigenmodes, free_decay, identify, quarter_car

car = quarter_car(
    chassis_mass=400,
    tire_mass=40,
    chassis_stiffness=20e3,
    tire_stiffness=200e3,
    chassis_damping=60,
    tire_damping=20,
)
exact = eigenmodes(car)
clean = free_decay(car, np.arange(0, 20, 0.005), initial_state={"v_tire": 1.0, "v_chassis": 1.0})
rng = np.random.default_rng(1)

print("zeta less its exact value, in percent of it (mean and scatter of 5 records of 20 dB), and noise left")
print("  record      mode 1          mode 2      noise std")
errors: dict[str, list[np.ndarray]] = {"raw": [], "denoised": []}
left: dict[str, list[float]] = {"raw": [], "denoised": []}
for _ in range(5):
    raw = add_noise(clean, snr_db=20.0, rng=rng)
    # The same record twice: the only difference is the denoising.
    for name, record in (("raw", raw), ("denoised", denoise(raw))):
        zeta = identify(record, modes=2).modes.zeta
        errors[name].append(100 * (zeta / exact.zeta - 1))
        left[name].append(float(np.std(record.y - clean.y)))
for name, error in errors.items():
    columns = [f"{m:+6.2f} ± {s:5.2f}" for m, s in zip(np.mean(error, 0), np.std(error, 0), strict=True)]
    print(f"{name:>8}  {'  '.join(columns)}  {np.mean(left[name]):.1e} m")

figure = Figure(figsize=(7, 3), layout="constrained")
ax = figure.subplots()
ax.plot(raw.time, raw.y[0], label="record", color="#b4b4b4", linewidth=1.0)
ax.plot(raw.time, denoise(raw).y[0], label="denoised", color="#0072b2", linewidth=1.5)
ax.plot(clean.time, clean.y[0], "k--", label="without noise", linewidth=1.0)
ax.set(xlim=(0, 2.5), xlabel="time [s]", ylabel=f"{clean.output_labels[0]} [m]")
figure.legend(loc="outside upper right", ncols=3, frameon=False)
