"""Decays that end where a channel rests: friction holds its mass, and the structure is another one."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from suspid.analysis.choice import settled
from suspid.analysis.settings import Settings
from suspid.analysis.tries import tried
from suspid.analysis.until_locked import AS_ONE_AFTER
from suspid.analysis.used import Used, used_of
from suspid.decays import Decays, rests_from, stops_at
from suspid.signals import as_signal
from suspid.words import Level

if TYPE_CHECKING:
    import control

# Share of a stretch that must be left where it ends with the first channel that rests. A channel that rests for longer
# is no mass of the motion.
SHARE_LEFT = 0.5
# Samples in a row that are alike: of two the last ones of a record may be by chance.
FEWEST_ALIKE = 3


def until_one_rests(record: control.TimeResponseData, best: Used, settings: Settings) -> Used:
    """Return the decay up to where its first channel rests, if more than noise was left and less is then.

    All may rest within noise, in which a decay seems to go on. With one mass held, another moves by itself: no fit
    with the modes of both explains what is left of the motion.
    """
    found = best.identification
    if len(best.used) != 1 or not isinstance(best.decays, Decays) or found is None or settled(found):
        return best
    part, decay = as_signal(best.record), best.used[0]
    channels = [
        replace(part, values=row[None], channels=(name,)) for name, row in zip(part.channels, part.values, strict=True)
    ]
    # Where the only channel rests, the stretch has ended but for noise.
    every = float(part.timepts[stops_at(part.values, most=AS_ONE_AFTER) - 1])
    stop = min([every, *(map(rests_from, channels) if len(channels) > 1 else ())])
    early = stop <= decay.start + SHARE_LEFT * (decay.stop - decay.start)
    if (early and stop < every) or stop > part.timepts[-1] - (FEWEST_ALIKE - 0.5) * part.step:
        return best
    used = used_of(record, best.decays, replace(decay, stop=stop))
    less = tried(used.record, settings)
    if less is None or len(less.modes) < len(found.modes):
        return best
    quieter = np.max(less.loudness, initial=0.0) < np.max(found.loudness, initial=0.0)
    better = settled(less) or (quieter and less.verdict.level >= max(found.verdict.level, Level.CARE))
    return replace(used, identification=less) if better and len(less.modes) else best
