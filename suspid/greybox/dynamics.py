"""Motion of a suspension under known inputs, with its derivatives by every parameter, exact at the samples.

The state is ``x = (q, v, d)``: coordinates, velocities, and the elongation of each damper that is on a mount. Inputs
are polynomials of fifth degree between samples, with coefficients ``w = (u, u', u'', …)`` each. With
``x' = F (x, w)``, a parameter changes F by a matrix of rank one, ``b f^T``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from suspid.model import Suspension
from suspid.units import RealArray, Second

DEGREE = 6  # coefficients of an input between two samples
# A power series of this number of terms is exact to rounding where the norm of its argument is at most `SHORT`.
SHORT, TERMS = 0.5, 14


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Plant:
    """The equations of motion at given parameters, and how parameters change them."""

    F: RealArray  # (state, state and input coefficient)
    b: RealArray  # (parameter, state)
    f: RealArray  # (parameter, state and input coefficient)

    @property
    def states(self) -> int:
        """Number of states."""
        return len(self.F)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Transition:
    """One sampling step: ``x(k + 1) = E x(k) + G w(k)``, and the derivatives of both by every parameter."""

    E: RealArray  # (state, state)
    G: RealArray  # (state, input coefficient)
    by_state: RealArray  # (parameter, state, state): derivatives of E
    by_input: RealArray  # (parameter, state, input coefficient): derivatives of G
    shift: RealArray  # (input coefficient, input coefficient): those of a polynomial one step later


def plant_of(
    car: Suspension,
    p: RealArray,
    rows: Sequence[int],
    *,
    roads: Sequence[int],
    forces: RealArray,
    mounts: Sequence[int] = (),
) -> Plant:
    """Return the equations of motion with parameters p, and their slopes by the parameters ``rows``.

    p holds k of every strut, c of every strut, every mass, and the relaxation of the struts ``mounts``, in this order.
    ``roads`` are the indices of the roads that are inputs; the others do not move. ``forces`` are the weights of the
    forces that are inputs, (force, coordinate).
    """
    n, struts = len(car.coordinates), len(car.struts)
    k, c, mass = p[:struts], p[struts : 2 * struts], p[2 * struts : 2 * struts + n]
    arms, road_arms = car.arms(car.coordinates), car.arms(car.roads)[:, list(roads)]
    known = [s.mount_stiffness for s in car.struts]
    mounted = [i for i in range(struts) if i in mounts or (known[i] is not None and c[i] > 0)]
    size = 2 * n + len(mounted)
    width = size + DEGREE * (len(roads) + len(forces))
    # Elongation of each strut and its rate in terms of states and input coefficients.
    stretch, rate = np.zeros((struts, width)), np.zeros((struts, width))
    stretch[:, :n], rate[:, n : 2 * n] = arms, arms
    for i in range(len(roads)):
        stretch[:, size + DEGREE * i], rate[:, size + DEGREE * i + 1] = road_arms[:, i], road_arms[:, i]
    pull = np.zeros((struts, size))
    pull[:, n : 2 * n] = -arms / mass
    F = np.zeros((size, width))
    F[:n, n : 2 * n] = np.eye(n)
    F += pull.T @ (k[:, None] * stretch)
    plain = [i for i in range(struts) if i not in mounted]
    F += pull[plain].T @ (c[plain, None] * rate[plain])
    for i, weights in enumerate(forces):
        F[n : 2 * n, size + DEGREE * (len(roads) + i)] = weights / mass
    on_damper, by_damper = rate.copy(), pull.copy()
    on_mount, by_mount = np.zeros((len(mounts), width)), np.zeros((len(mounts), size))
    for place, i in enumerate(mounted, 2 * n):
        strained, own = stretch[i].copy(), np.eye(size)[place]
        strained[place] = -1.0
        if i in mounts:
            # The relaxation is the parameter: the mount's stiffness is c over it.
            which = list(mounts).index(i)
            relaxation = p[2 * struts + n + which]
            on_damper[i] = strained / relaxation
            on_mount[which], by_mount[which] = -strained / relaxation**2, c[i] * pull[i] + own
        else:
            relaxation = c[i] / float(known[i] or np.inf)
            on_damper[i], by_damper[i] = -strained / (relaxation * c[i]), own
        F += np.outer(c[i] * pull[i] + own, strained / relaxation)
    inertia = np.eye(size)[n : 2 * n]
    b = np.concatenate([pull, by_damper, -inertia / mass[:, None], by_mount])
    f = np.concatenate([stretch, on_damper, F[n : 2 * n], on_mount])
    return Plant(F=F, b=b[list(rows)], f=f[list(rows)])


def transition(plant: Plant, step: Second) -> Transition:
    """Return one sampling step and its derivatives: the exponential of F and its derivative along ``b f^T``.

    Both by their power series over a short time, then by doubling: ``E(2t) = E^2``, ``dE(2t) = E dE + dE E``.
    """
    size, width = plant.F.shape
    whole = np.zeros((width, width))
    whole[:size] = plant.F
    for i in range(size, width):
        if (i - size) % DEGREE < DEGREE - 1:
            whole[i, i + 1] = 1.0
    doublings = max(0, int(np.ceil(np.log2(np.linalg.norm(whole, 1) * step / SHORT))))
    scale = step / 2**doublings
    whole *= scale
    turned = np.zeros((len(plant.b), width, width))
    turned[:, :size] = scale * plant.b[:, :, None] * plant.f[:, None, :]
    term, slope_term = np.eye(width), np.zeros_like(turned)
    power, slopes = term.copy(), slope_term.copy()
    for order in range(1, TERMS + 1):
        slope_term = (turned @ term + whole @ slope_term) / order
        term = whole @ term / order
        power += term
        slopes += slope_term
    for _ in range(doublings):
        slopes = power @ slopes + slopes @ power
        power = power @ power
    slopes = slopes[:, :size]
    return Transition(
        E=power[:size, :size],
        G=power[:size, size:],
        by_state=slopes[:, :, :size],
        by_input=slopes[:, :, size:],
        shift=power[size:, size:],
    )
