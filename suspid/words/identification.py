"""Codes and sentences: why a pole is not a mode, and the checks behind the verdict on modes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from suspid.wording import AtCommandLine
from suspid.words.remarks import Code, Number, amount, count, in_a_row, percent, sentence


def _percent(number: Number) -> str:
    share = float(str(number))
    return f"{100 * share:.4g} %" if share < 0.99995 else "100.0 %"


def _names(number: Number) -> str:
    return in_a_row(number) if isinstance(number, tuple) else str(number)


def _several(number: Number) -> bool:
    return isinstance(number, tuple) and len(number) > 1


def _modes(number: Number) -> str:
    return f"{'modes' if _several(number) else 'mode'} {_names(number)}"


def _rough(n: Mapping[str, Number]) -> list[str]:
    names = {"wn": "frequency", "zeta": "damping ratio"}
    return [f"the {name} is known only to {percent(float(str(n[key])))}" for key, name in names.items() if key in n]


def _over_amplitude(n: Mapping[str, Any]) -> str:
    """Return frequency and damping at the largest and the smallest amplitude; a frequency that is the same once."""
    ends = [f"zeta {n[f'{end}_zeta']:.2g} ± {n[f'{end}_within']:.1g} at {n[end]:.3g}" for end in ("high", "low")]
    hertz = [f"{n[f'{end}_hz']:.4g} Hz" for end in ("high", "low")]
    if hertz[0] == hertz[1]:
        return f"{', '.join(ends)}, and {hertz[0]} at both"
    return ", ".join(f"{one} and {other}" for one, other in zip(hertz, ends, strict=True))


class ModeCheck(Code):
    """Checks of an identification, for and against."""

    NOT_IN_BAND = (
        "not in band",
        sentence(
            lambda n: (
                f"No mode lies in the given band; {count(int(str(n['poles'])), 'pole')} outside it "
                f"{'is' if n['poles'] == 1 else 'are'} significant."
            )
        ),
    )
    NO_FREE_DECAY = (
        "no free decay",
        sentence(
            lambda n: (
                f"The motion ({_percent(n['explained'])} of the best channel is explained) is not a free decay of "
                f"modes: see the rejected poles."
            )
        ),
    )
    NOTHING_DECAYS = "nothing decays", "No pole stands out as a decaying mode."
    STEADY_LINE = (
        "steady line",
        "The strongest pole, at {hertz:.4g} Hz, does not decay: a steady line of rotating parts or hum, not a mode.",
    )
    LATE_MOTION = (
        "late motion",
        sentence(
            lambda n: (
                f"The largest motion comes {n['delay']:.3g} s after the start, at {n['time']:.6g} s: the record may "
                f"not decay from its first sample on. Look for the decay in it"
                f"{AtCommandLine('decay', 'auto', otherwise=' (find_decays, analyse)')}."
            )
        ),
    )
    HELD_UP = (
        "held up",
        sentence(
            lambda n: (
                f"The largest motion comes {n['delay']:.3g} s after the start, at {n['time']:.6g} s, when "
                f"every mode would have fallen to {_percent(n['fallen'])} or less: something drives it until then."
            )
        ),
    )
    EXPLAINED = (
        "explained",
        sentence(
            lambda n: (
                f"The fit explains {_percent(n['least'])} to {_percent(n['most'])} of the energy of the channels."
                if _percent(n["least"]) != _percent(n["most"])
                else f"The fit explains {_percent(n['most'])} of the energy of "
                f"{'every channel' if int(str(n['channels'])) > 1 else 'the channel'}."
            )
        ),
    )
    BEST_EXPLAINED = (
        "best channel explained",
        sentence(lambda n: f"The fit explains {_percent(n['most'])} of the energy of the best channel."),
    )
    HARDLY_EXPLAINED = (
        "hardly explained",
        sentence(
            lambda n: (
                f"The fit explains only {_percent(n['most'])} of the best channel: most of its motion is not a free "
                f"decay of these modes."
            )
        ),
    )
    CHANNELS_UNEXPLAINED = (
        "channels unexplained",
        sentence(lambda n: f"Little of some channels is explained: {n['channels']}. They carry noise or other motion."),
    )
    GROWING = (
        "growing modes",
        sentence(
            lambda n: (
                f"{_modes(n['modes']).capitalize()} {'grow' if _several(n['modes']) else 'grows'}: this is not a free "
                f"decay."
            )
        ),
    )
    HALVES_AGREE = (
        "halves agree",
        sentence(
            lambda n: (
                f"The first and second half of the decay agree on {n['which']} within {n['most']:.1f} "
                "standard deviations."
            )
        ),
    )
    HALVES_DISAGREE = (
        "halves disagree",
        sentence(
            lambda n: (
                f"The first and second half of the decay disagree on mode {n['mode']} by "
                f"{amount(float(str(n['apart'])))} standard deviations: friction, a nonlinear spring, or an excitation "
                f"that still acts."
            )
        ),
    )
    NOT_CROSS_CHECKED = (
        "not cross-checked",
        sentence(
            lambda n: (
                f"{_modes(n['modes']).capitalize()} could not be checked against the halves of the decay: a fit "
                f"to one half alone does not show {'them' if _several(n['modes']) else 'it'}."
            )
        ),
    )
    UNRESOLVED = (
        "unresolved",
        sentence(
            lambda n: (
                f"{_modes(n['modes']).capitalize()} may {'each ' if _several(n['modes']) else ''}be two close modes, "
                f"or one that is not quite linear: the record does not decide. The intervals cover both."
            )
        ),
    )
    PARTS = (
        "parts",
        sentence(
            lambda n: (
                f"{_modes(n['modes']).capitalize()} each lie within the width of the line of another, and what is left "
                f"near them is no noise: they may be parts of a mode that is not linear."
            )
        ),
    )
    BROAD_AND_NARROW = (
        "broad and narrow",
        sentence(
            lambda n: (
                f"{_modes(n['modes']).capitalize()} lie within the width of one line, one fades much faster, and no "
                f"channel tells them apart: a single mode whose damping falls with its amplitude looks the same."
            )
        ),
    )
    IN_A_ROW = (
        "in a row",
        sentence(
            lambda n: (
                f"{_modes(n['modes']).capitalize()} stand side by side, more than {n['channels']} "
                f"channel{'' if n['channels'] == 1 else 's'} can tell apart: a fit to noise in a band looks the same."
            )
        ),
    )
    PULSE_TRAIN = (
        "pulse train",
        "The modes lie at multiples of {hertz:.4g} Hz and decay alike: pulses {seconds:.3g} s apart, each lower than "
        "the one before, look the same.",
    )
    STANDS_STILL = (
        "stands still",
        "The motion stops, and some of the poles that fit it would not: friction acts, and the intervals do not hold "
        "what it does to the values.",
    )
    HARMONICS = (
        "harmonics",
        "Harmonics of the modes decay with them: a spring, damper or sensor is nonlinear. The values are those of "
        "the nearest linear decay; the intervals do not contain the effect of the nonlinearity.",
    )
    MIDDLE = (
        "middle",
        "Beside the swings something fades, about as fast, without swinging. An AC-coupled sensor makes that of any "
        "motion; a damper, spring or sensor that is not linear moves the middle of the swings so: then the values are "
        "those of the nearest linear decay, and the intervals do not contain the effect of the nonlinearity.",
    )
    ONE_SHAPE = (
        "one shape",
        sentence(
            lambda n: (
                f"{'A single channel does' if n['channels'] == 1 else 'Channels that all move alike do'} not tell a "
                f"mode from a force that ends: a pulse without resonance looks the same."
            )
        ),
    )
    FEW_SAMPLES = "few samples", "Too few samples ({samples}) for {unknowns} amplitudes in each channel."
    OUT_OF_PHASE = (
        "out of phase",
        sentence(
            lambda n: (
                f"The channels of {_modes(n['modes'])} are neither in phase nor in antiphase: sensors of "
                f"different kinds (acceleration and rate), or not a mode of a structure."
            )
        ),
    )
    MULTIPLE = (
        "multiple",
        "Mode {other} turns at {multiple} times the frequency of mode {one} and is, as far as is known, damped "
        "alike: what a swing does across its way, or a sensor or spring that bends, looks the same. It may be no mode "
        "of its own.",
    )
    RESIDUAL_WHITE = "residual white", "The residual near the modes is no larger than white noise."
    RESIDUAL_LOUD = (
        "residual loud",
        sentence(
            lambda n: (
                f"The residual near {_modes(n['modes'])} exceeds white noise: the noise is coloured, the decay "
                f"is not quite linear, or there is other motion. The intervals are widened."
            )
        ),
    )
    FOLLOWED = (
        "followed",
        sentence(
            lambda n: (
                f"Most of the motion follows {_modes(n['modes'])}, but the residual near "
                f"{'them' if _several(n['modes']) else 'it'} is not noise: the decay is nonlinear, or there is other "
                f"motion. The values are means over the decay."
            )
        ),
    )
    SHARED_NOISE = (
        "shared noise",
        "Channels {one!r} and {other!r} share noise (correlation of the residuals {correlation:.2f}): they are not "
        "independent, and the intervals are widened. Leave out a channel that is computed from others.",
    )
    RESIDUAL_COLOURED = (
        "residual coloured",
        "The residual is not white (lag-1 correlation {correlation:+.2f} in channel {channel!r}): the model does not "
        "describe all of the record.",
    )
    RESIDUAL_LINE = (
        "residual line",
        "A steady line at {hertz:.4g} Hz remains in the residual: rotating parts, hum, an excitation still acting, or "
        "a mode that hardly decays.",
    )
    RESIDUAL_MODE = (
        "residual mode",
        "Motion at {hertz:.4g} Hz that dies away remains in the residual: a mode that the fit does not contain.",
    )
    LITTLE_EXPLAINED = (
        "little explained",
        sentence(
            lambda n: (
                f"Only {_percent(n['most'])} of the energy of the best channel is explained; the rest is noise or "
                f"other motion."
            )
        ),
    )
    FEW_CYCLES = (
        "few cycles",
        "Mode {mode} makes only {cycles:.2g} cycles in the part that is used, and has not decayed by its end.",
    )
    REAL_ONLY = (
        "real poles only",
        "All modes are real poles: a drift or a filter decays in the same way.",
    )
    KNOWN = (
        "precision",
        sentence(
            lambda n: (
                f"Frequencies are known to {percent(float(str(n['wn'])))} or better, damping ratios to "
                f"{percent(float(str(n['zeta'])))} of their value ({100 * float(str(n['level'])):g} % intervals)."
            )
        ),
    )
    DAMPING_UNKNOWN = (
        "damping unknown",
        sentence(
            lambda n: (
                f"The damping of {_modes(n['modes'])} is not known: "
                f"{'their intervals reach' if _several(n['modes']) else 'its interval reaches'} zero."
            )
        ),
    )
    MOSTLY_OPEN = (
        "mostly open",
        sentence(
            lambda n: (
                f"{_modes(n['modes']).capitalize()}, most of all, are hardly known: as many poles follow any motion, "
                f"as one that friction stops."
            )
        ),
    )
    KNOWN_ROUGHLY = (
        "known roughly",
        sentence(lambda n: f"Mode {n['mode']}: {in_a_row(_rough(n))} of its value."),
    )
    DROPPED = (
        "dropped",
        sentence(
            lambda n: (
                f"{count(int(str(n['number'])), 'significant pole')} beyond the requested modes, not in the table: at "
                f"{n['hertz']} Hz."
            )
        ),
    )
    BANDWIDTH = (
        "bandwidth",
        "The bandwidth {bandwidth:.4g} is used only for the scalogram and the skeletons: these modes were found by "
        "likelihood; method 'ridge' finds them with the wavelet.",
    )
    CANDIDATES = (
        "candidates",
        "The candidate bandwidths are used only for the scalogram and the skeletons: these modes were found by "
        "likelihood; method 'ridge' finds them with the wavelet.",
    )
    TOO_MANY = (
        "too many",
        "The search for modes ended at {most} pairs of poles, and at least one more ({hertz} Hz) stands out: those "
        "found are bent by what is not fitted, and some are missing. Filter the record to a band with fewer modes.",
    )
    TRACES = (
        "traces",
        sentence(
            lambda n: (
                f"{count(int(str(n['number'])), 'trace')} ({n['hertz']} Hz) {'is' if n['number'] == 1 else 'are'} not "
                f"among the modes: weak, and hardly known. Less noise would show whether "
                f"{'it is a mode' if n['number'] == 1 else 'they are modes'}."
            )
        ),
    )
    STEADY_TONES = (
        "steady tones",
        sentence(
            lambda n: (
                f"{count(int(str(n['number'])), 'steady tone')} ({n['hertz']} Hz) "
                f"{'was' if n['number'] == 1 else 'were'} removed with the fit; the explained share contains "
                f"{'it' if n['number'] == 1 else 'them'}."
            )
        ),
    )
    FADING_TONES = (
        "fading tones",
        sentence(
            lambda n: (
                f"A slow mode may be missing: motion at {n['hertz']} Hz begins with the decay or fades within it, but "
                f"loses too little to tell a mode from a tone. It was removed with the fit; a longer record tells."
            )
        ),
    )
    GROWING_BESIDE = (
        "growing beside",
        sentence(
            lambda n: (
                f"Motion at {n['hertz']} Hz grows within the record, in as many poles as there are modes, or more: "
                f"something drives it, and the fit follows that."
            )
        ),
    )
    BEGUN_TONES = (
        "begun tones",
        sentence(
            lambda n: (
                f"{n['number']} tones ({n['hertz']} Hz) begin with the decay and do not fade: the motion is still "
                f"driven, or is none of modes, and the fit follows it."
            )
        ),
    )
    AMPLITUDE = (
        "amplitude",
        sentence(
            lambda n: (
                f"Mode {n['mode']} depends on its amplitude: {_over_amplitude(n)} (in the unit of channel "
                f"{n['channel']!r}). The table has means; its frequency is that at {n['holds']:.3g}."
            )
        ),
    )
    OUTSIDE = (
        "outside",
        "Motion at {hertz} Hz decays beside the modes and is not in the fit: further modes, or what its forces do not "
        "describe.",
    )
    NONLINEAR = "nonlinear", sentence(lambda n: f"The decay is not linear: the fit contains {_names(n['forces'])}.")
    FLASH = (
        "flash",
        sentence(
            lambda n: (
                f"{_modes(n['modes']).capitalize()} {'are' if _several(n['modes']) else 'is'} over in a few samples, "
                "long before the others have begun to decay: a switch or a contact at the release looks the same."
            )
        ),
    )
    BEATS = (
        "beats",
        "The damping rises and falls again as the motion dies, or feeds the motion: two close modes that beat look the "
        "same.",
    )
    NONE_REPEATED = (
        "none repeated",
        "No mode is in more than one of the {decays} decays: whether they agree cannot be said.",
    )
    REPEATS_AGREE = "repeats agree", "{decays} decays agree on the modes within their noise."
    REPEATS_DISAGREE = (
        "repeats disagree",
        sentence(
            lambda n: (
                f"The {n['decays']} decays disagree on joint {_modes(n['modes'])} by more than their noise: "
                f"{'' if n.get('compared_at') else 'frequency or damping depends on amplitude, or '}something changed "
                f"between them. The intervals are widened."
            )
        ),
    )
    AT_COMMON_AMPLITUDES = (
        "at common amplitudes",
        sentence(
            lambda n: (
                f"The decays depend on their amplitude: the table has {_modes(n['modes'])} at the amplitude in the "
                f"middle of what all decays with the mode met, or between them, where they are compared."
            )
        ),
    )
    NO_COMMON_AMPLITUDE = (
        "no common amplitude",
        sentence(
            lambda n: (
                f"The decays met no amplitude of {_modes(n['modes'])} in common: the table has the mean over the "
                f"cycles of each."
            )
        ),
    )
    NO_COMMON_MODE = "no common mode", "No mode decays in all of the {decays} decays."


class AmplitudeRemark(Code):
    """What two results that depend on their amplitude were compared at."""

    COMPARED_AT = (
        "compared at",
        "Mode {mode} depends on its amplitude: compared at {amplitude:.3g} (in the unit of channel {channel!r}), the "
        "middle of what both met, or between them.",
    )
    NONE_IN_COMMON = (
        "none in common",
        "Mode {mode} depends on its amplitude, and no amplitude is known that both met: a difference may be that of "
        "amplitudes.",
    )


class Headline(Code):
    """Headline of the result."""

    MODES = "modes", sentence(lambda n: f"{count(int(str(n['modes'])), 'mode')} found")
    NO_MODE = "no mode", "no mode found"
