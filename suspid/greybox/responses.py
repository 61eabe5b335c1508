"""Output error of one record: motion from an unknown start under known inputs, with noise on every channel.

``y = C x + D w + offset + e``. The state at the start and the offset of each channel are linear and projected out;
the result is the residual and its derivatives by the parameters of the suspension.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from suspid.greybox.dynamics import DEGREE, Plant, plant_of, transition
from suspid.greybox.further import INPUTS, Sensing
from suspid.greybox.trials import Hold, Trial, input_pieces
from suspid.model import Suspension
from suspid.simulation import recursion
from suspid.units import RealArray


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class OutputError:
    """The residual of one record at given parameters."""

    residual: RealArray  # (channel, sample), in the unit of each channel
    slope: RealArray  # (channel, sample, parameter): derivatives of the residual, projected like it
    linear: int  # number of unknowns that were projected out


def output_error(
    car: Suspension,
    trial: Trial,
    p: RealArray,
    rows: Sequence[int],
    *,
    std: RealArray,
    hold: Hold,
    sensing: Sensing,
    mounts: Sequence[int] = (),
) -> OutputError:
    """Return residual and derivatives of a record, each channel weighted by its noise ``std`` (channel,).

    ``rows`` are parameters of the car and relaxations of ``mounts``, then all gains and delays of `Sensing`.
    """
    struts, n = len(car.struts), len(car.coordinates)
    own = rows[: len(rows) - len(sensing.gain_of) - len(sensing.delay_of)]
    loaded = p.copy()
    loaded[2 * struts : 2 * struts + n] += trial.added
    plant = plant_of(car, loaded, own, roads=trial.roads, forces=trial.forces, mounts=mounts)
    step = transition(plant, trial.step)
    seen = _seen(plant, trial, n, sensing)
    C, D = seen.C, seen.D
    count, size, channels = trial.count, plant.states, len(trial.channels)
    whole_count = count + 2 * trial.margin
    free = seen.own(recursion(step.E.T, None, C.T, whole_count).transpose(2, 1, 0), count) / std[:, None, None]
    basis, back = _orthonormal(
        _without_offsets(free).reshape(channels * count, size), np.sqrt(np.einsum("ijk,ijk->k", free, free))
    )
    linear = basis.shape[1] + channels
    forcing, pieces, jumps = None, np.zeros((whole_count, 0)), np.zeros((whole_count, 0))
    y = trial.values.copy()
    if len(trial.inputs):
        pieces, jumps = input_pieces(trial, hold)
        strokes = plant.F[:, size + 1 :: DEGREE]
        forcing = (step.G @ pieces.T + strokes @ jumps.T)[:, :, None]
        y -= seen.own(C @ recursion(step.E, forcing, np.zeros((size, 1)), whole_count)[:, :, 0] + D @ pieces.T, count)
    left = (_without_offsets(y) / std[:, None]).ravel()
    amounts = basis.T @ left
    rest = (left - basis @ amounts).reshape(channels, count) * std[:, None]
    if not len(rows):
        return OutputError(residual=rest, slope=np.zeros((channels, count, 0)), linear=linear)
    start = (back @ amounts)[:size]
    x = recursion(step.E, forcing, start[:, None], whole_count)[:, :, 0]
    whole = np.concatenate([x.T, pieces], axis=1)
    # Slopes of one step as one matrix: (state and input coefficient) by (state, parameter).
    turns = np.concatenate([step.by_state, step.by_input], axis=2).transpose(2, 1, 0)
    pushed = (whole @ turns.reshape(len(turns), -1)).reshape(whole_count, size, len(own))
    if len(trial.inputs):
        struck = jumps @ plant.f[:, size + 1 :: DEGREE].T
        pushed += plant.b.T[None] * struck[:, None, :]
    moved = recursion(step.E, pushed.transpose(1, 0, 2), np.zeros((size, len(own))), whole_count)
    slope = (C @ moved.reshape(size, -1)).reshape(channels, whole_count, len(own))
    if np.any(seen.slopes):
        direct = whole @ seen.slopes.reshape(-1, whole.shape[1]).T
        slope += direct.reshape(whole_count, channels, len(own)).swapaxes(0, 1)
    slope = seen.own(np.concatenate([slope, _by_sensing(seen, whole, sensing)], axis=2), count)
    flat = (_without_offsets(slope) / -std[:, None, None]).reshape(channels * count, len(rows))
    flat -= basis @ (basis.T @ flat)
    return OutputError(residual=rest, slope=flat.reshape(slope.shape) * std[:, None, None], linear=linear)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class _Seen:
    """How the channels show the state and the coefficients of inputs."""

    C: RealArray  # (channel, state)
    D: RealArray  # (channel, input coefficient)
    slopes: RealArray  # (channel, parameter, state and input coefficient): derivatives of both
    rate: RealArray  # (channel, state and input coefficient): what moves on in a second
    first: tuple[int, ...]  # (channel,): the sample of the inputs that the first one of the channel shows

    def own(self, rows: RealArray, count: int) -> RealArray:
        """Return what each channel shows at its samples, of rows (channel, sample of the inputs, …)."""
        if rows.shape[1] == count:
            return rows
        return np.stack([row[k : k + count] for row, k in zip(rows, self.first, strict=True)])


def _seen(plant: Plant, trial: Trial, n: int, sensing: Sensing) -> _Seen:
    """Return what the channels show.

    Without inputs, a delay counts from the latest channel: at the others the state moves on, ``C exp(A (tau_max -
    tau))``, whose start is unknown anyway. With inputs a channel shows the motion a part of a step after some sample,
    which is as exact as that of a whole step.
    """
    size, width = plant.F.shape
    C, D = np.zeros((len(trial.channels), size)), np.zeros((len(trial.channels), width - size))
    slopes = np.zeros((len(trial.channels), len(plant.b), width))
    for row, order in enumerate(trial.orders):
        weights = trial.weights[row]
        if order < 2:
            C[row, order * n : (order + 1) * n] = weights
        else:
            C[row], D[row] = weights @ plant.F[n : 2 * n, :size], weights @ plant.F[n : 2 * n, size:]
            slopes[row] = (plant.b[:, n : 2 * n] @ weights)[:, None] * plant.f
        D[row, order : DEGREE * len(trial.roads) : DEGREE] += trial.road_weights[row, list(trial.roads)]
    rate = C @ plant.F
    for i in range(width - size - 1):
        # The derivative of a coefficient is the next one, up to the last of each input.
        rate[:, size + i + 1] += D[:, i] if (i + 1) % DEGREE else 0.0
    first = []
    forced = len(trial.inputs) > 0
    for row, ahead in enumerate((0.0 if forced else np.max(sensing.delays)) - sensing.delays):
        steps = int(np.floor(ahead / trial.step)) if forced else 0
        first.append(trial.margin + steps)
        part = float(ahead - steps * trial.step)
        if part > 0:
            later = transition(plant, part)
            on_state, on_input = slopes[row, :, :size], slopes[row, :, size:]
            slopes[row] = np.concatenate(
                [
                    on_state @ later.E + C[row] @ later.by_state,
                    on_state @ later.G + C[row] @ later.by_input + on_input @ later.shift,
                ],
                axis=1,
            )
            C[row], D[row] = C[row] @ later.E, C[row] @ later.G + D[row] @ later.shift
            rate[row] = np.concatenate(
                [rate[row, :size] @ later.E, rate[row, :size] @ later.G + rate[row, size:] @ later.shift]
            )
    gains = sensing.gains[:, None]
    return _Seen(C=C * gains, D=D * gains, slopes=slopes * gains[:, :, None], rate=rate * gains, first=tuple(first))


def _by_sensing(seen: _Seen, whole: RealArray, sensing: Sensing) -> RealArray:
    """Return the derivatives of all channels by gains and delays, (channel, sample, unknown)."""
    slope = np.zeros((len(seen.C), len(whole), len(sensing.gain_of) + len(sensing.delay_of)))
    size = seen.C.shape[1]
    for i, channel in enumerate((*sensing.gain_of, *sensing.delay_of)):
        if channel is None:
            continue
        rows = slice(None) if channel == INPUTS else slice(channel, channel + 1)
        if i < len(sensing.gain_of):
            high = sensing.input_gain
            factor = np.array([[-high]]) if channel == INPUTS else high * sensing.gains[rows, None]
            slope[rows, :, i] = (seen.C[rows] @ whole[:, :size].T + seen.D[rows] @ whole[:, size:].T) / factor
        else:
            slope[rows, :, i] = (seen.rate[rows] if channel == INPUTS else -seen.rate[rows]) @ whole.T
    return slope


def _without_offsets(rows: RealArray) -> RealArray:
    """Return channels (channel, sample, …) without their means: what an unknown offset leaves."""
    return np.asarray(rows - np.mean(rows, axis=1, keepdims=True))


def _orthonormal(columns: RealArray, norm: RealArray) -> tuple[RealArray, RealArray]:
    """Return an orthonormal basis of columns (sample, column), and how it gives their coefficients.

    ``norm`` is that of each column with its offsets: what is left of a constant is rounding.
    """
    norm = np.where(norm > 0, norm, 1.0)
    q, r = np.linalg.qr(columns / norm)
    u, s, v = np.linalg.svd(r)
    # Columns of the unknown start, of unit length, that add less than this to the others are not seen by the channels.
    keep = s > 1e-10
    return q @ u[:, keep], (v[keep].T / s[keep]) / norm[:, None]
