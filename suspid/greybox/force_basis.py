"""Forces of a damper as a sum over nodes of velocity, and friction."""

from __future__ import annotations

import itertools
import math

import numpy as np

from suspid.units import MetrePerSecond, RealArray

# Samples beyond the last node of each side: fewer do not carry a force.
FEWEST_BEYOND = 30
# Samples for each node, and most nodes: more let neighbours vary against each other without being nearer to a curve.
SAMPLES_A_NODE = 200
MOST_NODES = 36
# Error of the nodes beside a kink between them, over their distance and the root of the product of both bends: that of
# the best broken line over even velocities is 0.13 with the kink in the middle, 0.09 and 0.16 at a quarter.
BEND_ERROR = 0.13


def placed_nodes(velocity: RealArray, count: int, first: MetrePerSecond) -> RealArray:
    """Return nodes of velocity [m/s], ascending, with one at rest and ``count`` others.

    On each side the first node stands at ``first`` or where a node's share of the samples is met, the last one where
    `FEWEST_BEYOND` samples are further out; between them half the weight is on equal widths, half on equal numbers of
    samples.
    """
    nodes = [np.zeros(1)]
    for sign in (1.0, -1.0):
        side = np.sort(sign * velocity[sign * velocity > 0])
        last = side[-min(FEWEST_BEYOND, len(side))]
        begin = min(first, last / 2)
        grid = np.linspace(begin, last, 2001)
        share = np.searchsorted(side, grid) / len(side)
        place = (grid - begin) / (last - begin) + (share - share[0]) / max(share[-1] - share[0], 1e-12)
        wanted = max(count // 2, 2)
        nodes.append(sign * np.interp(np.linspace(0, 2, wanted), place, grid))
    return np.sort(np.concatenate(nodes))


def node_weights(velocity: RealArray, nodes: RealArray) -> RealArray:
    """Return the weights of the forces at the nodes in the force at velocities, (velocity, node)."""
    piece = np.clip(np.searchsorted(nodes, velocity) - 1, 0, len(nodes) - 2)
    share = (velocity - nodes[piece]) / (nodes[piece + 1] - nodes[piece])
    weights, row = np.zeros((len(velocity), len(nodes))), np.arange(len(velocity))
    weights[row, piece], weights[row, piece + 1] = 1 - share, share
    return weights


def smooth_weights(velocity: RealArray, nodes: RealArray, error: MetrePerSecond) -> RealArray:
    """Return the expected weights of the forces at the nodes, `node_weights`, at velocities with a normal error."""
    from scipy.special import ndtr

    slopes = np.diff(np.eye(len(nodes)), axis=0) / np.diff(nodes)[:, None]
    away = velocity[:, None] - nodes[1:-1]
    # A ramp from zero on: of a normal value, v Phi(v / error) + error phi(v / error).
    at = away / error
    ramps = away * ndtr(at) + error / math.sqrt(2 * math.pi) * np.exp(-(at**2) / 2)
    first = np.eye(len(nodes))[0] + (velocity - nodes[0])[:, None] * slopes[0]
    return np.asarray(first + ramps @ np.diff(slopes, axis=0))


def bend_covariance(nodes: RealArray, forces: RealArray) -> RealArray:
    """Return the covariance of the forces at the nodes because the curve may bend between them, (node, node).

    A kink between two nodes bends a broken line at both of them to one side, and moves both. A kink at a node, or the
    scatter of a straight line, does not. The force at rest is zero.
    """
    bends, found = np.diff(np.diff(forces) / np.diff(nodes)), np.zeros((len(nodes), len(nodes)))
    for i, (left, right) in enumerate(itertools.pairwise(bends), 1):
        variance = BEND_ERROR**2 * max(float(left * right), 0.0) * float(nodes[i + 1] - nodes[i]) ** 2
        found[i : i + 2, i : i + 2] += variance
    moving = nodes != 0
    return found * np.outer(moving, moving)


def node_slope(velocity: RealArray, nodes: RealArray, forces: RealArray) -> RealArray:
    """Return the damper rate at velocities [N s/m]."""
    piece = np.clip(np.searchsorted(nodes, velocity) - 1, 0, len(nodes) - 2)
    return np.asarray((np.diff(forces) / np.diff(nodes))[piece])


def sign_between(velocity: RealArray, error: MetrePerSecond) -> RealArray:
    """Return the expected sign of a velocity that is known with an error, averaged over the steps about each point.

    The expectation over a normal error is ``erf(v / (sqrt(2) error))``; its integral over a step in which the velocity
    changes evenly is exact.
    """
    from scipy.special import erf

    at = velocity / (math.sqrt(2) * error)
    integral = velocity * erf(at) + error * math.sqrt(2 / math.pi) * np.exp(-(at**2))
    change = np.diff(velocity)
    moves = np.abs(change) > 1e-3 * error
    mean = np.where(moves, np.diff(integral) / np.where(moves, change, 1.0), erf(at[:-1]))
    return np.concatenate([mean[:1], (mean[1:] + mean[:-1]) / 2, mean[-1:]])


def sign_slope(velocity: RealArray, width: MetrePerSecond) -> RealArray:
    """Return the derivative of a sign that is smoothed over some width [s/m]."""
    return np.asarray(math.sqrt(2 / math.pi) / width * np.exp(-(velocity**2) / (2 * width**2)))
