"""State feedback for an actuator in a strut: least variances on a random road, as a convex program."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from suspid.arguments import explained
from suspid.errors import InputError, SuspidError
from suspid.performance.active_tuning import ActiveTuning
from suspid.performance.choices import REACHED
from suspid.performance.closed_loops import possible
from suspid.performance.plant import outputs_wanted, plant, slope_density
from suspid.performance.plausibility import plausible
from suspid.performance.ride import HOUR
from suspid.performance.uncertain import Car, Uncertain, uncertain
from suspid.simulation import Road
from suspid.units import RealArray
from suspid.values import FrozenMapping, frozen_real
from suspid.words import Check, Level, Remark, Verdict
from suspid.words.active import ActiveCheck, ActiveHeadline
from suspid.words.ride import RideCheck

# Fastest pole of a closed loop that an actuator could follow [Hz]; hydraulic and electric ones end at 10 to 100 Hz.
FASTEST_LOOP = 300.0


@explained
def tune_active(
    car: Car,
    *,
    actuator: str,
    objective: Mapping[str, float],
    limits: Mapping[str, float] | None = None,
    peaks: Mapping[str, float] | None = None,
    road: Road | str | float,
    speed: float | None = None,
) -> ActiveTuning:
    """Return the state feedback of an actuator that makes variances least, with limits on others.

    Parameters
    ----------
    car : Suspension, Estimate or Reconstruction
        A car with one road.
    actuator : str
        The displacement on which the force does work, as in `statespace`: ``"chassis_travel"`` pushes the ends of that
        strut apart.
    objective : mapping of str to float
        Outputs of `statespace`, or ``"force"``, with the value of each that counts as one, such as
        ``{"chassis_acceleration": 1.0, "tire_travel": 0.003}``: the sum of squares of their rms over it is least.
    limits : mapping of str to float, optional
        Largest rms of outputs, or of the ``"force"``.
    peaks : mapping of str to float, optional
        Largest gain of outputs at any frequency, from the road's slope in time [m/s], or of the ``"force"``.
    road, speed
        As in `ride`; the road counts by its roughness, with exponent 2 and all wavelengths.

    Returns
    -------
    ActiveTuning
        Gain, rms of the outputs with and without control, closed loop.

    Raises
    ------
    InputError
        If the car has several roads, a name is unknown, an output is infinite on white slopes, or no feedback
        keeps the limits.

    Notes
    -----
    With ``x' = A x + B u + G w``, w white, and ``u = Y X^-1 x`` the variances W of the outputs are bounded by the
    linear matrix inequalities ``A X + X A' + B Y + Y' B' + G G' <= 0`` and ``[W, C X + D Y; ., X] >= 0`` (S. Boyd et
    al., Linear Matrix Inequalities in System and Control Theory, SIAM 1994, 7.2 and 10.4). Without limits the gain is
    that of `control.lqr`. A gain g at all frequencies is kept by the bounded real lemma with the same X, which is
    sufficient and not necessary (C. Scherer, P. Gahinet and M. Chilali, IEEE Trans. Automatic Control 42, 1997,
    896-911): peaks may stay below their limits, and the cost above its bound.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=1300)
    >>> found = tune_active(car, actuator="chassis_travel", road="C", speed=20.0,
    ...                     objective={"chassis_acceleration": 1.0, "tire_travel": 0.004},
    ...                     limits={"chassis_travel": 0.012})
    >>> found.rms["chassis_acceleration"] < found.passive["chassis_acceleration"]
    True
    """
    if not isinstance(actuator, str):
        raise InputError(f"{actuator=!r:.40} must be the name of a displacement, such as 'chassis_travel'")
    names, wanted = outputs_wanted(objective, limits or {}, peaks or {})
    about = uncertain(car)
    level, driven = slope_density(about.car, road, speed)
    A, B, G, C, D, states = plant(about.car, actuator, names)
    noise = level * np.outer(G, G)
    from scipy.linalg import solve_continuous_lyapunov

    still = solve_continuous_lyapunov(A, -noise)
    passive = np.sqrt(np.maximum(np.einsum("is,st,it->i", C, still, C), 0.0))
    tops = {names.index(name): top for name, top in (peaks or {}).items()}
    # The program is solved with costs of the size of one: the largest term of the passive car.
    ones = np.array([one for one, _ in wanted.values()])
    size = float(np.max(passive / np.where(ones > 0, ones, np.inf)))
    if not (size or limits or peaks):
        raise InputError("objective: force alone is smallest at zero; add an output of the car, or limits")
    size = size or 1.0
    ask = (A, B, G, level, C, D, np.sqrt(np.diag(still)), [(one * size, top) for one, top in wanted.values()])
    gain, reached = _program(*ask, tops)
    bound = size**2 * (_program(*ask, {})[1] if tops else reached)
    reached *= size**2
    closed_A, closed_C = A - np.outer(B, gain), C - np.outer(D, gain)
    if np.max(np.linalg.eigvals(closed_A).real) >= 0:
        raise SuspidError("the feedback found does not stabilise the car; change the scales or the limits")
    with warnings.catch_warnings():
        # Where nothing holds the force the gains are without end, which the verdict says.
        warnings.simplefilter("ignore", RuntimeWarning)
        P = solve_continuous_lyapunov(closed_A, -noise)
    rms = np.sqrt(np.maximum(np.einsum("is,st,it->i", closed_C, P, closed_C), 0.0))
    found = dict(zip(names, rms.tolist(), strict=True))
    cost = sum((found[name] / one) ** 2 for name, (one, _) in wanted.items() if one)
    late = [name for name, (_, top) in wanted.items() if top and found[name] > top * (1 + REACHED)]
    if late or cost > reached * (1 + REACHED):
        raise SuspidError(f"the convex program was not solved accurately: cost {cost:.6g}, bound {reached:.6g}")
    import control

    return ActiveTuning(
        gain=frozen_real(gain),
        states=states,
        rms=FrozenMapping(found),
        passive=FrozenMapping(dict(zip(names, passive.tolist(), strict=True))),
        cost=float(cost),
        bound=float(bound),
        closed=control.ss(
            closed_A, G[:, None], closed_C, 0, states=list(states), inputs=["road_slope"], outputs=list(names)
        ),
        verdict=Verdict(
            Remark(ActiveHeadline.FEEDBACK, {"actuator": actuator, "names": tuple(objective)}),
            (
                *plausible(about.car),
                *_doubts(about),
                *_held(D, closed_A),
                *possible(about.car, actuator, gain, level, driven, HOUR),
                *_reached(float(cost), float(bound), peaks=bool(peaks)),
            ),
        ),
    )


def _doubts(about: Uncertain) -> Iterator[Check]:
    if about.doubt is not None:
        yield Check(Remark(RideCheck.UNTRUSTED, {"level": about.doubt.label}), about.doubt)


def _held(direct: RealArray, closed: RealArray) -> Iterator[Check]:
    """Yield whether what is asked for leaves the force free, and whether the closed loop is too fast."""
    if not np.any(direct):
        yield Check(Remark(ActiveCheck.UNBOUNDED), Level.DOUBTFUL)
    hertz = float(np.max(np.abs(np.linalg.eigvals(closed)))) / (2 * np.pi)
    if hertz > FASTEST_LOOP:
        yield Check(Remark(ActiveCheck.FAST, {"hertz": hertz, "limit": FASTEST_LOOP}), Level.CARE)


def _reached(cost: float, bound: float, *, peaks: bool) -> Iterator[Check]:
    share = max(cost / bound - 1, 0.0) if bound > 0 else 0.0
    if peaks and share > REACHED:
        yield Check(Remark(ActiveCheck.ABOVE, {"share": share}), Level.NOTE)
    else:
        yield Check(Remark(ActiveCheck.OPTIMAL, {"share": max(share, REACHED)}), Level.SOUND)


def _program(
    A: RealArray,
    B: RealArray,
    G: RealArray,
    level: float,
    C: RealArray,
    D: RealArray,
    scale: RealArray,
    wanted: list[tuple[float, float]],
    peaks: Mapping[int, float],
) -> tuple[RealArray, float]:
    """Return the gain and the least cost, by the convex program in states and a force of the size of one."""
    import cvxpy

    cp: Any = cvxpy
    a, b = A * scale / scale[:, None], B / scale
    force = float(np.max(np.abs(a)) / np.max(np.abs(b)))
    b, n = b * force, len(A)
    X, Y = cp.Variable((n, n), symmetric=True), cp.Variable((1, n))
    moved, g = a @ X + b[:, None] @ Y, (G / scale)[:, None]
    constraints = [moved + moved.T + level * (g @ g.T) << 0]
    costs = []
    for row, direct, (one, top) in zip(C * scale, D * force, wanted, strict=True):
        unit = one or top
        if not unit:
            continue
        W = cp.Variable((1, 1))
        y = (row[None, :] @ X + direct * Y) / unit
        constraints.append(cp.bmat([[W, y], [y.T, X]]) >> 0)
        if top:
            constraints.append((top / unit) ** 2 >= W)
        if one:
            costs.append(W[0, 0])
    for index, top in peaks.items():
        # In units in which white noise of the road has the density one, as in X.
        y = (C[index] * scale)[None, :] @ X + D[index] * force * Y
        y, g_road = y / (top * np.sqrt(level)), np.sqrt(level) * g
        constraints.append(
            cp.bmat([[-(moved + moved.T), -g_road, -y.T], [-g_road.T, np.eye(1), np.zeros((1, 1))],
                     [-y, np.zeros((1, 1)), np.eye(1)]]) >> 0
        )  # fmt: skip
    problem = cp.Problem(cp.Minimize(sum(costs)), constraints)
    with warnings.catch_warnings():
        # Whether the solution is accurate is judged by the closed loop.
        warnings.simplefilter("ignore", UserWarning)
        try:
            problem.solve(solver=cp.CLARABEL)
        except cp.SolverError:
            raise SuspidError(
                "the convex program was not solved: a limit or a scale is far from the motion of the car; change it"
            ) from None
    if problem.status in ("infeasible", "infeasible_inaccurate"):
        raise InputError("no state feedback meets the limits" + (" and peaks together" * bool(peaks)) + "; raise them")
    if X.value is None or Y.value is None:
        raise SuspidError(f"the convex program was not solved: {problem.status}")
    gain = -force * np.linalg.solve(X.value, Y.value[0]) / scale
    return np.asarray(gain), float(problem.value)
