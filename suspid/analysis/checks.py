"""The checks behind a verdict: each returns sentences for and against, in words for one who was not there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from suspid.files import printable
from suspid.identification import late_start
from suspid.signals import as_signal
from suspid.units import Ratio
from suspid.words import Reason

if TYPE_CHECKING:
    from suspid.identification import Identification, Repeats
    from suspid.reconstruction import Reconstruction

# Below this share of a channel's energy, the modes are hardly those of the record.
LEAST_EXPLAINED = 0.5
# Halves of the decay that disagree by more than this many standard deviations are no chance.
APART = 3.0
# A damping ratio whose interval reaches this share of it is not known, or only roughly; a frequency likewise.
UNKNOWN_ZETA, ROUGH_ZETA, ROUGH_WN = 1.0, 0.25, 0.05
# Fewer samples for each unknown of a channel than this: the fit follows whatever moves.
SAMPLES_EACH = 8
# What falls by less than e to this over the record, and makes as many cycles, is steady.
STEADY, MANY_CYCLES = 1.0, 10.0
# Below this the channels of a mode are far from moving in phase or antiphase.
CIRCLING = 0.5

# Sentences that speak for the modes, and those that speak against them.
Both = tuple[list[str], list[str]]


def why_none(identification: Identification) -> list[str]:
    """Return why there is no mode."""
    considered = identification.considered
    away = [c for c in considered if c.remark.code in (Reason.OUTSIDE_THE_BAND, Reason.BEYOND)]
    if away:
        return [f"There is no mode in the band that was asked for; {many(len(away), 'pole')} outside it did stand out."]
    moved = [c for c in considered if c.removed]
    best = float(np.max(identification.explained))
    if moved or best > LEAST_EXPLAINED:
        return [
            f"Something moves ({percent(best)} of the best channel can be followed), but it is no free decay: "
            f"see what was considered and rejected."
        ]
    said = ["Nothing in the record decays like a mode and stands above its noise."]
    signal = as_signal(identification.response)
    strongest = considered[0].pole if considered else 0j
    if abs(strongest.real) * signal.duration < STEADY and strongest.imag * signal.duration > 2 * np.pi * MANY_CYCLES:
        said.append(
            f"What stands out most, at {strongest.imag / (2 * np.pi):.4g} Hz, does not decay: a steady line of "
            f"something that turns or hums, no mode."
        )
    return said


def late_motion(identification: Identification) -> list[str]:
    """Return a doubt where the largest motion comes late: the decay may begin there."""
    signal = as_signal(identification.response)
    late = late_start(signal)
    if late is None:
        return []
    return [
        f"The largest motion comes {late - signal.start:.3g} s after the start: if the decay begins there, cut the "
        f"record to it, from {late:.6g} s on."
    ]


def explained_share(identification: Identification) -> list[str]:
    """Return how much of the channels the fit explains."""
    share = identification.explained
    low, high = percent(float(np.min(share))), percent(float(np.max(share)))
    if float(np.min(share)) < LEAST_EXPLAINED:
        return [f"The fitted decay explains {high} of the energy of the best channel."]
    if len(share) == 1 or low == high:
        return [f"The fitted decay explains {low} of the energy of {'the' if len(share) == 1 else 'every'} channel."]
    return [f"The fitted decay explains {low} to {high} of the energy of the channels."]


def unexplained_channels(identification: Identification) -> list[str]:
    """Return a doubt where channels are hardly explained."""
    names = as_signal(identification.response).channels
    weak = [
        f"“{printable(name)}” ({percent(float(share))})"
        for name, share in zip(names, identification.explained, strict=True)
        if share < LEAST_EXPLAINED
    ]
    return [f"Little of some channels is explained: {listed(weak)}. They see noise, or other motion."] if weak else []


def growing_modes(identification: Identification) -> list[str]:
    """Return a doubt where a mode grows."""
    growing = [str(k) for k, pole in enumerate(identification.modes.poles, 1) if pole.real > 0]
    return [f"Mode {listed(growing)} grows: that is no free decay."] if growing else []


def halves_agree(identification: Identification) -> Both:
    """Return whether early and late decay agree, for and against."""
    apart = identification.halves
    known = np.isfinite(apart)
    against = [
        f"Early and late decay disagree on mode {k} by {value:.2g} standard deviations: friction, a spring that is "
        f"not linear, or something that still drives it."
        for k, value in enumerate(apart, 1)
        if value > APART
    ]
    if not np.any(known) or np.nanmax(apart) > APART:
        return [], against
    which = "every mode" if np.all(known) else f"mode {listed([str(k) for k in np.flatnonzero(known) + 1])}"
    said = f"Early and late decay agree on {which}, to {np.nanmax(apart):.1f} standard deviations at most."
    return [said], against


def not_cross_checked(identification: Identification) -> list[str]:
    """Return which modes one half of the decay alone does not hold."""
    pairs = np.array(identification.modes.kinds) == "pair"
    blind = [str(k) for k in np.flatnonzero(~np.isfinite(identification.halves) & pairs) + 1]
    if not blind:
        return []
    return [
        f"Mode {listed(blind)} could not be cross-checked between early and late decay: one part alone does not hold "
        f"{'it' if len(blind) == 1 else 'them'}."
    ]


def few_samples(identification: Identification) -> list[str]:
    """Return a doubt where a record is so short that poles enough follow whatever moves."""
    samples = as_signal(identification.response).values.shape[1]
    poles = [*identification.modes.poles, *(c.pole for c in identification.considered if c.removed)]
    unknowns = 1 + sum(2 if pole.imag else 1 for pole in poles)
    if samples >= SAMPLES_EACH * unknowns:
        return []
    return [f"The record has {samples} samples for {unknowns} amplitudes in each channel: so many follow any motion."]


def circling_channels(identification: Identification) -> list[str]:
    """Return which modes have channels out of phase."""
    if len(identification.modes.channels) < 2:
        return []
    pairs = np.array(identification.modes.kinds) == "pair"
    circling = [str(k) for k in np.flatnonzero(pairs & (identification.collinearity < CIRCLING)) + 1]
    if not circling:
        return []
    return [
        f"The channels of mode {listed(circling)} are far from moving in phase or antiphase: sensors of different "
        f"kinds (acceleration beside rate), or no mode of a structure."
    ]


def loud_residual(identification: Identification) -> Both:
    """Return whether what is left beside the modes is noise, for and against."""
    if identification.method == "ridge":
        return [], []
    loud = [f"{k} ({value:.2g} times)" for k, value in enumerate(identification.loudness, 1) if value > 1]
    if not loud:
        return ["What is left beside the modes is no louder than white noise."], []
    return (
        [],
        [
            f"What is left beside mode {listed(loud)} is louder than white noise: the noise is coloured, or the decay "
            f"is not quite linear or not alone. The intervals are widened for it."
        ],
    )


def precision(identification: Identification, level: Ratio) -> Both:
    """Return how well the modes are known, for and against."""
    modes = identification.modes
    if modes.covariance is None:
        return [], []
    ends = modes.interval(level)
    pairs = np.array(modes.kinds) == "pair"
    frequency = (ends.wn[:, 1] - modes.wn) / np.where(modes.wn > 0, modes.wn, 1.0)
    damping = (ends.zeta[:, 1] - modes.zeta) / np.where(modes.zeta != 0, np.abs(modes.zeta), 1.0)
    vague = [str(k) for k in np.flatnonzero(pairs & (damping > UNKNOWN_ZETA)) + 1]
    against = [f"The damping of mode {listed(vague)} is not known: its interval reaches zero."] if vague else []
    rough = pairs & ((damping > ROUGH_ZETA) & (damping <= UNKNOWN_ZETA) | (frequency > ROUGH_WN))
    against += [
        f"Mode {k + 1} is known only roughly: its frequency to {percent(float(frequency[k]), digits=2)}, its "
        f"damping ratio to {percent(float(damping[k]), digits=2)} of its value."
        for k in np.flatnonzero(rough)
    ]
    if not np.any(pairs) or against:
        return [], against
    said = (
        f"Frequencies are known to {percent(float(np.max(frequency[pairs])), digits=2)} or better, damping ratios to "
        f"{percent(float(np.max(damping[pairs])), digits=2)} of their value ({100 * level:g} % intervals)."
    )
    return [said], against


def steady_tones(identification: Identification) -> list[str]:
    """Return what tones were taken out with the fit."""
    tones = [c for c in identification.considered if c.removed and c.remark.code is Reason.TONE]
    if not tones:
        return []
    hertz = [f"{abs(c.pole) / (2 * np.pi):.4g}" for c in tones[:4]] + ["…"] * (len(tones) > 4)
    return [
        f"{many(len(tones), 'steady tone')} ({', '.join(hertz)} Hz) "
        f"{'was' if len(tones) == 1 else 'were'} taken out with the fit; what is explained contains "
        f"{'it' if len(tones) == 1 else 'them'}."
    ]


def repeats_agree(repeats: Repeats) -> Both:
    """Return whether several decays agree, for and against."""
    apart = [str(k) for k, agreement in enumerate(repeats.consistency, 1) if agreement.widening > 1]
    if apart:
        return [], [
            f"The {len(repeats.spans)} decays disagree on joint mode {listed(apart)} by more than their noise: "
            f"frequency or damping depends on the amplitude, or something changed between them."
        ]
    if not len(repeats.modes):
        return [], [f"Nothing decays like a mode in all of the {len(repeats.spans)} decays."]
    return [f"{len(repeats.spans)} decays agree on the modes within their noise."], []


def spring_remarks(found: Reconstruction) -> Both:
    """Return what is to be said of springs and dampers, for and against."""
    against = []
    if not found.explains:
        against.append("The car as described does not explain these modes within their uncertainty.")
    if found.alternatives:
        against.append(
            f"{many(len(found.alternatives), 'other set')} of springs and dampers "
            f"{'has' if len(found.alternatives) == 1 else 'have'} the same modes: see below what tells them apart."
        )
    if against or found.chi_square is None or not found.freedom:
        return [], against
    return ["The car as described explains the modes within their uncertainty."], against


def percent(share: float, *, digits: int = 4) -> str:
    """Return a share in percent."""
    return f"{100 * share:.{digits}g} %" if share < 0.99995 else "100.0 %"


def many(count: int, noun: str) -> str:
    """Return a number with its noun."""
    return f"{count} {noun}{'s' * (count != 1)}"


def listed(parts: Sequence[str]) -> str:
    """Return names in a row, the last one after an “and”."""
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
