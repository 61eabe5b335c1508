"""Modes that are not quite linear: friction, drag, and springs and dampers that bend.

Forces that follow the measured motion drive the linear modes (nonlinear identification through feedback of the outputs,
Adams and Allemang, J. Sound Vib. 238, 2000): one mode then explains what would take several poles. `find_forces` looks
for them, `modes_of_bent` makes modes of what it finds, `AmplitudeDependence` is how one of them depends on amplitude.
"""

from suspid.identification.nonlinear.dependence import AmplitudeDependence
from suspid.identification.nonlinear.estimates import modes_of_bent
from suspid.identification.nonlinear.feedback import Bent
from suspid.identification.nonlinear.forces import Force, ForceKind
from suspid.identification.nonlinear.own import at_multiple
from suspid.identification.nonlinear.patience import patience
from suspid.identification.nonlinear.search import find_forces
from suspid.identification.nonlinear.signs import unlike_linear

__all__ = [
    "AmplitudeDependence",
    "Bent",
    "Force",
    "ForceKind",
    "at_multiple",
    "find_forces",
    "modes_of_bent",
    "patience",
    "unlike_linear",
]
