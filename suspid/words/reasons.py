"""Codes and sentences: why a pole is not a mode."""

from __future__ import annotations

from suspid.words.remarks import Code, sentence


class Reason(Code):
    """Why a pole is not among the modes."""

    TONE = (
        "tone",
        sentence(
            lambda n: (
                f"a slow mode or a tone that fades: it loses {100 * float(str(n['share'])):.3g} % within the record"
                if "share" in n
                else "a slow mode or a tone: it begins with the decay, and is not seen to fade within it"
                if "begun" in n
                else "steady tone: no decay is seen within the record"
            )
        ),
    )
    DRIFT = "drift", "drift: it decays more slowly than the record lasts"
    GROWING = "growing", "it grows"
    LINE = "line", "part of a steady line: rotating parts of varying speed"
    COMB = "comb", "it hardly decays, at a multiple of the frequency that the steady tones share: it is driven"
    OF_TONE = (
        "of tone",
        "it hardly decays, at a multiple of the frequency of a stronger steady tone: a harmonic of that",
    )
    PULSE = "pulse", "the poles follow a pulse of force, not a decay: their motions cancel each other"
    BY_CHANCE = (
        "by chance",
        "doubtful, and {unlike} of the {others} other stretches that look like decays show none of these modes: by "
        "chance, driven motion looks like a decay",
    )
    UNSUPPORTED = (
        "unsupported",
        "doubtful, and nothing but the fit supports it: neither the halves of the stretch nor another stretch",
    )
    SWELLS = (
        "swells",
        "the motion swells to its largest and fades as one smooth wave: nothing set it free, and a swept sine or a "
        "modulated tone looks the same",
    )
    STANDS_STILL = "stands still", "it would still swing where the record stands still: friction stops the motion"
    NO_SWING = "no swing", "doubtful, and damped before it swings: a pulse of force looks the same"
    UNSURE = "unsure", "its decay is not significant against the residual near it"
    UNKNOWN = "unknown", "not determined: the record leaves its frequency and damping open"
    TRACE = (
        "trace",
        "a trace: its damping or its frequency is hardly known, and its energy is next to nothing beside the strongest "
        "mode; what a sensor adds looks the same",
    )
    OF_NO_MODE = "of no mode", "a multiple, or a sum, of motion whose own frequency is not determined"
    UNDER_A_CYCLE = "under a cycle", "less than one cycle in the record"
    A_FEW_SAMPLES = "a few samples", "decayed within a few samples"
    BEGINNING = "beginning", "together with others it fits only the first samples: motion before the free decay"
    OF_START = "of the start", "hardly known, and a later start does without it: a force that ends looks the same"
    OUTSIDE_THE_BAND = "outside the band", "outside the band"
    NEAR_NYQUIST = "near Nyquist", "too near half the sampling rate, or above it, to be told from another motion"
    BEYOND = "beyond", "weaker than the requested modes"
    REAL_OR_PAIR = "real or pair", "one real pole or a heavily damped pair: the record does not distinguish them"
    SPLIT = (
        "split",
        sentence(
            lambda n: "part of another mode" + (f", {n['linewidths']:.2g} linewidths away" if "linewidths" in n else "")
        ),
    )
    UNRESOLVED = (
        "unresolved",
        "possibly a second mode close to another: gain {gain:.3g}, {needed:.3g} and a different shape required",
    )
    TOO_WEAK = "too weak", "not significant: gain {gain:.3g}, {needed:.3g} required"
    TOO_MANY = (
        "too many",
        "one more than the {most} pairs of poles that are looked for: gain {gain:.3g}, {needed:.3g} required",
    )
    NOT_SIGNIFICANT = (
        "not significant",
        "not significant: gain {times:.2g} × the BIC penalty, {needed:g} × required near this residual",
    )
    FOLLOWED = (
        "followed",
        "kept as a mode, since most of the motion follows it: gain {times:.2g} × the BIC penalty, {needed:g} × "
        "required near this residual",
    )
    NOT_NEEDED = "not needed", "not needed in addition to the others"
    BENT = "bent", "drift: removed with the offset, as a parabola"
    SAME_MODE = "same mode", "part of mode {mode}, whose frequency and damping depend on its amplitude"
    HARMONIC = (
        "harmonic",
        sentence(
            lambda n: (
                f"{n['multiple']} times mode {n['mode']}: a harmonic of its nonlinear motion"
                if n["multiple"]
                else f"the mean of mode {n['mode']}, which shifts with its amplitude: its motion is nonlinear"
            )
        ),
    )
    COMBINATION = "combination", "the {word} of modes {mode} and {other}: their motion is nonlinear"
    DISTORTION = "distortion", "no stronger than the residual of the nonlinear forces"
