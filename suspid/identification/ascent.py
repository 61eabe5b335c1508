"""Ascent of the likelihood over the poles, by damped Gauss-Newton steps."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import TypeAlias

import numpy as np

from suspid.identification.exponentials import Blocks
from suspid.identification.likelihood import DecayFit, evaluate
from suspid.identification.noise import WhiteNoise
from suspid.identification.poles import Poles
from suspid.units import RealArray
from suspid.values import frozen_real

# A Gauss-Newton step gains about its squared length in standard deviations; iterations end below this. A larger
# value leaves the poles off the optimum by its square root.
NEGLIGIBLE_STEP = 1e-5
# Fits whose poles are reported end below this, at a millionth of a standard deviation: then rounding of the record
# shows nowhere. Each of the last steps gains a digit or more; where the model is wrong or poles nearly coincide, less.
AT_OPTIMUM, MOST_LAST_STEPS = 1e-12, 100
# The fit at given poles, None where there is none.
Evaluated: TypeAlias = Callable[[Poles], DecayFit | None]


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Known:
    """Poles that are known beforehand, each real parameter to a standard deviation."""

    poles: Poles
    std: RealArray  # (parameter,)

    def drift(self, fit: DecayFit) -> RealArray:
        """Return how far poles lie from these, in standard deviations, (parameter,)."""
        return np.asarray((fit.poles.parameters - self.poles.parameters) / self.std)


def maximize(
    blocks: Blocks,
    start: Poles | DecayFit,
    noise: WhiteNoise,
    *,
    steps: int = 60,
    negligible: float = NEGLIGIBLE_STEP,
    known: Known | None = None,
    evaluated: Evaluated | None = None,
) -> DecayFit | None:
    """Return the fit of greatest likelihood near given poles, by damped Gauss-Newton steps.

    A fit to start from must have been evaluated with the same record and noise. The search ends when a step promises
    less than ``negligible`` in twice the log likelihood. With poles ``known`` beforehand it is the most probable fit.
    Fits at given poles are ``evaluated`` by `evaluate` if nothing else is given.
    """
    evaluated = evaluated or partial(evaluate, blocks, noise=noise)
    fit = start if isinstance(start, DecayFit) else evaluated(start)
    if fit is None or not fit.poles.free:
        return fit
    damping = 1e-3
    rounding = 1e-13 * blocks.count
    for _ in range(steps):
        quadratic = Quadratic.of(fit, known)
        if quadratic is None:
            return fit
        refused = False
        for _ in range(12):
            step = quadratic.step(damping)
            if float(step @ quadratic.gradient) < negligible:
                return fit
            trial = evaluated(fit.poles.moved_within(step, blocks.count))
            if trial is not None:
                # Two fits whose residuals are below the rounding of either are equally good.
                coarse = noise.at_least(np.maximum(fit.rounding, trial.rounding) / blocks.count)
                worse = coarse.loss(trial.squares, blocks.count) - coarse.loss(fit.squares, blocks.count)
                if known is not None:
                    worse += float(np.sum(known.drift(trial) ** 2) - np.sum(known.drift(fit) ** 2))
                if worse <= rounding:
                    break
            refused, damping = True, max(10 * damping, 1e-4)
        else:
            return fit
        fit = trial
        # Damping that was needed a moment ago is needed again.
        if not refused:
            damping = damping / 10 if damping > 1e-9 else 0.0
    return fit


def settled(fit: DecayFit, evaluated: Evaluated, *, known: Known | None = None) -> DecayFit:
    """Return a fit near its optimum after the last steps, to rounding of the gradient rather than of the likelihood.

    Parameters
    ----------
    fit : DecayFit
        The fit.
    evaluated : callable
        Returns the fit at given poles.
    known : Known, optional
        Poles that are known beforehand.
    """
    best, promised = fit, np.inf
    for _ in range(MOST_LAST_STEPS if fit.poles.free else 0):
        quadratic = Quadratic.of(fit, known)
        if quadratic is None:
            return best
        step = quadratic.step(0.0)
        worth = float(step @ quadratic.gradient)
        # A step after which another promises no less was rounding, or led away.
        if worth >= promised:
            return best
        best, promised = fit, worth
        if worth < AT_OPTIMUM or worth > 1:
            return best
        trial = evaluated(fit.poles.moved_within(step, fit.count))
        if trial is None:
            return best
        fit = trial
    return best


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Quadratic:
    """The likelihood about a fit as a quadratic function of the real parameters of its poles."""

    unit: RealArray  # (parameter, parameter): information, scaled to a unit diagonal
    scale: RealArray  # (parameter,)
    gradient: RealArray  # (parameter,)

    @classmethod
    def of(cls, fit: DecayFit, known: Known | None = None) -> Quadratic | None:
        """Return the function, None where the information is none; parameters at a bound do not move beyond it."""
        information, gradient = fit.information, fit.gradient
        if known is not None:
            information = information + np.diag(1 / known.std**2)
            gradient = gradient - known.drift(fit) / known.std
        pinned = fit.poles.pinned(gradient, fit.count)
        if pinned is not None:
            free = ~pinned
            # Of what does not move, the information may be rounding.
            least = np.max(information.diagonal(), where=free, initial=1e-300)
            information = np.where(free[:, None] & free, information, least * _unit_matrix(len(free)))
            gradient = gradient * free
        diagonal = information.diagonal()
        if not (math.isfinite(information.sum()) and diagonal.min() > 0):
            return None
        scale = np.sqrt(np.maximum(diagonal, 1e-12 * diagonal.max()))
        return cls(unit=information / (scale[:, None] * scale), scale=scale, gradient=gradient)

    def step(self, damping: float) -> RealArray:
        """Return the damped step to the optimum, (parameter,)."""
        from scipy.linalg.lapack import dposv

        damped, slope = self.unit + damping * _unit_matrix(len(self.unit)), self.gradient / self.scale
        _, step, failed = dposv(damped, slope)
        # Without damping, rounding may leave the information indefinite or singular: then the step is the shortest one.
        return np.asarray((np.linalg.lstsq(damped, slope, rcond=None)[0] if failed else step) / self.scale)


@lru_cache(maxsize=64)
def _unit_matrix(size: int) -> RealArray:
    return frozen_real(np.eye(size))
