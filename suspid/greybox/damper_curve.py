"""Force of a damper over its velocity, from a record of driving."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from suspid.arguments import explained
from suspid.cleaning import RecordLike
from suspid.errors import EstimationError, InputError, RecordError
from suspid.greybox.curve_checks import checks_of
from suspid.greybox.curve_fit import CurveFit, Noise, Shape, first_spline, fitted_curve
from suspid.greybox.curve_following import CURVE_LEVEL, Following
from suspid.greybox.curve_noise import Residual, drawn_noises, misfit_of, noise_of, probes, residual_of
from suspid.greybox.curve_settling import QUIET, is_lost, of_both_readings, settled
from suspid.greybox.curve_travel import travel_fit
from suspid.greybox.damper_curves import DamperCurve
from suspid.greybox.force_basis import MOST_NODES, SAMPLES_A_NODE, bend_covariance, placed_nodes
from suspid.greybox.latent_splines import CORNER_SHARE
from suspid.greybox.line_test import line_test
from suspid.greybox.strut_motion import StrutMotion, strut_motion
from suspid.greybox.trials import records_of
from suspid.levels import check_level, likely
from suspid.model import Suspension
from suspid.threads import in_one_thread
from suspid.units import Ratio, RealArray
from suspid.values import frozen_real
from suspid.words import Remark, Verdict
from suspid.words.dampers import CurveHeadline

# First node, in changes of velocity within the time constant of the filter.
FIRST_NODE = 1.5
# More nodes may not be asked for: the time grows with their square, and each needs samples.
MOST_ASKED = 100


@explained
@in_one_thread
def damper_curve(
    records: RecordLike | Sequence[RecordLike],
    suspension: Suspension,
    *,
    strut: str,
    given: Sequence[str] | None = None,
    friction: bool = True,
    nodes: int | None = None,
    level: Ratio = CURVE_LEVEL,
) -> DamperCurve:
    """Find the force of a damper over its velocity, its friction and the stiffness of the parallel spring.

    The accelerations of the sprung masses give the force in the strut; with that of the wheel, or a travel sensor, they
    also give its motion. Force and motion are compared without knowing the road: the true motion is unknown at every
    sample, and both signals have noise of unknown level (errors in variables). The curve is straight between nodes;
    there are enough of them to follow kinks.

    Parameters
    ----------
    records : control.TimeResponseData, or what `as_record` takes, or sequence of them
        Accelerations of the sprung masses, and that of the other end of the strut or its travel, named as the outputs
        of `statespace` or as the sensors of the suspension.
    suspension : Suspension
        Masses and topology; stiffness and damping of the strut are the start.
    strut : str
        The strut whose damper is identified.
    given : sequence of str, optional
        Coordinates whose motion is given by their sensors. Default: those that stand on a road.
    friction : bool
        Whether the damper may have Coulomb friction.
    nodes : int, optional
        Number of nodes, not counting that at rest. Default: one for each 200 samples, at most 36; 100 at most.
    level : float
        Share of viscous dampers that the test whether the curve is a line rejects [1].

    Returns
    -------
    DamperCurve
        ``velocities``, ``forces``, ``friction``, ``stiffness``, their covariance, and ``linear``, the test whether
        the damper is viscous.

    Raises
    ------
    InputError
        If a name is unknown, or the forces of the struts do not follow from the accelerations of the sprung masses.
    RecordError
        If a channel is missing, a record is too short, or samples are far from all others.
    EstimationError
        If the records do not determine the curve: not even the sign of its largest force.

    Notes
    -----
    Gains and delays of the sensors are taken as known: 2 ms between the sensors of body and wheel make the stiffness
    of a car wrong by a quarter. `estimate` finds them; correct the record before. The same holds for a rubber mount.
    Intervals are those of the scores' scatter over blocks of half a second, and of kinks between the nodes.
    With a sensor of travel the force is compared with the one that is expected under the travel, averaged over the
    error of the velocity (regression calibration), and moments at which the strut sticks are left out. Travel with
    0.02 mm of noise at 200 Hz determines friction half as well as the acceleration of the wheel.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import quarter_car, road_profile, simulate
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=1300, tire_damping=60)
    >>> bilinear = car.with_parameters(curve={"chassis": ((-1.0, -650.0), (0.0, 0.0), (1.0, 1950.0))})
    >>> t, rng = np.arange(0, 12, 0.005), np.random.default_rng(1)
    >>> road = road_profile(20 * t, roughness="B", rng=rng, wavelengths=(0.5, 100.0))
    >>> record = simulate(bilinear, t, {"road": road}, outputs=["chassis_acceleration", "tire_acceleration"],
    ...                   interpolation="cubic")
    >>> record.outputs[:] += np.array([[0.03], [0.1]]) * rng.standard_normal(record.outputs.shape)
    >>> found = damper_curve(record, car, strut="chassis", nodes=12)
    >>> bool(found.linear), bool(abs(found.stiffness / 22e3 - 1) < 0.02)
    (False, True)
    """
    check_level(level)
    if nodes is not None and (not isinstance(nodes, int | np.integer) or not 4 <= nodes <= MOST_ASKED):
        raise InputError(f"{nodes=} must be a whole number from 4, two on each side of rest, to {MOST_ASKED}")
    motions = _motions(records, suspension, strut, given)
    start = next(s for s in suspension.struts if s.name == strut)
    wide = Shape(nodes=np.array([-1.0, 0.0, 1.0]), friction=False)
    theta = np.array([start.stiffness, -start.damping, start.damping])
    try:
        if motions[0].travel:
            fit, shape, noise, left = travel_fit(motions, lambda v: _shape(motions, v, nodes, friction), probes())
            return _result(left, suspension, strut, shape, _known(fit, shape, strut), noise, level)
        noise = _first_noise(motions)
        fit = fitted_curve(motions, wide, theta, [first_spline(m) for m in motions], noise)
        velocity = np.concatenate([part.velocity for part in fit.records])
        shape = _shape(motions, velocity, nodes, friction)
        theta = _onto(fit.theta, wide, shape)
        fit = fitted_curve(motions, shape, theta, fit.splines, noise)
        noise, theta = noise_of(residual_of(motions, fit, drawn_noises(motions, fit, shape, noise)), noise), fit.theta
        fit = fitted_curve(motions, shape, theta, fit.splines, noise)
    except (np.linalg.LinAlgError, ValueError) as error:
        raise EstimationError(
            f"the records do not determine the curve of strut {strut!r} ({error}); use a longer or rougher record, or "
            f"fewer nodes"
        ) from None
    fit, noise = settled(motions, shape, fit, noise)
    fit, noise, left, follows = of_both_readings(motions, shape, fit, noise)
    return _result(left, suspension, strut, shape, _known(fit, shape, strut), noise, level, follows)


def _known(fit: CurveFit, shape: Shape, strut: str) -> CurveFit:
    """Return a fit that tells the curve; refuse one that does not."""
    if not is_lost(shape, fit):
        return fit
    raise EstimationError(
        f"the records do not determine the curve of strut {strut!r}: not even the sign of its largest force is known. "
        f"A force of its own pushes the body (wind, a passenger, another axle), or friction holds the strut, or a "
        f"sensor is wrong (sign, gain, delay); use a rougher road, or a longer record"
    )


def _motions(records: object, car: Suspension, strut: str, given: Sequence[str] | None) -> tuple[StrutMotion, ...]:
    if not isinstance(car, Suspension):
        raise InputError(f"damper_curve needs a Suspension here, not {type(car).__name__}")
    motions = tuple(strut_motion(one, car, strut, given) for one in records_of(records))
    steps = [m.step for m in motions]
    if max(steps) > min(steps) * (1 + 1e-6) or len({m.travel for m in motions}) > 1:
        raise RecordError("the records differ in their rates or in the sensors of the strut; resample them to one rate")
    return motions


def _first_noise(motions: Sequence[StrutMotion]) -> Noise:
    one = motions[0]
    return Noise(force=QUIET / max(abs(one.share), 1e-12), motion=QUIET)


def _shape(motions: Sequence[StrutMotion], velocity: RealArray, nodes: int | None, friction: bool) -> Shape:
    """Return the nodes: the first at the change of velocity within the time that the filter leaves apart."""
    step = motions[0].step
    count = min(MOST_NODES, len(velocity) // SAMPLES_A_NODE) if nodes is None else nodes
    change = float(np.sqrt(np.mean(np.diff(velocity) ** 2))) / step
    return Shape(
        nodes=placed_nodes(velocity, max(count, 4), FIRST_NODE * change / (2 * np.pi * CORNER_SHARE / step)),
        friction=friction,
    )


def _onto(theta: RealArray, old: Shape, new: Shape) -> RealArray:
    """Return the unknowns of one shape on the nodes of another."""
    slope = np.where(new.moving > 0, old.forces(theta)[-1] / old.nodes[-1], old.forces(theta)[0] / old.nodes[0])
    return np.concatenate([theta[:1], slope * new.moving, [0.0] if new.friction else []])


def _result(
    left: Residual,
    car: Suspension,
    strut: str,
    shape: Shape,
    fit: CurveFit,
    noise: Noise,
    level: Ratio,
    follows: Following | None = None,
) -> DamperCurve:
    velocity = np.concatenate([part.velocity for part in fit.records])
    line = line_test(shape, fit, level)
    chi_square, freedom = misfit_of(left)
    size = len(shape.nodes)
    spread = np.zeros((size + 2, len(fit.theta)))
    spread[0, 0] = 1
    spread[1 : size + 1][shape.nodes != 0, 1:size] = np.eye(size - 1)
    if shape.friction:
        spread[-1, -1] = 1
    forces, covariance = shape.forces(fit.theta), spread @ fit.covariance @ spread.T
    covariance[1:-1, 1:-1] += bend_covariance(shape.nodes, forces)
    made = DamperCurve(
        name=strut,
        suspension=car,
        velocities=frozen_real(shape.nodes),
        forces=frozen_real(forces),
        friction=float(fit.theta[-1]) if shape.friction else 0.0,
        stiffness=float(fit.theta[0]),
        covariance=frozen_real(covariance),
        friction_sought=shape.friction,
        linear=line,
        velocity_std=float(np.sqrt(np.mean(velocity**2))),
        noise_std=(noise.force, noise.motion),
        chi_square=chi_square,
        freedom=freedom,
        following=float("nan") if follows is None else follows.statistic,
        explains=likely(chi_square, freedom) if follows is None else not (follows or follows.pushed),
        # What follows the motion is not told from a force of its own that moves the strut.
        followed=float("nan") if follows is None or follows.pushed else follows.share,
        verdict=Verdict(Remark(CurveHeadline.LINE if line else CurveHeadline.CURVE, {"strut": strut})),
    )
    checks = checks_of(made, fit, noise, follows=bool(follows))
    return replace(made, verdict=Verdict(made.verdict.headline, tuple(checks)))
