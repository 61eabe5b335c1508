"""State feedback by a convex program, beside control.lqr and simulation."""

import re

import control
import numpy as np
import pytest

from suspid import ActiveTuning, InputError, SuspidError, quarter_car, ride, road, statespace, tune_active
from suspid.words.active import ActiveCheck
from suspid.words.remarks import Code
from suspid.words.ride import RideCheck
from validation.cars import TWO_AXLES

CAR = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300)
OBJECTIVE = {"chassis_acceleration": 1.0, "tire_travel": 0.004, "chassis_travel": 0.02}


def test_without_limits_it_is_lqr() -> None:
    found = tune_active(CAR, actuator="chassis_travel", objective=OBJECTIVE, road="C", speed=20.0)
    system = statespace(CAR, outputs=list(OBJECTIVE), forces=["chassis_travel"])
    scale = np.array(list(OBJECTIVE.values()))
    C, D = np.asarray(system.C) / scale[:, None], np.asarray(system.D)[:, 0] / scale
    A, B = np.asarray(system.A), np.asarray(system.B)
    gain, _, _ = control.lqr(A, B, C.T @ C, np.array([[D @ D]]), (C.T @ D)[:, None])
    # Flat about its least: the cost agrees to the square of what the gain does.
    np.testing.assert_allclose(found.gain, gain[0], rtol=1e-3, atol=1e-3 * np.max(np.abs(gain)))
    assert found.cost == pytest.approx(found.bound, rel=1e-5)


def test_without_limits_it_is_h2_optimal() -> None:
    """The H2 controller of the states with almost no noise on them costs as much; python-control finds it by SLICOT."""
    pytest.importorskip("slycot")
    found = tune_active(CAR, actuator="chassis_travel", objective=OBJECTIVE, road="C", speed=20.0)
    system = statespace(CAR, outputs=list(OBJECTIVE), forces=["chassis_travel"])
    # Displacements count from the road, so its slope in time moves all of them down.
    slope = np.array([[-1.0 if name.startswith("z_") else 0.0] for name in found.states])
    level = (2 * np.pi * 0.1) ** 2 * 256e-6 * 20.0 / 2
    states, seen, kilo, noise = len(slope), np.eye(len(slope)), 1e3, 1e-5
    scale = np.array(list(OBJECTIVE.values()))[:, None]
    still = np.zeros((len(scale), 1 + states))
    plant = control.ss(
        system.A,
        np.hstack([slope * np.sqrt(level), 0 * seen, kilo * np.asarray(system.B)]),
        np.vstack([np.asarray(system.C) / scale, seen]),
        np.block(
            [
                [still, kilo * np.asarray(system.D) / scale],
                [np.zeros((states, 1)), noise * seen, still[:1, :1].repeat(states, 0)],
            ]
        ),
    )
    closed = plant.lft(control.h2syn(plant, states, 1))
    assert control.norm(closed, 2) ** 2 == pytest.approx(found.cost, rel=3e-4)


def test_peaks_hold_at_every_frequency() -> None:
    """The largest gain of the closed loop over a fine grid of frequencies, beside that of the loop without a limit."""
    request = {"actuator": "chassis_travel", "road": "C", "speed": 20.0, "objective": OBJECTIVE}
    free = tune_active(CAR, **request)  # type: ignore[arg-type]

    def peak(found: ActiveTuning, name: str) -> float:
        gains = np.abs(found.closed(1j * np.geomspace(0.1, 1e3, 20_000)))[found.closed.output_labels.index(name)]
        return float(np.max(gains))

    top = 0.8 * peak(free, "chassis_travel")
    kept = tune_active(CAR, peaks={"chassis_travel": top}, **request)  # type: ignore[arg-type]
    assert peak(kept, "chassis_travel") <= top * 1.001
    assert kept.cost > free.cost
    assert kept.bound == pytest.approx(free.bound, rel=1e-3)
    # Where the wheel swings on its tire alone no force in the strut changes the acceleration of the body: its gain from
    # the road's slope is k_t / (m_s w) there (J. K. Hedrick and T. Butsuen, Proc. IMechE D 204, 1990).
    invariant = 210e3 / (350 * np.sqrt(210e3 / 50))
    assert peak(free, "chassis_acceleration") == pytest.approx(invariant, rel=1e-3)
    with pytest.raises(InputError, match="meets the limits and peaks"):
        tune_active(CAR, peaks={"chassis_acceleration": 0.95 * invariant}, **request)  # type: ignore[arg-type]


