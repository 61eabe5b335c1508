"""Codes and sentences: state feedback."""

from __future__ import annotations

from suspid.words.remarks import Code, in_a_row, sentence


class ActiveHeadline(Code):
    """Headline of the result."""

    FEEDBACK = "feedback", sentence(lambda n: f"state feedback of {n['actuator']} for {in_a_row(n['names'])}")


class ActiveCheck(Code):
    """Checks of state feedback."""

    OPTIMAL = "optimal", "The cost is within {share:.1g} of the lower bound for state feedback."
    ABOVE = (
        "above",
        "The cost is {share:.2g} above the lower bound without limits on peaks; what these limits cost is not known.",
    )
    UNBOUNDED = (
        "unbounded",
        "Nothing limits the force: the cost falls with ever larger gains, and the solver stopped at these. Give "
        "force a weight in the objective, or a limit.",
    )
    FAST = (
        "fast",
        "The fastest pole of the closed loop is at {hertz:.3g} Hz; suspension actuators reach {limit:g} Hz at most. "
        "Give force more weight, or a limit.",
    )
    FAR = (
        "far",
        "{strut}: the rms travel is {travel:.3g} m; vehicles have {limit:g} m at most. Give {strut}_travel a weight "
        "in the objective, or a limit.",
    )
    AIRBORNE = (
        "airborne",
        "{wheel}: the rms dynamic load, {rms:.4g} N, exceeds the static load, {load:.4g} N: the wheel is often off "
        "the road. Give the travel of the tire a weight or a limit.",
    )
    UNDAMPED = (
        "loop hardly damped",
        "The closed loop has a damping ratio of {zeta:.2g} at {hertz:.3g} Hz, below the {limit:.2g} of rubber alone. "
        "Give the motion at that frequency, such as the travel of the tire, a weight or a limit.",
    )
