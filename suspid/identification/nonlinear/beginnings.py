"""Structures after their first steps: from a linear fit, from one of the beginning, from a guess of friction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from suspid.identification.nonlinear.descent import fitted
from suspid.identification.nonlinear.driven import Drive, DrivenFit, maximize
from suspid.identification.nonlinear.feedback import ROUGH_STEPS, Record, without_forces
from suspid.identification.nonlinear.forces import ForceKind, forces_of
from suspid.identification.nonlinear.guesses import with_friction
from suspid.identification.nonlinear.motion import steps_of
from suspid.identification.nonlinear.standing import explains, misses
from suspid.identification.nonlinear.structure import StructureFit, structure_of

# Steps after which starts are compared.
FIRST = 6
# Guesses of friction, each from the poles that the one before leads to, and the cycles of the slowest mode up to which
# they are made: of masses that stop later, the start without friction leads to the best fit.
GUESSES, CYCLES_GUESSED = 2, 10
# Steps of the motion up to which they are made: where friction holds masses, each step of a motion takes long.
LONGEST_GUESSED = 1000
# Loss per sample that a guess must gain for the next to be made: one that leads nowhere gains next to nothing.
GAINED = 1.0
# Share of a record to which a structure is fitted first where the fit to the whole misses something.
BEGINNING = 0.4


def begun(record: Record, start: DrivenFit, order: int, kind: ForceKind, *, highest: float) -> StructureFit:
    """Return a structure with forces of a kind after some steps.

    Where those leave more than noise beside the modes, the best of that, of one that begins with a fit to the
    beginning of the record, and of one that begins with friction of a guessed size; that is also tried where the BIC is
    not below the highest, as few samples hide what is left.
    """
    forces = forces_of(kind, len(record.values), most=6)
    plain = structure_of(record, start.drive.theta, start.amplitudes, forces, order)
    whole = fitted(plain, steps=FIRST)
    if kind is ForceKind.FRICTION and stops_soon(record, start):
        whole = _guessed(whole, plain, highest=highest)
    if not misses(whole):
        return whole
    count = int(BEGINNING * record.values.shape[1])
    short = replace(record, values=record.values[:, :count])
    linear = maximize(short.values, _cut(without_forces(start.drive), count), record.noise, steps=ROUGH_STEPS)
    # A fit to few samples may put a pole beyond the Nyquist frequency, whose motion would take minutes.
    if linear is None or np.max(np.abs(linear.drive.theta)) > np.pi:
        return whole
    first = fitted(structure_of(short, linear.drive.theta, linear.amplitudes, forces, order), steps=FIRST)
    again = fitted(first.with_record(record), steps=FIRST)
    return again if again.bic < whole.bic else whole


def stops_soon(record: Record, start: DrivenFit) -> bool:
    """Return whether a record is so short that friction may have stopped the masses after a few cycles.

    That of a single mode is found from its swings.
    """
    theta, count = start.drive.theta, record.values.shape[1]
    cycles = float(np.min(theta.imag)) * count / (2 * np.pi)
    return len(theta) > 1 and cycles < CYCLES_GUESSED and steps_of(theta, count, ForceKind.FRICTION) <= LONGEST_GUESSED


def _guessed(whole: StructureFit, plain: StructureFit, *, highest: float) -> StructureFit:
    """Return a fit, or a better one that begins with friction of a guessed size.

    Friction hides the poles from a linear fit: a second guess, beside those of the first, is better.
    """
    record, channels = plain.record, len(plain.residual)
    single, guess = forces_of(ForceKind.FRICTION, channels, most=channels), plain
    for _ in range(GUESSES):
        if explains(whole, highest):
            break
        start = structure_of(record, guess.theta, guess.amplitudes, single, plain.order)
        tries = list[StructureFit]()
        for each in with_friction(start):
            tries.append(fitted(each, steps=FIRST))
            whole = min(whole, tries[-1], key=lambda fit: fit.bic)
            if explains(whole, highest):
                break
        guess = min(tries, key=lambda fit: fit.bic, default=start)
        if guess.loss > start.loss - GAINED * start.residual.size:
            break
    return whole


def _cut(drive: Drive, count: int) -> Drive:
    return replace(drive, forces=drive.forces[:, :count])
