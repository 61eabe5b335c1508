"""What an identification is worth, in words for one who was not there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from suspid.files import printable
from suspid.identification import REASONS, late_start
from suspid.signals import as_signal
from suspid.units import Ratio

if TYPE_CHECKING:
    from suspid.identification import Identification
    from suspid.reconstruction import Reconstruction

Trust = Literal["sound", "care", "doubtful", "none"]

# Below this share of a channel's energy, the modes are hardly those of the record.
LEAST_EXPLAINED = 0.5
# Halves of the decay that disagree by more than this many standard deviations are no chance.
APART = 3.0
# A damping ratio whose interval is wider than itself by this is not known.
UNKNOWN_ZETA = 1.0
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
            f"{_many(unrepaired, 'defect')} of the recording {'was' if unrepaired == 1 else 'were'} seen and left "
            f"alone: see what was cleaned."
        )
    if not count:
        return Judgement(
            headline="No mode found",
            trust="none",
            said=SAID["none"],
            support=(),
            doubts=(*_why_none(identification), *beside, *_late(identification)),
            notes=tuple(_motions(identification)),
        )
    grave, mild, support = [], list[str](), [*_explained(identification)]
    best = float(np.max(identification.explained))
    if best < LEAST_EXPLAINED:
        grave.append(
            f"The fit explains {_percent(best)} of the best channel: most of what moves there is no free decay of "
            f"these modes."
        )
        support = []
    for check in (_growing, _halves, _loudness, _precision):
        for_it, against, heavy = check(identification, level)
        support += for_it
        (grave if heavy else mild).extend(against)
    if best >= LEAST_EXPLAINED:
        mild += _unexplained(identification)
    notes = [*_blind(identification), *_motions(identification)]
    if reconstruction is not None:
        for_it, against = _springs(reconstruction)
        support, mild = support + for_it, mild + against
    if np.any(identification.loudness > 1):
        mild += _late(identification)
    doubts = (*grave, *beside, *mild)
    trust: Trust = "doubtful" if grave else "care" if doubts else "sound"
    return Judgement(
        headline=f"{_many(count, 'mode')} found",
        trust=trust,
        said=SAID[trust],
        support=tuple(support),
        doubts=doubts,
        notes=tuple(notes),
    )


Checked = tuple[list[str], list[str], bool]


def _why_none(identification: Identification) -> list[str]:
    considered = identification.considered
    away = [c for c in considered if c.reason in (REASONS["outside the band"], REASONS["beyond"])]
    if away:
        return [
            f"There is no mode in the band that was asked for; {_many(len(away), 'pole')} outside it did stand out."
        ]
    moved = [c for c in considered if c.removed]
    best = float(np.max(identification.explained))
    if moved or best > LEAST_EXPLAINED:
        return [
            f"Something moves ({_percent(best)} of the best channel can be followed), but it is no free decay: "
            f"see what was considered and rejected."
        ]
    return ["Nothing in the record decays like a mode and stands above its noise."]


def _late(identification: Identification) -> list[str]:
    signal = as_signal(identification.response)
    late = late_start(signal)
    if late is None:
        return []
    return [
        f"The largest motion comes {late - signal.start:.3g} s after the start: if the decay begins there, cut the "
        f"record to it, from {late:.6g} s on."
    ]


def _explained(identification: Identification) -> list[str]:
    share = identification.explained
    low, high = _percent(float(np.min(share))), _percent(float(np.max(share)))
    if float(np.min(share)) < LEAST_EXPLAINED:
        return [f"The fitted decay explains {high} of the energy of the best channel."]
    if len(share) == 1 or low == high:
        return [f"The fitted decay explains {low} of the energy of {'the' if len(share) == 1 else 'every'} channel."]
    return [f"The fitted decay explains {low} to {high} of the energy of the channels."]


def _unexplained(identification: Identification) -> list[str]:
    names = as_signal(identification.response).channels
    weak = [
        f"“{printable(name)}” ({_percent(float(share))})"
        for name, share in zip(names, identification.explained, strict=True)
        if share < LEAST_EXPLAINED
    ]
    return [f"Little of some channels is explained: {_listed(weak)}. They see noise, or other motion."] if weak else []


def _growing(identification: Identification, level: Ratio) -> Checked:
    del level
    growing = [str(k) for k, pole in enumerate(identification.modes.poles, 1) if pole.real > 0]
    return [], [f"Mode {_listed(growing)} grows: that is no free decay."] if growing else [], True


def _halves(identification: Identification, level: Ratio) -> Checked:
    del level
    apart = identification.halves
    known = np.isfinite(apart)
    against = [
        f"Early and late decay disagree on mode {k} by {value:.2g} standard deviations: friction, a spring that is "
        f"not linear, or something that still drives it."
        for k, value in enumerate(apart, 1)
        if value > APART
    ]
    if not np.any(known) or np.nanmax(apart) > APART:
        return [], against, False
    which = "every mode" if np.all(known) else f"mode {_listed([str(k) for k in np.flatnonzero(known) + 1])}"
    said = f"Early and late decay agree on {which}, to {np.nanmax(apart):.1f} standard deviations at most."
    return [said], against, False


def _blind(identification: Identification) -> list[str]:
    pairs = np.array(identification.modes.kinds) == "pair"
    blind = [str(k) for k in np.flatnonzero(~np.isfinite(identification.halves) & pairs) + 1]
    if not blind:
        return []
    return [
        f"Mode {_listed(blind)} could not be cross-checked between early and late decay: one part alone does not hold "
        f"{'it' if len(blind) == 1 else 'them'}."
    ]


def _loudness(identification: Identification, level: Ratio) -> Checked:
    del level
    if identification.method == "ridge":
        return [], [], False
    loud = [f"{k} ({value:.2g} times)" for k, value in enumerate(identification.loudness, 1) if value > 1]
    if not loud:
        return ["What is left beside the modes is no louder than white noise."], [], False
    return (
        [],
        [
            f"What is left beside mode {_listed(loud)} is louder than white noise: the noise is coloured, or the decay "
            f"is not quite linear or not alone. The intervals are widened for it."
        ],
        False,
    )


def _precision(identification: Identification, level: Ratio) -> Checked:
    modes = identification.modes
    if modes.covariance is None:
        return [], [], False
    ends = modes.interval(level)
    pairs = np.array(modes.kinds) == "pair"
    frequency = (ends.wn[:, 1] - modes.wn) / np.where(modes.wn > 0, modes.wn, 1.0)
    damping = (ends.zeta[:, 1] - modes.zeta) / np.where(modes.zeta != 0, np.abs(modes.zeta), 1.0)
    vague = [str(k) for k in np.flatnonzero(pairs & (damping > UNKNOWN_ZETA)) + 1]
    against = [f"The damping of mode {_listed(vague)} is not known: its interval reaches zero."] if vague else []
    if not np.any(pairs) or vague:
        return [], against, False
    said = (
        f"Frequencies are known to {_percent(float(np.max(frequency[pairs])), digits=2)} or better, damping ratios to "
        f"{_percent(float(np.max(damping[pairs])), digits=2)} of their value ({100 * level:g} % intervals)."
    )
    return [said], against, False


def _motions(identification: Identification) -> list[str]:
    tones = [c for c in identification.considered if c.removed and c.reason == REASONS["tone"]]
    if not tones:
        return []
    hertz = [f"{abs(c.pole) / (2 * np.pi):.4g}" for c in tones[:4]] + ["…"] * (len(tones) > 4)
    return [
        f"{_many(len(tones), 'steady tone')} ({', '.join(hertz)} Hz) stood beside the decay and "
        f"{'was' if len(tones) == 1 else 'were'} taken out with the fit; what is explained contains "
        f"{'it' if len(tones) == 1 else 'them'}."
    ]


def _springs(found: Reconstruction) -> tuple[list[str], list[str]]:
    against = []
    if not found.explains:
        against.append("The car as described does not explain these modes within their uncertainty.")
    if found.alternatives:
        against.append(
            f"{_many(len(found.alternatives), 'other set')} of springs and dampers "
            f"{'has' if len(found.alternatives) == 1 else 'have'} the same modes: see below what tells them apart."
        )
    if against or found.chi_square is None or not found.freedom:
        return [], against
    return ["The car as described explains the modes within their uncertainty."], against


def _percent(share: float, *, digits: int = 4) -> str:
    return f"{100 * share:.{digits}g} %" if share < 0.99995 else "100.0 %"


def _many(count: int, noun: str) -> str:
    return f"{count} {noun}{'s' * (count != 1)}"


def _listed(parts: Sequence[str]) -> str:
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} and {parts[-1]}"


def as_sentence(text: str) -> str:
    """Return the text with a capital and a full stop.

    Examples
    --------
    >>> as_sentence("still driven")
    'Still driven.'
    """
    text = printable(text.strip())
    return text[:1].upper() + text[1:] + "." * (not text.endswith((".", "!", "?")))
