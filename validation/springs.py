"""Errors of springs and dampers from noisy records, compared with the Cramér-Rao bound of the physical model."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from suspid import Suspension, add_noise, eigenmodes, free_decay, identify, quarter_car
from suspid.model import ModalSet
from suspid.model.statespace import state_matrix
from suspid.reconstruction.reconstruct import Reconstruction, reconstruct
from suspid.reconstruction.unknowns import parameter_names, parameter_vector
from suspid.text_tables import text_table
from suspid.units import RealArray
from suspid.values import frozen_real
from validation.cars import HATCHBACK, PAPER, SALOON

CARS = {"paper": PAPER, "hatchback": HATCHBACK, "saloon": SALOON}
SNR_DB = 20.0
SEEDS = 100
TIMES: RealArray = np.arange(0, 10, 0.002)
START = {"v_tire": 1.0}
OFF = (0.7, 1.3)  # of the nominal car, in turn
TWO_MASSES = quarter_car(
    chassis_mass=400, tire_mass=40, chassis_stiffness=20e3, tire_stiffness=200e3, chassis_damping=1500, tire_damping=30
)
TIMED = {"two masses": TWO_MASSES, "hatchback, with a seat": HATCHBACK, "paper": PAPER}
REPEATS = 1000


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Study:
    """Errors over many draws of the noise, by parameter."""

    names: tuple[str, ...]  # stiffnesses [N/m], then dampings [N s/m]
    truth: RealArray
    rmse: RealArray
    bound: RealArray
    coverage: RealArray  # share of the 95 % intervals that contain the truth
    explained: float  # share of the draws in which chi-square is not improbably large


def physical_bound(
    car: Suspension, timepts: RealArray, *, initial_state: Mapping[str, float], noise_std: Sequence[float] | RealArray
) -> RealArray:
    """Return the least standard deviations of k and c from a free decay seen at all coordinates in white noise.

    Unknown are k and c of every strut and the initial state. The sensitivities s of the state x to each obey
    ``s' = A s + (dA/dp) x``; the exponential of ``[[A, 0], [dA/dp, A]]`` over one step is exact.

    The record starts at t = 0 from `initial_state` (labels of states; others zero); `noise_std` is that of each channel
    [m]. The result is k of every strut [N/m], then c [N s/m].
    """
    from scipy.linalg import expm

    A, n = state_matrix(car), len(car.coordinates)
    labels = [f"{kind}_{c}" for kind in ("z", "v") for c in car.coordinates]
    start = np.array([initial_state.get(label, 0.0) for label in labels])
    step, p, struts = timepts[1] - timepts[0], parameter_vector(car), len(car.struts)
    arms, columns = car.arms(car.coordinates), []
    for i in range(2 * struts):
        slope = np.zeros_like(A)
        stretch = np.outer(arms[i % struts], arms[i % struts]) / np.diag(car.M)[:, None]
        slope[n:, (n if i >= struts else 0) : (2 * n if i >= struts else n)] = -stretch
        unit = p[i] if p[i] else p[struts : 2 * struts].max()
        columns.append(
            _samples(expm(step * np.block([[A, 0 * A], [slope * unit, A]])), np.append(start, 0 * start), len(timepts))[
                2 * n : 3 * n
            ]
            / unit
        )
    propagate = expm(step * A)
    columns += [_samples(propagate, unit, len(timepts))[:n] for unit in np.eye(2 * n)]
    J = np.stack([(column / np.asarray(noise_std)[:, None]).ravel() for column in columns], axis=1)
    size = np.linalg.norm(J, axis=0)
    return np.asarray((np.sqrt(np.diag(np.linalg.inv((J / size).T @ (J / size)))) / size)[: 2 * struts])


def _samples(propagate: RealArray, state: RealArray, count: int) -> RealArray:
    """Return the states of a linear recurrence, (state, sample)."""
    states = np.empty((len(state), count))
    for i in range(count):
        states[:, i] = state
        state = propagate @ state
    return states


def nominal(car: Suspension) -> Suspension:
    """Return the car with its k and c 30 % off, up and down in turn."""
    factors = np.resize(OFF, 2 * len(car.struts))
    p, names = parameter_vector(car)[: 2 * len(car.struts)] * factors, [s.name for s in car.struts]
    return car.with_parameters(
        stiffness=dict(zip(names, p, strict=False)), damping=dict(zip(names, p[len(names) :], strict=True))
    )


def found_again(car: Suspension, seed: int, *, snr_db: float = SNR_DB) -> Reconstruction:
    """Return the car found from one noisy record of all its coordinates."""
    record = add_noise(free_decay(car, TIMES, initial_state=START), snr_db=snr_db, rng=np.random.default_rng(seed))
    modes: ModalSet = identify(record, modes=len(car.coordinates)).modes
    return reconstruct(modes, nominal(car))


def study(car: Suspension, *, seeds: int = SEEDS, snr_db: float = SNR_DB) -> Study:
    """Return RMSE, bound and coverage over many draws of the noise."""
    clean = np.asarray(free_decay(car, TIMES, initial_state=START).y)
    noise_std = np.sqrt(np.mean(clean**2, axis=1) / 10 ** (snr_db / 10))
    bound = physical_bound(car, TIMES, initial_state=START, noise_std=noise_std)
    count = 2 * len(car.struts)
    truth, names = parameter_vector(car)[:count], tuple(parameter_names(car)[:count])
    errors, holds, explained = [], [], 0
    for seed in range(seeds):
        answer = found_again(car, seed, snr_db=snr_db)
        ends = answer.interval(0.95)
        errors.append(parameter_vector(answer.suspension)[:count] - truth)
        holds.append([ends[name][0] <= value <= ends[name][1] for name, value in zip(names, truth, strict=True)])
        explained += answer.explains
    return Study(
        names=names,
        truth=frozen_real(truth),
        rmse=frozen_real(np.sqrt(np.mean(np.square(errors), axis=0))),
        bound=frozen_real(bound),
        coverage=frozen_real(np.mean(holds, axis=0)),
        explained=explained / seeds,
    )


def with_noise(modes: ModalSet, rng: np.random.Generator, *, spread: float) -> ModalSet:
    """Return the modes with noise and its covariance: shapes known to the spread, poles ten times better."""
    assert modes.shapes is not None
    n = len(modes)
    std = np.concatenate([np.repeat(np.abs(modes.poles) * spread / 10, 2), np.full(2 * modes.shapes.size, spread)])
    noise = std * rng.standard_normal(len(std))
    return ModalSet(
        poles=modes.poles + noise[0 : 2 * n : 2] + 1j * noise[1 : 2 * n : 2],
        shapes=modes.shapes + (noise[2 * n :: 2] + 1j * noise[2 * n + 1 :: 2]).reshape(n, -1).T,
        channels=modes.channels,
        covariance=np.diag(std**2),
    )


def frequencies_alone(modes: ModalSet, rng: np.random.Generator) -> ModalSet:
    """Return w with noise of 1e-4 and zeta with noise of 1e-2, and these standard deviations."""
    wn = modes.wn * (1 + 1e-4 * rng.standard_normal(len(modes)))
    zeta = modes.zeta * (1 + 1e-2 * rng.standard_normal(len(modes)))
    return ModalSet.from_wn_zeta(wn, zeta, wn_std=1e-4 * modes.wn, zeta_std=1e-2 * modes.zeta)


DATA: Mapping[str, Callable[[ModalSet, np.random.Generator], ModalSet]] = {
    "exact, all shapes": lambda modes, rng: modes,  # noqa: ARG005
    "shapes known to 0.1 %": lambda modes, rng: with_noise(modes, rng, spread=1e-3),
    "shapes known to 3 %": lambda modes, rng: with_noise(modes, rng, spread=3e-2),
    "exact poles alone, with search": lambda modes, rng: ModalSet(poles=modes.poles),  # noqa: ARG005
    "w and zeta known to 1e-4 and 1e-2, with search": frequencies_alone,
}


def times(car: Suspension, data: str, *, repeats: int = REPEATS) -> RealArray:
    """Return the processor time of each of many reconstructions [s], after one that compiles what is kept."""
    exact, off, rng = eigenmodes(car), nominal(car), np.random.default_rng(0)
    spent = []
    for _ in range(repeats + 1):
        modes = DATA[data](exact, rng)
        start = time.process_time()
        reconstruct(modes, off)
        spent.append(time.process_time() - start)
    return np.array(spent[1:])


def times_table(*, repeats: int = REPEATS) -> str:
    """Return the table of times, in ms and in eigenvalue problems of the car in the same run."""
    columns: dict[str, list[str]] = {"car": [], "data": [], "mean [ms]": [], "p99 [ms]": [], "mean / eigenmodes": []}
    for name, car in TIMED.items():
        start = time.process_time()
        for _ in range(repeats):
            eigenmodes(car)
        unit = (time.process_time() - start) / repeats
        for data in DATA:
            spent = times(car, data, repeats=repeats)
            row = (name, data, f"{1e3 * spent.mean():.1f}", f"{1e3 * np.quantile(spent, 0.99):.1f}")
            for column, cell in zip(columns.values(), (*row, f"{spent.mean() / unit:.0f}"), strict=True):
                column.append(cell)
    return text_table(columns)


def report() -> str:
    """Return the tables of all cars."""
    parts = [
        f"# Springs and dampers from records at {SNR_DB:g} dB",
        f"Three channels, {TIMES[-1] + TIMES[1]:g} s at {1 / TIMES[1]:g} Hz, initial velocity of the tire, through "
        f"`identify` and `reconstruct` from a nominal car 30 % off; {SEEDS} draws of the noise. The bound is "
        f"Cramér-Rao's for the physical model: k, c and the initial state are unknown.",
    ]
    for name, car in CARS.items():
        found = study(car)
        columns = {
            "parameter": list(found.names),
            "true": [f"{value:g}" for value in found.truth],
            "RMSE": [f"{value:.3g}" for value in found.rmse],
            "bound": [f"{value:.3g}" for value in found.bound],
            "RMSE / bound": [f"{value:.2f}" for value in found.rmse / found.bound],
            "95 % intervals that hold": [f"{value:.0%}" for value in found.coverage],
        }
        parts.append(
            f"## {name}\n\n```\n{text_table(columns)}\n```\n\n"
            f"Chi-square accepts the topology in {found.explained:.0%} of the draws."
        )
    parts.append(
        f"## Time\n\nProcessor time of one `reconstruct` out of {REPEATS} in one process; BLAS threads: "
        f"{os.environ.get('OMP_NUM_THREADS', 'as many as the machine has')}. The milliseconds hold for this "
        f"machine only; the last column is the ratio to `eigenmodes` of the same car, in the same run.\n\n"
        f"```\n{times_table()}\n```"
    )
    return "\n\n".join(parts) + "\n"


if __name__ == "__main__":
    print(report())
