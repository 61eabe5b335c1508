"""Motion of a car with piecewise linear dampers, exact within each piece."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from suspid.errors import InputError
from suspid.model import Suspension, output_rows
from suspid.simulation.piecewise import Choice, Machine
from suspid.units import RealArray, Second

# Halvings of a step where a piece ends: 5 ms to 5e-12 s, much less than friction needs to change its sign.
CROSSING_HALVINGS = 30
# A damper that changes its piece more often than this, within this share of the time between two samples, cannot be
# followed.
MOST_CHANGES, SMALL_SHARE = 500, 1e-3
TOO_STIFF = (
    "the motion cannot be computed: friction or the curve of a damper is far too stiff for the masses it acts on; "
    "check their units [N, m/s, kg]"
)
# Halvings of a step while a damper turns back near the end of its piece: it may leave the piece and return.
TURN_HALVINGS = 6


def motion(machine: Machine, pieces: RealArray, start: RealArray, time: RealArray) -> tuple[RealArray, list[Choice]]:
    """Return the states at given times, (state, sample), with the inputs, and the pieces that hold there.

    ``pieces`` are the inputs and their derivatives just after each time, (input and derivative, sample).
    """
    states = np.empty((len(machine.fixed), len(time)))
    states[machine.states : -1], states[-1] = pieces, 1.0
    states[: machine.states, 0] = start
    uniform = (time[-1] - time[0]) / max(len(time) - 1, 1)
    spans = np.diff(time)
    # Stamps that are rounded count as uniform: each span of its own would need exponentials of its own.
    if spans.size and np.max(np.abs(spans - uniform)) <= 16 * np.spacing(np.max(np.abs(time))):
        spans = np.full(len(spans), uniform)
    choices = [machine.choice(states[:, 0])]
    for k, span in enumerate(spans.tolist()):
        after = advanced(machine, states[:, k], span)
        states[: machine.states, k + 1] = after[: machine.states]
        choices.append(machine.choice(states[:, k + 1]))
    return states, choices


def advanced(machine: Machine, state: RealArray, span: Second) -> RealArray:
    """Return the state after a span in which the inputs are polynomials."""
    choice = machine.choice(state)
    smallest = span * 2.0**-CROSSING_HALVINGS
    left = size = 2**CROSSING_HALVINGS
    changes, since = 0, left
    while left:
        while size > left:
            size //= 2
        after = machine.step(choice, size * smallest) @ state
        if _stays(machine, choice, state, after, size * smallest, look=size > 2 ** (CROSSING_HALVINGS - TURN_HALVINGS)):
            state, left = after, left - size
        elif size > 1:
            size //= 2
        else:
            changes += 1
            if changes > MOST_CHANGES:
                if since - left < SMALL_SHARE * 2**CROSSING_HALVINGS:
                    raise InputError(TOO_STIFF)
                changes, since = 0, left
            state, left, size = after, left - 1, 2**CROSSING_HALVINGS
            choice = machine.choice(state)
    return state


def _stays(machine: Machine, choice: Choice, before: RealArray, after: RealArray, span: Second, *, look: bool) -> bool:
    """Return whether every damper is in its piece after a step, and, looking into the step, cannot have left it."""
    now = machine.sees @ after
    low, high, rates = machine.limits(choice)
    if np.any(now < low) or np.any(now > high):
        return False
    if not look:
        return True
    first, last = rates @ before, rates @ after
    turns = first * last < 0
    if not np.any(turns):
        return True
    # A damper that turns within the step gets no further than its rates at both ends carry it.
    was = machine.sees @ before
    upper = np.minimum(was + np.abs(first) * span, now + np.abs(last) * span)
    lower = np.maximum(was - np.abs(first) * span, now - np.abs(last) * span)
    return not np.any(turns & np.where(first > 0, upper > high, lower < low))


def observed(
    machine: Machine,
    car: Suspension,
    names: Sequence[str],
    states: RealArray,
    choices: Sequence[Choice],
    seen: RealArray,
) -> RealArray:
    """Return outputs, (output, sample); ``seen`` are the roads and their rates, (order, road, sample)."""
    rows, n = output_rows(car, names), len(car.coordinates)
    parts = [states[:n], states[n : 2 * n], np.empty((n, states.shape[1]))]
    for choice in set(choices):
        here = np.array([one == choice for one in choices])
        parts[2][:, here] = machine.generator(choice)[n : 2 * n] @ states[:, here]
    values = np.array([weights @ parts[order] for order, weights in zip(rows.orders, rows.coordinates, strict=True)])
    for at, (order, weights) in enumerate(zip(rows.orders, rows.roads, strict=True)):
        if np.any(weights):
            if order == 2:
                raise InputError(f"output {names[at]!r} depends on the acceleration of a road, which is not known")
            values[at] += weights @ seen[order]
    if not np.all(np.isfinite(values)):
        raise InputError(TOO_STIFF)
    return values
