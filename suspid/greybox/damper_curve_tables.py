"""Tables of a damper's curve: forces in rebound and compression, friction, stiffness and equivalent damping."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.text_tables import TERMINAL, rounded, spread, text_table
from suspid.units import RealArray

if TYPE_CHECKING:
    from suspid.greybox.damper_curves import DamperCurve


def curve_table(found: DamperCurve) -> str:
    """Return the forces in rebound and compression as a table, at most twelve speeds."""
    nodes = found.velocities
    speeds = nodes[nodes > 0]
    kept = speeds[np.unique(np.linspace(0, len(speeds) - 1, 12).round().astype(int))]
    columns: dict[str, list[str]] = {"speed [m/s]": [f"{v:.3f}" for v in kept]}
    for name, sign in (("rebound", 1.0), ("compression", -1.0)):
        forces, stds = force_at(found, sign * kept)
        inside = sign * kept >= nodes[0]
        columns[f"{name} [N]"] = [text if use else "" for text, use in zip(rounded(forces, stds), inside, strict=True)]
        columns[f"± {name[0]}"] = [spread(s) if use else "" for s, use in zip(stds, inside, strict=True)]
    return text_table(columns, widest=TERMINAL)


def force_at(found: DamperCurve, velocity: RealArray) -> tuple[RealArray, RealArray]:
    """Return the force without friction at velocities, and its standard deviation [N]."""
    nodes = found.velocities
    piece = np.clip(np.searchsorted(nodes, velocity) - 1, 0, len(nodes) - 2)
    share = (velocity - nodes[piece]) / (nodes[piece + 1] - nodes[piece])
    weights, row = np.zeros((len(velocity), len(nodes))), np.arange(len(velocity))
    weights[row, piece], weights[row, piece + 1] = 1 - share, share
    variance = np.einsum("ij,jk,ik->i", weights, found.covariance[1:-1, 1:-1], weights)
    return weights @ found.forces, np.sqrt(variance)


def summary(found: DamperCurve) -> str:
    """Return friction, stiffness and equivalent damping as text."""

    def pm(value: float, std: float) -> str:
        return f"{rounded(np.array([value]), np.array([std]))[0]} ± {spread(std)}"

    speed = np.sqrt(2) * found.velocity_std
    lines = [f"stiffness {pm(found.stiffness, found.stiffness_std)} N/m"]
    if found.friction_sought:
        lines.append(f"friction {pm(found.friction, found.friction_std)} N")
    damping = pm(found.equivalent_damping(), found.equivalent_damping_std())
    lines.append(f"viscous damping of equal work at an amplitude of {speed:.3g} m/s: {damping} N s/m")
    return "\n".join(lines)
