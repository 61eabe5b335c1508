"""Codes and sentences: a damper's curve that was found in records."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from suspid.words.remarks import Code, Number


def _over_noise(text: str) -> Callable[[Mapping[str, Number]], str]:
    """Return words with the power of the residual over that of noise in place of ``{times}``."""

    def said(numbers: Mapping[str, Number]) -> str:
        chi_square, freedom = (float(str(numbers[name])) for name in ("chi_square", "freedom"))
        return text.format_map({**numbers, "times": f"{chi_square / max(freedom, 1.0):.3g}"})

    return said


class CurveHeadline(Code):
    """Headline of the result."""

    CURVE = "curve", "the damper curve of {strut!r} is not a straight line"
    LINE = "line", "the damper curve of {strut!r} is consistent with a straight line"


class CurveCheck(Code):
    """Checks of a damper's curve."""

    EXPLAINS = "explains", "The residual is noise (chi-square {chi_square:.3g} at {freedom})."
    UNEXPLAINED = (
        "unexplained",
        _over_noise(
            "The residual is not white noise of the sensors alone: its power is {times} times that of such noise. The "
            "intervals allow for its colour, not for what may be missing: gain or delay of a sensor, a mount of the "
            "damper, a spring that is not linear, another axle. estimate finds gains, delays and mounts."
        ),
    )
    FOLLOWS = (
        "follows",
        _over_noise(
            "The residual follows the motion of the strut (F = {ratio:.3g} on average, 1 by chance), with {times} "
            "times the power of white noise. The intervals do not contain what may be missing: gain or delay of a "
            "sensor, a mount of the damper, a spring that is not linear, another axle, slow forces such as wind. "
            "estimate finds gains, delays and mounts."
        ),
    )
    ADDED = (
        "added",
        _over_noise(
            "The residual has {times} times the power of white noise of the sensors, but does not follow the motion of "
            "the strut: other forces act on the body, such as those of an engine. The intervals allow for them."
        ),
    )
    BENDS = (
        "bends",
        "A line is rejected at a level of {level:.2g} (F = {statistic:.3g} at {freedom} and {residual_freedom}, "
        "p = {p_value:.2g}): a viscous c describes this damper at one amplitude only.",
    )
    STRAIGHT = (
        "straight",
        "A line is not rejected at a level of {level:.2g} (F = {statistic:.3g} at {freedom} and {residual_freedom}, "
        "p = {p_value:.2g}).",
    )
    FRICTION = "friction", "Friction of {friction:.3g} ± {std:.2g} N is significant."
    FALLS = (
        "falls",
        "The fitted forces do not rise everywhere with velocity. The strut has the nearest curve that does; it "
        "differs by up to {error:.2g} N.",
    )
    BLURRED = (
        "blurred",
        "The velocity is known only to {error:.2g} m/s, {share:.0%} of its root mean square: the curve is blurred "
        "over that width, and a sticking strut looks like a creeping one. Use an accelerometer at the wheel, or a "
        "travel sensor with less noise.",
    )
    UNSETTLED = (
        "unsettled",
        "The fit did not converge within {steps} steps. The values may be off by their standard errors.",
    )
    VAGUE = "vague", "Forces are uncertain by up to {share:.0%} of the largest force; use a longer or rougher record."
    MASSES = "masses", "Forces and stiffness are proportional to the masses of the car, which are taken as known."
