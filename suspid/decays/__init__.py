"""Where a recording decays freely.

`find_decays` finds the stretches after a bump, a step or a release, verifies each start with `suspid.identify`,
and ranks them. Below it: `bursts` (what stands above the background), `trials` and `sketches` (quick fits),
`starts` (the first sample after the forcing) and `doubts` (what speaks against a stretch).
"""

from suspid.decays.find_decays import Decay, Decays, find_decays

__all__ = ["Decay", "Decays", "find_decays"]