def test_limits_hold_and_cost_something() -> None:
    request = {"actuator": "chassis_travel", "road": "C", "speed": 20.0}
    objective = {"chassis_acceleration": 1.0, "tire_travel": 0.004}
    free = tune_active(CAR, objective=objective, **request)  # type: ignore[arg-type]
    limits = {"chassis_travel": 0.9 * tune_active(
        CAR, objective={**objective, "chassis_travel": 1e3}, **request  # type: ignore[arg-type]
    ).rms["chassis_travel"], "force": 400.0}  # fmt: skip
    kept = tune_active(CAR, objective=objective, limits=limits, **request)  # type: ignore[arg-type]
    assert kept.rms["chassis_travel"] <= limits["chassis_travel"] * 1.001
    assert kept.rms["force"] <= 400.4
    assert kept.cost > free.cost
    assert free.rms["chassis_acceleration"] < free.passive["chassis_acceleration"]
    assert "gain" in str(kept)


def test_the_closed_loop_on_a_road() -> None:
    """Rms of a long simulation of the closed loop under white slopes."""
    found = tune_active(CAR, actuator="chassis_travel", objective=OBJECTIVE, road="C", speed=20.0)
    rng, step = np.random.default_rng(2), 0.002
    from suspid.simulation import recursion

    A, B, C = (np.asarray(m, float) for m in (found.closed.A, found.closed.B, found.closed.C))
    from scipy.linalg import expm, solve_continuous_lyapunov

    level = (2 * np.pi * 0.1) ** 2 * 256e-6 * 20.0 / 2
    P = solve_continuous_lyapunov(A, -level * B @ B.T)
    E = expm(A * step)
    root = np.linalg.cholesky(P - E @ P @ E.T + 1e-18 * np.eye(len(A)))
    states = recursion(E, (root @ rng.standard_normal((len(A), 200_000)))[:, :, None], np.zeros((len(A), 1)), 200_000)
    np.testing.assert_allclose(np.std(C @ states[:, :, 0], axis=1), list(found.rms.values()), rtol=0.03)


@pytest.mark.parametrize("level", [1e-25, 1e-10, 1e25])
def test_the_gain_does_not_depend_on_the_level_of_the_road_or_the_objective(level: float) -> None:
    """A linear car with quadratic costs: variances grow with the road, and the best gain is the same."""
    one = tune_active(CAR, actuator="chassis_travel", objective=OBJECTIVE, road=1e-4, speed=20.0)
    scaled = {name: value * level for name, value in OBJECTIVE.items()}
    for objective, roughness in ((OBJECTIVE, level), (scaled, 1e-4)):
        two = tune_active(CAR, actuator="chassis_travel", objective=objective, road=roughness, speed=20.0)
        np.testing.assert_allclose(two.gain, one.gain, rtol=1e-3, atol=1e-3 * np.max(np.abs(one.gain)))
        factor = roughness / 1e-4 if objective is OBJECTIVE else level**-2
        assert two.cost == pytest.approx(one.cost * factor, rel=1e-5)
        assert two.bound == pytest.approx(one.bound * factor, rel=1e-5)


@pytest.mark.parametrize(
    ("given", "codes"),
    [
        ({"objective": {"tire_travel": 0.003}}, {ActiveCheck.UNBOUNDED, ActiveCheck.FAST}),
        ({"objective": {"tire_travel": 0.003}, "limits": {"force": 500.0}}, set()),
        ({"objective": {"chassis_acceleration": 1.0, "tire_travel": 0.004}}, {ActiveCheck.FAR, RideCheck.LIFTS}),
        ({"objective": {"chassis_acceleration": 1.0, "tire_travel": 1e-9}}, {ActiveCheck.FAST}),
    ],
)
def test_feedback_that_nothing_holds_is_no_result(given: dict[str, object], codes: set[Code]) -> None:
    """Without a cost of the force the least is an infimum, which only infinite gains reach."""
    found = tune_active(CAR, actuator="chassis_travel", road="C", speed=20.0, **given)  # type: ignore[arg-type]
    assert {doubt.code for doubt in found.verdict.doubts} == codes
    assert str(found.verdict) in str(found)


