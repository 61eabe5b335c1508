"""The verdict on a reconstruction."""

from __future__ import annotations

from collections.abc import Iterator
from statistics import median
from typing import TYPE_CHECKING

from suspid.levels import CHI_SQUARE_95, NORMAL_95
from suspid.reconstruction.unknowns import parameter_values
from suspid.words import (
    Check,
    Level,
    Number,
    ReconstructionCheck,
    ReconstructionHeadline,
    ReconstructionNote,
    Remark,
    Verdict,
)

if TYPE_CHECKING:
    from suspid.reconstruction.results import Reconstruction

# Springs found over nominal from which on, or below its inverse, another unit is likelier than another spring: units
# that are mistaken are off by 1000, and this is midway from 1 to there in the logarithm.
OTHER_UNIT = 1000.0**0.5

# Remarks of a result that are checks as well, and what they say of it.
AGAINST = {
    ReconstructionNote.VANISHED: (ReconstructionCheck.VANISHED, Level.CARE),
    ReconstructionNote.AT_BOUND: (ReconstructionCheck.AT_BOUND, Level.NOTE),
    ReconstructionNote.ACTIVE: (ReconstructionCheck.ACTIVE, Level.NOTE),
    ReconstructionNote.PENALTY: (ReconstructionCheck.PENALTY, Level.NOTE),
    ReconstructionNote.SPLIT_BY_NOMINAL: (ReconstructionCheck.BY_NOMINAL, Level.CARE),
    ReconstructionNote.UNSEEN: (ReconstructionCheck.BY_NOMINAL, Level.CARE),
    ReconstructionNote.NOT_SHARP: (ReconstructionCheck.NOT_SHARP, Level.CARE),
    ReconstructionNote.CHANNEL_UNKNOWN: (ReconstructionCheck.CHANNEL_UNKNOWN, Level.NOTE),
    ReconstructionNote.NEAR_MISS: (ReconstructionCheck.NEAR_MISS, Level.CARE),
}


def verdict_of(found: Reconstruction) -> Verdict:
    """Return how far springs and dampers can be trusted.

    That they explain the modes speaks for them only where that was tested: with an uncertainty of the modes, or a
    tolerance, and more equations than unknowns.
    """
    headline = Remark(ReconstructionHeadline.FOUND, {"parameters": len(found.parameters)})
    against = (*_other_units(found), *_others(found), *_remarked(found), *_vague(found))
    return Verdict(headline, (_fit(found), *against, *_changed(found)))


def _fit(found: Reconstruction) -> Check:
    """Return whether the car explains the modes."""
    if not found.explains:
        return Check(Remark(ReconstructionCheck.UNEXPLAINED), Level.CARE)
    if found.freedom <= 0:
        return Check(Remark(ReconstructionCheck.NOT_JUDGED), Level.NOTE)
    if found.chi_square is not None:
        numbers = {"chi_square": found.chi_square, "freedom": found.freedom}
        return Check(Remark(ReconstructionCheck.EXPLAINS, numbers), Level.SOUND)
    misfit = next((r.numbers["misfit"] for r in found.remarks if r.code is ReconstructionNote.MISFIT), 0.0)
    return Check(Remark(ReconstructionCheck.WITHIN_TOLERANCE, {"misfit": misfit}), Level.SOUND)


def _other_units(found: Reconstruction) -> Iterator[Check]:
    """Yield that springs are so far from nominal that masses or nominal springs must be in another unit."""
    if found.nominal is None:
        return
    pairs = zip(found.suspension.struts, found.nominal.struts, strict=True)
    ratios = [new.stiffness / old.stiffness for new, old in pairs if old.stiffness > 0]
    factor = median(ratios) if ratios else 1.0
    if not 1 / OTHER_UNIT < factor < OTHER_UNIT:
        yield Check(Remark(ReconstructionCheck.OTHER_UNITS, {"factor": factor}), Level.DOUBTFUL)


def _others(found: Reconstruction) -> Iterator[Check]:
    """Yield what is known of other suspensions with the same modes, and of intervals."""
    if found.alternatives:
        alike = found.chi_square is None or min(found.distances) <= found.chi_square + CHI_SQUARE_95
        numbers: dict[str, Number] = {"count": len(found.alternatives), "by_nominal": alike}
        yield Check(Remark(ReconstructionCheck.ALTERNATIVES, numbers), Level.CARE)
    elif not found.searched:
        yield Check(Remark(ReconstructionCheck.NOT_SEARCHED), Level.NOTE)
    else:
        yield Check(Remark(ReconstructionCheck.NO_ALTERNATIVES), Level.SOUND)
    if found.chi_square is None:
        yield Check(Remark(ReconstructionCheck.NO_UNCERTAINTY), Level.NOTE)


def _remarked(found: Reconstruction) -> Iterator[Check]:
    """Yield the remarks that speak against the result."""
    for remark in found.remarks:
        if remark.code in AGAINST:
            code, level = AGAINST[remark.code]
            yield Check(Remark(code, remark.numbers), level)


def _vague(found: Reconstruction) -> Iterator[Check]:
    """Yield which parameters are not known from zero."""
    if found.covariance is None:
        return
    values = parameter_values(found.suspension)
    std = found.covariance.diagonal() ** 0.5
    vague = tuple(n for n, s in zip(found.parameters, std, strict=True) if 0 < values[n] < NORMAL_95 * s)
    if vague:
        yield Check(Remark(ReconstructionCheck.VAGUE, {"names": vague}), Level.CARE)


def _changed(found: Reconstruction) -> Iterator[Check]:
    """Yield which parameters differ from nominal beyond chance."""
    if found.covariance is None or found.nominal is None or not found.parameters:
        return
    apart = found.beyond_chance()
    names = tuple(name for name in found.parameters if name in apart)
    code = ReconstructionCheck.CHANGED if names else ReconstructionCheck.UNCHANGED
    yield Check(Remark(code, {"names": names} if names else {}), Level.NOTE)
