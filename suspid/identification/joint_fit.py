"""Fit common poles to several decays by maximum likelihood."""

from __future__ import annotations

import numpy as np

from suspid.errors import IdentificationError
from suspid.identification.exponentials import Blocks
from suspid.identification.likelihood import DecayFit, evaluate
from suspid.identification.noise import WhiteNoise
from suspid.identification.poles import Poles


def maximize_jointly(blocks: list[Blocks], start: list[Poles], noises: list[WhiteNoise]) -> list[DecayFit]:
    """Return the fits of all decays at the poles of greatest joint likelihood, by Gauss-Newton steps.

    The start is the same for all decays except for the nuisances. An `IdentificationError` says that the poles cannot
    be distinguished in one of the records.
    """
    found = _all_fits(blocks, start, noises)
    if found is None:
        raise IdentificationError("the shortest decay is too short to distinguish the poles; leave it out")
    fits, loss = found
    # From poles fitted over the common length, fewer than 10 steps are usual; 40 is a limit against cycling.
    for _ in range(40 if fits[0].poles.free else 0):
        information = np.sum([fit.information for fit in fits], axis=0)
        gradient = np.sum([fit.gradient for fit in fits], axis=0)
        scale = 1 / np.sqrt(np.maximum(information.diagonal(), 1e-300))
        step = scale * np.linalg.lstsq(information * np.outer(scale, scale), scale * gradient, rcond=1e-12)[0]
        # Steps below 3e-4 standard deviations do not matter.
        if float(step @ gradient) < 1e-7:
            break
        better = None
        for halving in range(12):
            better = _all_fits(blocks, [fit.poles.moved(step * 0.5**halving) for fit in fits], noises)
            if better is not None and better[1] <= loss + 1e-13 * sum(b.count for b in blocks):
                break
            better = None
        if better is None:
            break
        fits, loss = better
    return fits


def _all_fits(
    blocks: list[Blocks], poles: list[Poles], noises: list[WhiteNoise]
) -> tuple[list[DecayFit], float] | None:
    """Return the fits of all decays at given poles and the sum of their losses, or None if one fails."""
    fits: list[DecayFit] = []
    for block, own, noise in zip(blocks, poles, noises, strict=True):
        fit = evaluate(block, own, noise)
        if fit is None:
            return None
        fits.append(fit)
    return fits, sum(noise.loss(fit.squares, fit.count) for fit, noise in zip(fits, noises, strict=True))
