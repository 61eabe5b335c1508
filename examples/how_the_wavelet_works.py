r"""
How the wavelet finds modes
===========================

A free decay is a sum of damped cosines. The modified Morlet wavelet :math:`e^{-t^2/N} e^{i t}` is moved along the
record and stretched over the frequencies; where a mode is, the transform is large. Along such a ridge the logarithm
of the modulus falls with :math:`\zeta \omega_n` and the phase rises with :math:`\omega_d`: two straight lines, two
numbers (Nouri, Loussifi and Benhadj Braiek 2011, see the references of `suspid.identify`).
"""

import numpy as np
from matplotlib.figure import Figure

from suspid import (
    add_noise,
    best_bandwidth,
    cwt,
    eigenmodes,
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
decay = free_decay(car, np.arange(0, 10, 0.002), initial_state={"v_tire": 1.0})
record = add_noise(decay, snr_db=20.0, rng=np.random.default_rng(1))

# %%
# A long wavelet (large N) tells frequencies apart, a short one tells times apart. The bandwidth N is chosen where
# the energy of the transform is least spread, that is where its entropy is least. A clean decay asks for long
# wavelets.
search = best_bandwidth(decay, omega=np.geomspace(10, 150, 60), candidates=range(1, 202, 10))
print(f"least entropy at N = {search.best:g}")
plot_entropy(search, ax=(entropy := Figure(figsize=(7, 2.6), layout="constrained")).subplots())

# %%
# The scalogram is the modulus over time and frequency. The ends of the record disturb the transform inside the
# dotted lines; the ridges are followed between them.
scalogram = cwt(record, omega=np.geomspace(10, 150, 100), bandwidth=8.0)
ridges = find_ridges(scalogram, count=3)
picture = Figure(figsize=(7, 3.6), layout="constrained")
plot_scalogram(scalogram, ax=picture.subplots(), ridges=ridges)

# %%
# The skeletons along the ridges, and the lines through them.
lines = Figure(figsize=(9, 4.4), layout="constrained")
plot_skeletons(ridges, axes=lines.subplots(2, 3, sharex=True))

# %%
# Their slopes beside the eigenvalues of the car. `suspid.identify` does better by fitting all channels at once.
print(fit_ridges(ridges))
print(eigenmodes(car))
