"""Find free decays in a recording.

`find_decays` finds the events in a recording (a bump, a step, a release), finds where the excitation of each ends,
checks each decay with `identify` and ranks them. Below it: `envelopes` (band power above the background), `bursts`
(the events), `trials` and `sketches` (quick fits), `starts`, `predictions` and `verification` (the first sample of the
decay), `refusals`, `doubts`, `others` and `kinds` (what is said of it), `fading` (large swings), `candidates` (all of
that for one event), `tails` (the free end of a driven record) and `releases` (a car that is pushed and let go again and
again).
"""

from suspid.decays.decay import FIT, LITTLE, Decay, Decays, by_chance, is_grave
from suspid.decays.envelopes import finest
from suspid.decays.find_decays import decay_at_end, find_decays
from suspid.decays.others import SAME_MODE, SMALL, in_common, not_far_weaker, share_of
from suspid.decays.predictions import at_rest_from, released_at, releases_before, rests_from
from suspid.decays.refusals import DRIVEN
from suspid.decays.rests import STARTS_AFTER_REST, rest_of, stops_at
from suspid.decays.sketches import LOOK_BLOCKS, clearly_driven
from suspid.decays.trials import FEWEST_EARLY, FEWEST_STRETCHES, TRIAL_PARTS, unexplained

__all__ = [
    "DRIVEN",
    "FEWEST_EARLY",
    "FEWEST_STRETCHES",
    "FIT",
    "LITTLE",
    "LOOK_BLOCKS",
    "SAME_MODE",
    "SMALL",
    "STARTS_AFTER_REST",
    "TRIAL_PARTS",
    "Decay",
    "Decays",
    "at_rest_from",
    "by_chance",
    "clearly_driven",
    "decay_at_end",
    "find_decays",
    "finest",
    "in_common",
    "is_grave",
    "not_far_weaker",
    "released_at",
    "releases_before",
    "rest_of",
    "rests_from",
    "share_of",
    "stops_at",
    "unexplained",
]
