"""Other ways to springs and dampers, on the same records: what an engineer would do without suspid's estimator."""

from __future__ import annotations

import contextlib
import importlib
import io
import logging
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from suspid import ModalSet, Suspension, reconstruct
from suspid.records import as_response
from suspid.signals import as_signal
from suspid.units import ComplexArray, RealArray, Second
from validation.greybox_bounds import BAND

if TYPE_CHECKING:
    import control

SEGMENT = 2048  # samples of Welch's method, about 10 s
BLOCK_ROWS = 30  # of pyOMA_2's Hankel matrix
SLOWER = 4  # times the step of a drive, for pyOMA_2


def welch_h1(record: control.TimeResponseData, car: Suspension) -> RealArray:
    """Return k and c of the suspension from the transmissibility H1 of Welch's method, weighted by coherence."""
    from scipy.optimize import least_squares
    from scipy.signal import csd, welch

    signal = as_signal(record)
    body, wheel = (signal.values[signal.channels.index(f"{name}_acceleration")] for name in ("chassis", "tire"))
    size = min(SEGMENT, len(body) // 4)
    f, cross = csd(wheel, body, 1 / signal.step, nperseg=size)
    power, own = welch(wheel, 1 / signal.step, nperseg=size)[1], welch(body, 1 / signal.step, nperseg=size)[1]
    use = (f > BAND[0]) & (f < BAND[1])
    s, H = 2j * np.pi * f[use], (cross / power)[use]
    coherence = np.clip(np.abs(cross[use]) ** 2 / (power * own)[use], 0.0, 1 - 1e-6)
    weight = np.sqrt(coherence / (1 - coherence)) / np.abs(H)
    strut, mass = next(x for x in car.struts if x.name == "chassis"), car.masses["chassis"]
    start = np.array([strut.stiffness, strut.damping])

    def error(x: RealArray) -> RealArray:
        k, c = np.exp(x) * start
        left = weight * (H - (k + c * s) / (mass * s**2 + k + c * s))
        return np.concatenate([left.real, left.imag])

    return np.asarray(np.exp(least_squares(error, np.zeros(2)).x) * start)


def equation_error(record: control.TimeResponseData, car: Suspension) -> RealArray:
    """Return k and c by linear least squares of ``m a = -k x - c v``, integrated in the frequency domain."""
    signal = as_signal(record)
    body, wheel = (signal.values[signal.channels.index(f"{name}_acceleration")] for name in ("chassis", "tire"))
    window = np.hanning(len(body))
    f = np.fft.rfftfreq(len(body), signal.step)
    use = (f > BAND[0]) & (f < BAND[1])
    s = 2j * np.pi * f[use]
    travel = np.fft.rfft((body - wheel) * window)[use] / s**2
    J, y = -np.column_stack([travel, s * travel]), car.masses["chassis"] * np.fft.rfft(body * window)[use]
    return np.asarray(
        np.linalg.lstsq(np.concatenate([J.real, J.imag]), np.concatenate([y.real, y.imag]), rcond=None)[0]
    )


def era_and_reconstruct(record: control.TimeResponseData, nominal: Suspension, fixed: tuple[str, ...]) -> Suspension:
    """Return the car from the modes of python-control's ERA, its order given, by `reconstruct`."""
    import control

    signal = as_signal(record)
    count, order = signal.values.shape[1] // 4, 2 * len(nominal.masses)
    system = control.eigensys_realization(
        signal.values[:, None, :], r=order, m=count, n=count, dt=signal.step, transpose=False
    )[0]
    poles, vectors = np.linalg.eig(system.A)
    upper = poles.imag > 0
    return _rebuilt(
        np.log(poles[upper].astype(complex)) / signal.step,
        (np.asarray(system.C) @ vectors)[:, upper],
        signal.channels,
        nominal,
        fixed,
    )


def ssi_and_reconstruct(record: control.TimeResponseData, nominal: Suspension, fixed: tuple[str, ...]) -> Suspension:
    """Return the car from the modes of pyOMA_2's SSI-cov, its order given, by `reconstruct`.

    Accelerations on a road hardly show the modes of the body: they are integrated once, and taken at 50 Hz. The car
    has no mounts: modes do not tell them.
    """
    found = ssi_modes(_for_modes(record), len(nominal.masses))
    rigid = replace(nominal, struts=[replace(s, mount_stiffness=None) for s in nominal.struts])
    return reconstruct(found, rigid, fixed=fixed, tolerance=0.5, search=False).suspension


def _for_modes(record: control.TimeResponseData) -> control.TimeResponseData:
    """Return accelerations as velocities at a quarter of their rate, other records as they are."""
    from scipy.signal import decimate

    signal = as_signal(record)
    if not all(name.endswith("_acceleration") for name in signal.channels):
        return record
    count = signal.values.shape[1]
    f = np.fft.rfftfreq(count, signal.step)
    inverse = np.zeros(len(f), complex)
    inverse[f > BAND[0]] = 1 / (2j * np.pi * f[f > BAND[0]])
    whole = np.fft.irfft(np.fft.rfft(signal.values) * inverse, count)
    velocities = np.asarray(decimate(whole, SLOWER, ftype="fir"), float)
    times = np.asarray(SLOWER * signal.step * np.arange(velocities.shape[1]), float)
    return as_response(times, velocities, signal.channels)


def ssi_modes(record: control.TimeResponseData, modes: int) -> ModalSet:
    """Return the modes that pyOMA_2's SSI-cov finds, their number given.

    Raises
    ------
    ValueError
        If SSI finds another number of modes than the car has.
    """
    signal = as_signal(record)
    poles, shapes = ssi_poles(signal.values, signal.step, 2 * modes)
    if len(poles) != modes:
        raise ValueError(f"SSI finds {len(poles)} modes")
    return _modes(poles, shapes, signal.channels)


def ssi_poles(values: RealArray, step: Second, order: int) -> tuple[ComplexArray, ComplexArray]:
    """Return poles and shapes (channel, pole) that pyOMA_2's SSI-cov finds at an order."""
    setup, algorithms = importlib.import_module("pyoma2.setup"), importlib.import_module("pyoma2.algorithms")
    logging.getLogger("pyoma2").setLevel(logging.ERROR)
    no_limits = {"xi_max": 1.0, "mpc_lim": None, "mpd_lim": None, "CoV_max": None}
    ssi = algorithms.SSI(name="ssi", br=BLOCK_ROWS, ordmax=order, method="cov", hc=no_limits)
    single = setup.SingleSetup(values.T.copy(), 1 / step)
    single.add_algorithms(ssi)
    with contextlib.redirect_stderr(io.StringIO()):
        single.run_by_name("ssi")
    found = np.isfinite(ssi.result.Fn_poles[:, -1])
    return ssi.result.Lambds[found, -1], ssi.result.Phi_poles[found, -1].T


def _modes(poles: ComplexArray, shapes: ComplexArray, channels: tuple[str, ...]) -> ModalSet:
    """Return modes; the shapes of accelerations and velocities are those of displacements."""
    names = [name.removesuffix("_acceleration") for name in channels]
    return ModalSet(poles=poles, shapes=shapes, channels=names)


def _rebuilt(
    poles: ComplexArray, shapes: ComplexArray, channels: tuple[str, ...], nominal: Suspension, fixed: tuple[str, ...]
) -> Suspension:
    """Return the car with these modes."""
    return reconstruct(_modes(poles, shapes, channels), nominal, fixed=fixed, tolerance=0.5, search=False).suspension
