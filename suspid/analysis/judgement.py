"""What an identification is worth, in words for one who was not there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from suspid.analysis.checks import (
    LEAST_EXPLAINED,
    as_sentence,
    circling_channels,
    explained_share,
    few_samples,
    growing_modes,
    halves_agree,
    late_motion,
    loud_residual,
    many,
    not_cross_checked,
    percent,
    precision,
    repeats_agree,
    spring_remarks,
    steady_tones,
    unexplained_channels,
    why_none,
)
from suspid.units import Ratio

if TYPE_CHECKING:
    from suspid.identification import Identification, Repeats
    from suspid.reconstruction import Reconstruction

Trust = Literal["sound", "care", "doubtful", "none"]

SAID = {
    "sound": "Trustworthy: every check that the record allows agrees.",
    "care": "Usable with care: read the remarks below first.",
    "doubtful": "Not to be relied on as it stands: see the remarks below.",
    "none": "No free decay of a mode could be told in this record.",
}


@dataclass(frozen=True, kw_only=True, slots=True)
class Judgement:
    """A verdict, what speaks for it and what against.

    Parameters
    ----------
    headline : str
        How many modes, in a few words.
    trust : {"sound", "care", "doubtful", "none"}
        How far the modes can be trusted; "none" where there are no modes.
    said : str
        The same as a sentence.
    support : tuple of str
        What speaks for the modes.
    doubts : tuple of str
        What speaks against them, or why there are none.
    notes : tuple of str
        What else there is to know.
    """

    headline: str
    trust: Trust
    said: str
    support: tuple[str, ...]
    doubts: tuple[str, ...]
    notes: tuple[str, ...] = ()


def judge(
    identification: Identification,
    *,
    decay_doubts: Sequence[str] = (),
    unrepaired: int = 0,
    repeats: Repeats | None = None,
    reconstruction: Reconstruction | None = None,
    level: Ratio = 0.95,
) -> Judgement:
    """Return what the identification is worth.

    Parameters
    ----------
    identification : Identification
        What was found.
    decay_doubts : sequence of str
        What is doubtful about the stretch that was used.
    unrepaired : int
        How many defects of the recording were seen and left alone.
    repeats : Repeats, optional
        Several decays, identified one by one and jointly.
    reconstruction : Reconstruction, optional
        Springs and dampers from these modes.
    level : float
        Probability of the intervals [1].

    Examples
    --------
    >>> from suspid import free_decay, identify, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=200)
    >>> found = identify(free_decay(car, np.arange(0, 10, 0.005), initial_state={"v_chassis": 1.0}))
    >>> judge(found).headline, judge(found).trust
    ('2 modes found', 'sound')
    """
    count = len(identification.modes)
    beside = [as_sentence(text) for text in decay_doubts]
    if unrepaired:
        beside.append(
            f"{many(unrepaired, 'defect')} of the recording {'was' if unrepaired == 1 else 'were'} seen and left "
            f"alone: see what was cleaned."
        )
    if not count:
        return Judgement(
            headline="No mode found",
            trust="none",
            said=SAID["none"],
            support=(),
            doubts=(*why_none(identification), *beside, *late_motion(identification)),
            notes=tuple(steady_tones(identification)),
        )
    grave, mild, support = [], list[str](), [*explained_share(identification)]
    best = float(np.max(identification.explained))
    if best < LEAST_EXPLAINED:
        grave.append(
            f"The fit explains {percent(best)} of the best channel: most of what moves there is no free decay of "
            f"these modes."
        )
        support = []
    grave += growing_modes(identification)
    known = precision(identification, level)
    for for_it, against in (halves_agree(identification), loud_residual(identification), known):
        support, mild = support + for_it, mild + against
    if best >= LEAST_EXPLAINED:
        mild += unexplained_channels(identification)
    few, blind = few_samples(identification), not_cross_checked(identification)
    mild += few
    notes = [*circling_channels(identification), *steady_tones(identification)]
    if not np.any(np.isfinite(identification.halves)) and blind:
        # Nothing but the fit itself speaks for the modes: that is not enough where it is loose as well.
        (grave if few or known[1] else mild).extend(blind)
    else:
        notes = [*blind, *notes]
    if repeats is not None:
        for_it, against = repeats_agree(repeats)
        support, mild = support + for_it, mild + against
    if reconstruction is not None:
        for_it, against = spring_remarks(reconstruction)
        support, mild = support + for_it, mild + against
    if np.any(identification.loudness > 1):
        mild += late_motion(identification)
    doubts = (*grave, *beside, *mild)
    trust: Trust = "doubtful" if grave else "care" if doubts else "sound"
    return Judgement(
        headline=f"{many(count, 'mode')} found",
        trust=trust,
        said=SAID[trust],
        support=tuple(support),
        doubts=doubts,
        notes=tuple(notes),
    )
