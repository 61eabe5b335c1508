"""What can be said of a damper's curve that was found in records."""

from __future__ import annotations

from suspid.words.remarks import Code


class CurveHeadline(Code):
    """What was found."""

    CURVE = "curve", "the curve of the damper of {strut!r} is not a line"
    LINE = "line", "no sign that the curve of the damper of {strut!r} is not a line"


class CurveCheck(Code):
    """What speaks for and against a damper's curve."""

    EXPLAINS = "explains", "The residual is noise (chi-square {chi_square:.3g} at {freedom})."
    UNEXPLAINED = (
        "unexplained",
        "The residual is not white noise of the sensors alone (chi-square {chi_square:.3g} at {freedom}). The "
        "intervals allow for its colour, not for what may be missing: gain or delay of a sensor, a mount of the "
        "damper, a spring that is not linear, another axle. estimate finds gains, delays and mounts.",
    )
    FOLLOWS = (
        "follows",
        "The residual follows the motion of the strut (F = {ratio:.3g} on average, 1 by chance; chi-square "
        "{chi_square:.3g} at {freedom}). The intervals do not contain what may be missing: gain or delay of a sensor, "
        "a mount of the damper, a spring that is not linear, another axle. estimate finds gains, delays and mounts.",
    )
    ADDED = (
        "added",
        "The residual is more than white noise of the sensors (chi-square {chi_square:.3g} at {freedom}), but does not "
        "follow the motion of the strut: forces of their own on the body, such as those of an engine. The intervals "
        "contain them.",
    )
    BENDS = (
        "bends",
        "A line is rejected at a level of {level:.2g} (F = {statistic:.3g} at {freedom} and {residual_freedom}, "
        "p = {p_value:.2g}): a viscous damper c stands for this one at one amplitude alone.",
    )
    STRAIGHT = (
        "straight",
        "A line is not rejected at a level of {level:.2g} (F = {statistic:.3g} at {freedom} and {residual_freedom}, "
        "p = {p_value:.2g}).",
    )
    FRICTION = "friction", "Friction of {friction:.3g} ± {std:.2g} N is significant."
    FALLS = (
        "falls",
        "The forces found do not rise everywhere; the strut has the nearest curve that does, up to {error:.2g} N off.",
    )
    BLURRED = (
        "blurred",
        "The velocity is known to {error:.2g} m/s only, {share:.0%} of its root mean square: bends within that are "
        "blurred, and a strut that sticks looks like one that creeps. Use an accelerometer at the wheel, or a sensor "
        "of travel with less noise.",
    )
    UNSETTLED = (
        "unsettled",
        "The fit did not settle within {steps} steps. The values may be off by their standard errors.",
    )
    VAGUE = "vague", "Forces are uncertain by up to {share:.0%} of the largest force; use a longer or rougher record."
    MASSES = "masses", "Forces and stiffness are in proportion to the masses of the car, which are taken as known."
