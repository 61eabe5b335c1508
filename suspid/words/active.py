"""What can be said of state feedback."""

from __future__ import annotations

from suspid.words.remarks import Code, in_a_row, sentence


class ActiveHeadline(Code):
    """What was found."""

    FEEDBACK = "feedback", sentence(lambda n: f"state feedback of {n['actuator']} for {in_a_row(n['names'])}")


class ActiveCheck(Code):
    """What speaks for and against state feedback."""

    OPTIMAL = "optimal", "The cost is within {share:.1g} of the bound that no state feedback falls below."
    ABOVE = (
        "above",
        "The cost is {share:.2g} above the bound without limits on peaks; how much of it these cost is not known.",
    )
    UNBOUNDED = (
        "unbounded",
        "Nothing that was asked for holds the force: the least cost is approached by ever larger gains only, and these "
        "are where the solver stopped. Name force in the objective or in the limits.",
    )
    FAST = (
        "fast",
        "The fastest pole of the closed loop is at {hertz:.3g} Hz, above {limit:g} Hz: no actuator of a suspension "
        "follows it. Give force more weight, or a limit.",
    )
    FAR = (
        "far",
        "{strut}: the rms of its travel is {travel:.3g} m, above the {limit:g} m that any vehicle has room for: give "
        "{strut}_travel a weight in the objective, or a limit.",
    )
    AIRBORNE = (
        "airborne",
        "{wheel}: the rms of its dynamic load is {rms:.4g} N, above the static load of {load:.4g} N: the wheel is off "
        "the road for much of the time. Give the travel of the tire a weight or a limit.",
    )
    UNDAMPED = (
        "loop hardly damped",
        "The closed loop has a damping ratio of {zeta:.2g} at {hertz:.3g} Hz, below the {limit:.2g} that rubber alone "
        "gives: give what vibrates there, as the travel of the tire, a weight or a limit.",
    )