@pytest.mark.parametrize("damping", [0.0, 60.0])
def test_a_feedback_that_does_next_to_nothing_lifts_the_wheel_as_often_as_the_ride(damping: float) -> None:
    """The load as force of the masses, from state space, beside that of the struts on the road, with its spectra."""
    car = CAR.with_parameters(damping={"tire": damping})
    found = tune_active(
        car, actuator="chassis_travel", road="C", speed=20.0, objective={"chassis_travel": 1e6, "force": 1.0}
    )
    (lifts,) = [doubt for doubt in found.verdict.doubts if doubt.code is RideCheck.LIFTS]
    expected = 3600 * ride(car, road="C", speed=20.0)["tire.lift_rate"]
    assert lifts.numbers["times"] == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize(
    ("objective", "codes"),
    [
        ({"chassis_acceleration": 1.0}, {ActiveCheck.UNDAMPED, ActiveCheck.AIRBORNE}),
        ({"chassis_acceleration": 1.0, "tire_travel": 0.004}, {ActiveCheck.FAR, RideCheck.LIFTS}),
        ({"chassis_acceleration": 1.0, "tire_travel": 0.002, "chassis_travel": 0.02}, set()),
    ],
)
def test_cars_that_no_vehicle_is_are_doubted(objective: dict[str, float], codes: set[Code]) -> None:
    """Of what was not asked for: a vibration of the wheel without end, a strut of 38 m, a wheel in the air."""
    found = tune_active(CAR, actuator="chassis_travel", road="C", speed=20.0, objective=objective)
    assert {doubt.code for doubt in found.verdict.doubts} == codes


@pytest.mark.parametrize("given", [{"limits": {"force": 1e-30}}, {"peaks": {"chassis_travel": 1e-30}}])
def test_limits_that_no_solver_can_tell_from_zero(given: dict[str, object]) -> None:
    with pytest.raises(SuspidError, match=r"^[^\n]+$"):
        tune_active(CAR, actuator="chassis_travel", objective=OBJECTIVE, road="C", speed=20.0, **given)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"road": 1e300}, "roughness=1e+300 must be"),
        ({"objective": {"force": 1.0}}, "force alone is smallest at zero"),
        ({"objective": {}}, "objective is empty"),
        ({"objective": ["chassis_acceleration"]}, "objective=['chassis_acceleration'] must map outputs to numbers"),
        ({"objective": {5: 1.0}}, "5 is not the name of an output"),
        ({"limits": 5}, "limits=5 must map outputs"),
        ({"car": CAR.with_parameters(damping={"chassis": 0.0, "tire": 0.0})}, "a mode has no damping"),
        ({"car": CAR.with_parameters(stiffness={"chassis": 0.0})}, "do not support the car"),
        ({"actuator": 5}, "actuator=5 must be the name"),
        ({"car": "x.toml"}, "read_car('x.toml')"),
        ({"objective": {"chassis_acceleration": -1.0}}, "must be a positive number"),
        ({"objective": {"chassis": 1.0}}, "grows without bound"),
        ({"limits": {"chassis_travel": 1e-5, "force": 10.0}}, "no state feedback meets the limits"),
        ({"car": TWO_AXLES, "actuator": "front_travel"}, "has 2 roads"),
        ({"road": road("C", speed=20.0, exponent=2.5), "speed": None}, "has the exponent 2.5"),
        ({"car": CAR.with_parameters(damping={"tire": 50.0}), "objective": {"tire_acceleration": 1.0}}, "is infinite"),
    ],
)
def test_wrong_requests_are_refused(given: dict[str, object], message: str) -> None:
    request = {"car": CAR, "actuator": "chassis_travel", "objective": OBJECTIVE, "road": "C", "speed": 20.0, **given}
    with pytest.raises(InputError, match=re.escape(message)):
        tune_active(**request)  # type: ignore[arg-type]
