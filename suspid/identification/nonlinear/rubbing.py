"""Where friction acts: against the ground or in the struts of a chain, by fits from the equations of motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from suspid.identification.nonlinear.descent import Around, fitted
from suspid.identification.nonlinear.driven import DrivenFit
from suspid.identification.nonlinear.equations import from_equations
from suspid.identification.nonlinear.feedback import Record
from suspid.identification.nonlinear.standing import explains, leaves_more, misses
from suspid.identification.nonlinear.structure import StructureFit

# Cycles of the slowest mode to which a start is fitted first, how much longer each stretch is than the one before, and
# the steps of each fit: over more, the phase of a fast mode is lost.
FITTED_FIRST, GROWTH, STEPS_EACH = 0.5, 1.4, 8
# What the equations tell of each parameter, as a share of the largest of its kind: short stretches leave some open.
TOLD_BY_EQUATIONS = 0.3
# The same of what friction does to masses at which it does not act: it is none.
NOT_AT_ALL = 0.003
# Cycles after which a stretch tells what friction is not, and the loss per sample that must be left for that.
TELLING_CYCLES, LEFT_OVER = 1.5, 1.5
# Share of accelerations that equations of motion tell in each channel where linear modes follow no motion: they tell
# less of noise of any kind under the same weights, more of cars whose friction hides their wheels.
TOLD_WITHOUT_MODES = 0.6
# Loss per sample by which the first fits from the equations of motion may be above what must be reached.
LEADS_NEAR = 1.0
# Loss per sample by which a start from the equations of motion may be above a linear fit.
MORE_AT_FIRST = 2.0
# BIC above the best one up to which friction, or friction elsewhere, is not ruled out if it leaves only noise: steps of
# encoders are not the noise that it is made for.
NOT_RULED_OUT = 50.0


def by_equations(
    record: Record, strong: DrivenFit, *, most: int, highest: float, longest: int, followed: bool
) -> list[StructureFit]:
    """Return the structures with friction that the equations of motion lead to: the best one, then others.

    Those have friction elsewhere and leave only noise. There are none where a linear fit explains more, or leaves only
    noise beside its modes. Where it has not ``followed`` the motion, the equations must tell most of it.
    """
    if not 1 < len(record.values) <= most or not leaves_more(strong, record.noise):
        return []
    best, told = list[StructureFit](), 0.0 if followed else TOLD_WITHOUT_MODES
    for ranks in from_equations(record, strong.drive.theta, longest=longest, least=told):
        fits = _fits_of(ranks, strong, highest)
        if fits is None:
            return []
        best = fits if fits and (not best or fits[0].bic < best[0].bic) else best
        if best and explains(best[0], highest):
            break
    if not best or best[0].bic >= strong.bic:
        return []
    elsewhere = {fit.forces: fit for fit in reversed(best) if fit.forces != best[0].forces and not misses(fit)}
    return [best[0], *(fitted(fit) for fit in elsewhere.values())]


def _fits_of(ranks: list[list[StructureFit]], strong: DrivenFit, highest: float) -> list[StructureFit] | None:
    """Return the fits that starts of each rank lead to, the best one first; None where modes without friction do."""
    fits, starts = list[StructureFit](), list[StructureFit]()
    for rank in ranks:
        likely = [start for start in rank if start.loss < strong.loss + MORE_AT_FIRST * start.residual.size]
        starts += likely
        for start in likely:
            fits = _with_fit(fits, start, highest)
            # Modes without friction leave as little.
            if fits and not misses(fits[0]) and fits[0].bic >= highest + NOT_RULED_OUT:
                return None
        # Of the right friction, most starts lead near the best fit: of none that leads near it, more lead nowhere.
        if not fits or explains(fits[0], highest) or not _near(fits[0], highest):
            break
    if fits and not explains(fits[0], highest) and _near(fits[0], highest):
        for start in (start for start in starts if start.forces == fits[0].forces):
            fits = _with_fit(fits, start, highest, none=NOT_AT_ALL)
    return fits


def _near(fit: StructureFit, highest: float) -> bool:
    return fit.bic < highest + LEADS_NEAR * fit.residual.size


def _with_fit(
    fits: list[StructureFit], start: StructureFit, highest: float, none: float = TOLD_BY_EQUATIONS
) -> list[StructureFit]:
    """Return fits and that near a start, the best one first."""
    fit = followed_on(start, reached=highest / start.residual.size, none=none)
    return fits if fit is None else sorted([*fits, fit], key=lambda each: each.bic)


def followed_on(start: StructureFit, *, reached: float, none: float = TOLD_BY_EQUATIONS) -> StructureFit | None:
    """Return the fit near a start to the first half of a cycle of its slowest mode, followed on to the end in steps.

    None where the friction is not the true one: after some cycles, more is left of a stretch than by a fit that has
    ``reached`` a loss per sample. What the equations have as ``none`` is so to this share while the stretch is short.
    """
    record, fit, around = start.record, start, Around.of(start.structures, share=TOLD_BY_EQUATIONS, none=none)
    cycle = 2 * np.pi / float(np.min(start.theta.imag))
    count = int(FITTED_FIRST * cycle)
    while count < record.values.shape[1]:
        fit = fitted(fit.with_record(record.begun(count)), steps=STEPS_EACH, around=around)
        if count > TELLING_CYCLES * cycle and fit.loss > (reached + LEFT_OVER) * fit.residual.size:
            return None
        count = int(GROWTH * count) + 1
    return with_turns(fitted(fit.with_record(record), steps=STEPS_EACH))


def with_turns(fit: StructureFit) -> StructureFit:
    """Return a fit to accelerations whose samples tell what friction is where it turns, if that leaves less.

    Fits begin with the mean of friction about each sample, which changes evenly where it turns earlier.
    """
    if fit.order < 2:
        return fit
    told = fitted(fit.with_structures(replace(fit.structures, turns=True)), steps=STEPS_EACH)
    return told if told.loss < fit.loss else fit
