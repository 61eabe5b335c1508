"""Cramér-Rao bounds of springs and dampers, by differences of the independent motion of `validation.motion`."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from suspid import Suspension
from suspid.units import ComplexArray, Hertz, RealArray
from validation.motion import matrices

# Relative step of a difference: its error falls with the square of it, that of rounding grows with its inverse.
STEP = 1e-4
# Band of the lines that count [Hz].
BAND = (0.5, 25.0)
# Step of the time constant of a mount [s]: a mount of 1e6 N/m has a thousand times as much.
RELAXATION = 1e-6

Outputs = Callable[[Suspension], RealArray]


def value_of(car: Suspension, name: str) -> float:
    """Return a parameter such as ``"tire.stiffness"``."""
    strut, _, quantity = name.rpartition(".")
    return float(getattr(next(s for s in car.struts if s.name == strut), quantity))


def changed(car: Suspension, name: str, value: float) -> Suspension:
    """Return the car with one parameter changed."""
    strut, _, quantity = name.rpartition(".")
    return car.with_parameters(**{quantity: {strut: value}})


def time_bound(
    outputs: Outputs, car: Suspension, names: Sequence[str], *, std: RealArray, nuisance: RealArray
) -> RealArray:
    """Return the least standard deviations of parameters from channels (channel, sample) in white noise.

    ``nuisance`` are the motions, (column, channel, sample), of which the records hold unknown amounts: the start.
    Each channel has an unknown offset.
    """
    weight = 1 / std[:, None]
    columns = []
    for name in names:
        value = value_of(car, name)
        high, low = (outputs(changed(car, name, value * (1 + sign * STEP))) for sign in (1, -1))
        columns.append(((high - low) / (2 * STEP) * weight).ravel())
    offsets = np.eye(len(std))[:, :, None] * np.ones((1, 1, nuisance.shape[2]))
    others = np.array([(row * weight).ravel() for row in (*nuisance, *offsets)]).T
    basis, _ = np.linalg.qr(others / np.linalg.norm(others, axis=0))
    J = np.array(columns).T
    J -= basis @ (basis.T @ J)
    relative = np.sqrt(np.diag(np.linalg.inv(J.T @ J)))
    return np.asarray(relative * [value_of(car, name) for name in names])


def noisy_bound(
    outputs: Outputs,
    car: Suspension,
    names: Sequence[str],
    *,
    std: RealArray,
    nuisance: RealArray,
    rate: Hertz,
    input_std: float,
    input_of: int,
) -> RealArray:
    """Return the least standard deviations of parameters where the input of `motion.matrices` is measured with noise.

    The input's true motion is free at every line: a line is known with the covariance of the outputs' noise and that of
    the input's noise through the car. Motions under the true input, and the nuisance as in `time_bound`, are from the
    independent integrator.
    """
    columns = []
    for name in names:
        value = value_of(car, name)
        high, low = (outputs(changed(car, name, value * (1 + sign * STEP))) for sign in (1, -1))
        columns.append((high - low) / (2 * STEP))
    lines = np.fft.rfft(np.array([*columns, *nuisance]))[:, :, 1:-1]
    s: ComplexArray = np.asarray(2j * np.pi * np.fft.rfftfreq(nuisance.shape[2], 1 / rate)[1:-1], np.complex128)
    A, B, P, Q = matrices(car)
    roads = len(car.roads)
    by_input, seen = B[:, input_of] + 0j * s[:, None], Q[:, input_of] + 0j * s[:, None]
    if input_of < roads:
        by_input, seen = by_input + s[:, None] * B[:, roads + input_of], seen + s[:, None] * Q[:, roads + input_of]
    states = np.linalg.solve(s[:, None, None] * np.eye(len(A)) - A, by_input[:, :, None])[:, :, 0]
    T = states @ P.T + seen
    R = nuisance.shape[2] * (np.diag(std**2) + input_std**2 * T[:, :, None] * T[:, None, :].conj())
    J = lines.transpose(2, 1, 0)
    size = np.sqrt(np.sum(np.abs(J) ** 2, axis=(0, 1)))
    information = 2 * np.real(np.einsum("fqi,fqj->ij", (J / size).conj(), np.linalg.solve(R, J / size)))
    relative = (np.sqrt(np.diag(np.linalg.inv(information))) / size)[: len(names)]
    return np.asarray(relative * [value_of(car, name) for name in names])


def given_bound(
    transfer: Callable[[Suspension, ComplexArray], ComplexArray],
    car: Suspension,
    names: Sequence[str],
    *,
    wheels: RealArray,
    rate: Hertz,
    std_body: RealArray,
    std_wheels: RealArray,
    unknown: Sequence[str] = (),
    pushed: Sequence[tuple[RealArray, RealArray]] = (),
) -> RealArray:
    """Return the least standard deviations of parameters where the motion of wheels is measured, with noise.

    ``transfer`` gives T (line, body channel, wheel). The wheels' true motion (wheel, sample) is free at every line, so
    the information of a line is that of ``Y_q - T Y_g`` with the covariance ``S_q + T S_g T^H``. Starts are left out.
    ``unknown`` names what is too: ``"gains"`` and ``"delays"`` of the wheels' sensors, ``"mounts"`` of the dampers in
    ``names``.
    ``pushed`` are clean motions (channel or wheel, sample) of body and wheels under forces alone, to be averaged: what
    of them does not follow the wheels is noise of known spectrum.
    """
    count = wheels.shape[1]
    f = np.fft.rfftfreq(count, 1 / rate)
    use = (f > BAND[0]) & (f < BAND[1])
    s: ComplexArray = np.asarray(2j * np.pi * f[use], np.complex128)
    G = np.fft.rfft(wheels)[:, use].T
    T = transfer(car, s)
    R = count * (np.einsum("fqw,w,fpw->fqp", T, std_wheels**2, T.conj()) + np.diag(std_body**2))
    for bodies, moved in pushed:
        left = np.fft.rfft(bodies)[:, use].T - np.einsum("fqw,wf->fq", T, np.fft.rfft(moved)[:, use])
        R += np.einsum("fq,fp->fqp", left, left.conj()) / len(pushed)
    columns = []
    for name in names:
        value = value_of(car, name)
        high, low = (transfer(changed(car, name, value * (1 + sign * STEP)), s) for sign in (1, -1))
        columns.append(np.einsum("fqw,fw->fq", (high - low) / (2 * STEP), G))
    # A gain and a delay turn and stretch the column of their wheel.
    for w in range(len(wheels)):
        turned = T[:, :, w] * G[:, w, None]
        columns += [turned] * ("gains" in unknown) + [turned * s[:, None]] * ("delays" in unknown)
    dampers = [name.partition(".")[0] for name in names if name.endswith(".damping")]
    for name in dampers if "mounts" in unknown else ():
        damping = value_of(car, f"{name}.damping")
        relaxation = next(strut.relaxation for strut in car.struts if strut.name == name)
        pair = [
            transfer(car.with_parameters(mount_stiffness={name: damping / rho}), s)
            for rho in (relaxation + RELAXATION, relaxation + 2 * RELAXATION)
        ]
        columns.append(np.einsum("fqw,fw->fq", pair[1] - pair[0], G) / RELAXATION)
    J = np.stack(columns, axis=2)
    # A line is complex: the variance of its real and of its imaginary part is half of R each.
    information = 2 * np.real(np.einsum("fqi,fqj->ij", J.conj(), np.linalg.solve(R, J)))
    size = np.sqrt(np.diag(information))
    relative = (np.sqrt(np.diag(np.linalg.inv(information / np.outer(size, size)))) / size)[: len(names)]
    return np.asarray(relative * [value_of(car, name) for name in names])


def transfer_of(
    channels: Sequence[Sequence[float]], body: Sequence[int], wheels: Sequence[int]
) -> Callable[[Suspension, ComplexArray], ComplexArray]:
    """Return T of accelerations of the body from accelerations of the wheels, by coordinate.

    ``D(s) q = N(s) g`` with the coordinates q of the body alone; a strut is ``k + c s / (1 + rho s)``.
    """

    def transfer(car: Suspension, s: ComplexArray) -> ComplexArray:
        arms = np.array([[strut.arms.get(name, 0.0) for name in car.masses] for strut in car.struts])
        c = np.array([strut.damping for strut in car.struts])
        rho = np.array(
            [strut.damping / strut.mount_stiffness if strut.mount_stiffness else 0.0 for strut in car.struts]
        )
        b = [strut.stiffness for strut in car.struts] + c * s[:, None] / (1 + rho * s[:, None])
        mass = np.diag(list(car.masses.values()))
        whole = s[:, None, None] ** 2 * mass + np.einsum("fj,ji,jk->fik", b, arms, arms)
        motion = -np.linalg.solve(whole[:, body][:, :, body], whole[:, body][:, :, wheels])
        return np.asarray(np.einsum("cb,fbw->fcw", np.array(channels), motion))

    return transfer
