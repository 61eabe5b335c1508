"""
A controller for the seat
=========================

From a noisy record to a seat controller and the spread of its effect; the picture goes to the path given, if any.
"""

import sys
import tempfile
from pathlib import Path

import control
import numpy as np
from matplotlib.figure import Figure

from suspid import Suspension, add_noise, free_decay, identify, read_car, reconstruct, statespace

true = read_car(Path(__file__).with_name("hatchback.toml"))
decay, rng = free_decay(true, np.arange(0, 4, 0.002), initial_state={"v_tire": 1.0}), np.random.default_rng(1)
nominal = true.with_parameters(stiffness={"seat": 26e3, "tire": 150e3}, damping={"seat": 600, "chassis": 2200})
found = reconstruct(identify(add_noise(decay, snr_db=10.0, rng=rng)).modes, nominal)
print(found, "\n")


OUTPUTS = ["seat_acceleration", "seat_travel"]


def actuated(car: Suspension) -> list[np.ndarray]:
    """Return A, B, C, D with a third input: the force of an actuator that pushes the ends of the seat's strut apart."""
    return [*control.ssdata(statespace(car, outputs=OUTPUTS, forces=["seat_travel"], roads=car.roads))]


# LQR from all states: acceleration, travel and force, each over what is acceptable (1 m/s2, 10 mm, 400 N).
A, B, C, D = actuated(found.suspension)
C, D = C / [[1.0], [0.01]], D[:, 2:] / [[1.0], [0.01]]
lqr = control.lqr(A, B[:, 2:], C.T @ C, D.T @ D + 1 / 400**2, C.T @ D)[0]
time, w = np.linspace(0, 1.5, 751), 2 * np.pi / 0.2  # a bump of 5 cm, passed in 0.2 s: height and rate of the road
road = np.where(time < 0.2, [0.025 * (1 - np.cos(w * time)), 0.025 * w * np.sin(w * time)], 0.0)
cars = [found.suspension, true]  # and those that the record allows; a rate drawn below zero counts as zero
best = {f"{s.name}.{what}": getattr(s, what) for s in cars[0].struts for what in ("stiffness", "damping")}
for draw in rng.multivariate_normal([best[p] for p in found.parameters], np.asarray(found.covariance), size=200):
    x = dict(zip(found.parameters, np.maximum(draw, 0.0), strict=True))
    k, c = ({s.name: x[f"{s.name}.{what}"] for s in true.struts} for what in ("stiffness", "damping"))
    cars.append(true.with_parameters(stiffness=k, damping=c))

figure = Figure(figsize=(8, 4.5), layout="constrained")
axes = figure.subplots()
axes.set(xlabel="time [s]", ylabel="seat acceleration [m/s²]", title="Over a bump of 5 cm; bands: 95 % of the draws")
print("over a bump of 5 cm        found   95 % of draws    true")
for name, gain, colour in (("passive", 0 * lqr, "#D55E00"), ("LQR", lqr, "#0072B2")):
    plants = map(actuated, cars)
    loops = [control.ss(A - B[:, 2:] @ gain, B[:, :2], C - D[:, 2:] @ gain, D[:, :2]) for A, B, C, D in plants]
    seat = np.array([control.forced_response(loop, time, road).y for loop in loops])  # (car, output, sample)
    for row, what in enumerate(("a [m/s2]", "travel [mm]")):
        peak = 1000**row * np.abs(seat[:, row]).max(axis=1)
        low, high = np.percentile(peak[2:], [2.5, 97.5])
        print(f"{name:7}  peak {what:12} {peak[0]:5.2f}  {low:5.2f} to {high:5.2f}   {peak[1]:5.2f}")
    axes.fill_between(time, *np.percentile(seat[2:, 0], [2.5, 97.5], axis=0), color=colour, alpha=0.3, linewidth=0)
    axes.plot(time, seat[0, 0], color=colour, label=name)
    axes.plot(time, seat[1, 0], "k:", label="the true car" * (name == "LQR"))
axes.legend()
picture = sys.argv[1] if len(sys.argv) > 1 else f"{tempfile.mkdtemp()}/seat_controller.png"
figure.savefig(picture, dpi=120)
print(f"drawn to {picture}")
