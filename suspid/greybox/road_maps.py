"""The roads under all wheels from the wheels' measured motion: the car turned round.

With q the free coordinates and g the wheels, ``D q + ... = 0`` gives ``q = -D_ff^-1 D_fg g`` whatever the roads r do,
and the equations of the wheels give ``r = -B^-1 (D_gg - D_gf D_ff^-1 D_fg) g`` with B the forces of the tires per road.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from suspid.greybox.measured_causes import WheelProblem
from suspid.greybox.transfers import Physics
from suspid.reconstruction import Unknowns
from suspid.units import ComplexArray, RealArray


class RoadMap(NamedTuple):
    """Maps at every line."""

    roads: ComplexArray  # (line, road, cause): from the channels of the causes
    tires: ComplexArray  # (line, wheel, road): forces of the tires per road
    outputs: ComplexArray  # (line, output, cause): what the other channels show


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class MapProblem:
    """The car of one logger, with the unknowns of both steps."""

    problem: WheelProblem
    number: int  # of the logger
    tires: Unknowns  # of the second step
    roads: tuple[int, ...]  # all of the car, in the order in which they are returned

    def physics(self, z: RealArray, x: RealArray) -> Physics:
        """Return all parameters at unknowns z of the first step and x of the second."""
        first, u, p = self.problem.physics(z, self.number), self.tires, self.tires.parameters(x)
        struts, added = len(u.car.struts), self.problem.sources[self.number].trial.added
        values = np.concatenate([first.stiffness, first.damping, first.masses])
        values[u.rows] = p[u.rows]
        on_wheels = [row for row in u.rows if row >= 2 * struts]
        values[on_wheels] += added[[row - 2 * struts for row in on_wheels]]
        stiffness, damping, masses = np.split(values, [struts, 2 * struts])
        return replace(first, stiffness=stiffness, damping=damping, masses=masses)

    def maps(self, s: ComplexArray, z: RealArray, x: RealArray) -> RoadMap:
        """Return the maps at lines s."""
        layout, car, physics = self.problem.sources[self.number].layout, self.tires.car, self.physics(z, x)
        arms, on_roads = car.arms(car.coordinates), car.arms(car.roads)[:, list(self.roads)]
        b = physics.stiffness + physics.damping * s[:, None] / (1 + physics.relaxation * s[:, None])
        D = np.einsum("lj,ja,jb->lab", b, arms, arms)
        own = np.arange(len(physics.masses))
        D[:, own, own] += s[:, None] ** 2 * physics.masses
        g, f = list(layout.given), list(layout.free)
        follows = -np.linalg.solve(D[:, f][:, :, f], D[:, f][:, :, g])
        on_wheels = D[:, g][:, :, g] + D[:, g][:, :, f] @ follows
        tires = np.einsum("lj,ja,jr->lar", b, arms[:, g], on_roads)
        derive = s[:, None] ** layout.orders * physics.gains * np.exp(-s[:, None] * physics.delays)
        shown = derive[:, :, None] * (layout.on_free @ follows + layout.on_given)
        back = np.linalg.inv(shown[:, list(layout.causes)])
        return RoadMap(
            roads=-np.linalg.solve(tires, on_wheels) @ back, tires=tires, outputs=shown[:, list(layout.outputs)] @ back
        )
