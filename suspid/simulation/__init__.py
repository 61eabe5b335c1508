"""Responses of a model: exact free decays, and noise added to a record.

`free_decay` evaluates ``C expm(A t) x_0`` to rounding. `add_noise` adds white noise of a given signal-to-noise
ratio. Every random number comes from the generator that the caller passes.
"""

from suspid.simulation.add_noise import add_noise
from suspid.simulation.free_decay import free_decay

__all__ = ["add_noise", "free_decay"]
