"""Checks of a damper's curve: what the verdict says of it."""

from __future__ import annotations

import numpy as np

from suspid.greybox.curve_fit import CurveFit, Noise
from suspid.greybox.damper_curves import DamperCurve, rising
from suspid.levels import likely
from suspid.words import Check, Level, Remark
from suspid.words.dampers import CurveCheck

# Error of the velocity beyond which that is said, as a share of its root mean square: a tenth of the distance between
# two nodes or more.
BLURRED_SHARE = 0.03
# Share of the largest force by which forces may be uncertain before that is said.
VAGUE_SHARE = 0.1


def checks_of(found: DamperCurve, fit: CurveFit, noise: Noise, *, follows: bool) -> list[Check]:
    """Return the checks of a curve, of the fit that led to it, and of what it leaves."""
    line = found.linear
    tested = {
        "level": line.level,
        "statistic": line.statistic,
        "freedom": line.freedom,
        "residual_freedom": line.residual_freedom,
        "p_value": line.p_value,
    }
    checks = [
        Check(Remark(CurveCheck.STRAIGHT if line else CurveCheck.BENDS, tested), Level.NOTE),
        _residual_check(found, follows=follows),
        Check(Remark(CurveCheck.MASSES), Level.NOTE),
    ]
    if found.friction_sought and found.friction > 2.6 * found.friction_std:
        numbers = {"friction": found.friction, "std": found.friction_std}
        checks.append(Check(Remark(CurveCheck.FRICTION, numbers), Level.NOTE))
    off = float(np.max(np.abs(rising(found) - found.forces)))
    if off > 0:
        checks.append(Check(Remark(CurveCheck.FALLS, {"error": off}), Level.NOTE))
    share = float(np.max(found.std) / np.max(np.abs(found.forces)))
    if share > VAGUE_SHARE:
        checks.append(Check(Remark(CurveCheck.VAGUE, {"share": share}), Level.CARE))
    blur = noise.velocity / found.velocity_std
    if blur > BLURRED_SHARE:
        checks.append(Check(Remark(CurveCheck.BLURRED, {"error": noise.velocity, "share": blur}), Level.CARE))
    if not fit.settled:
        checks.append(Check(Remark(CurveCheck.UNSETTLED, {"steps": fit.steps}), Level.CARE))
    return checks


def _residual_check(found: DamperCurve, *, follows: bool) -> Check:
    misfit = {"chi_square": found.chi_square, "freedom": found.freedom, "ratio": found.following}
    if not found.explains:
        return Check(Remark(CurveCheck.FOLLOWS if follows else CurveCheck.UNEXPLAINED, misfit), Level.CARE)
    if likely(found.chi_square, found.freedom):
        return Check(Remark(CurveCheck.EXPLAINS, misfit), Level.SOUND)
    return Check(Remark(CurveCheck.ADDED, misfit), Level.NOTE)
