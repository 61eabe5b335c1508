"""Accelerations and travels of a record: found by name, in SI by the unit in brackets, with their weightings."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from suspid.cleaning import to_si
from suspid.errors import InputError
from suspid.io import LONGEST_READ, bare_name, bracketed_unit
from suspid.performance.figure_plan import (
    ACCELERATION,
    ANGLES,
    ROTATION,
    TRAVEL,
    VERTICAL,
    checked_weightings,
)
from suspid.performance.weightings import weighting_named
from suspid.signals import Signal
from suspid.units import RealArray
from suspid.values import nearest_names
from suspid.wording import Argument, AtCommandLine

ACCELERATIONS = ("m/s2", "rad/s2")
# Ends of names of what a record of a car holds besides accelerations.
NO_ACCELERATION = (TRAVEL, "_velocity", "_displacement", "_force", "_rate")
# Words in names of other motions and of forces.
OF_OTHER_MOTIONS = {
    "displacement", "travel", "position", "height", "lvdt", "stroke", "angle", "gyro", "gyroscope", "velocity", "speed",
    "force", "load", "strain", "rate",
}  # fmt: skip
# Units behind a name that are no part of it; single letters but g and units of SI alone would be.
SUFFIX = re.compile(
    r"(.*[^\W_])[_ .-]+(m?g|gal|[cm]m(?:/|p)s\^?2|(?:deg|rad|mm?|cm)(?:/|p)s2?|deg|mm|cm|dps)", re.IGNORECASE
)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Felt:
    """One channel of a record about its mean, in SI; ``kinds`` are its weightings, none of a travel."""

    name: str
    samples: RealArray
    turn: str  # what it is the acceleration of: m or rad
    kinds: tuple[str, ...]
    unit: str  # as the name states it; empty where it states none or SI
    level: float = 0.0  # its mean


def felt_of(
    signal: Signal, given: Mapping[str, str | Sequence[str]] | None
) -> tuple[tuple[Felt, ...], tuple[Felt, ...], tuple[str, ...]]:
    """Return accelerations with their weightings, travels, and names of travels in units that are none of length.

    Raises
    ------
    InputError
        If a channel is not there, no channel is one of acceleration, or the unit in its name is none of acceleration.
    """
    short = [bare_name(name) for name in signal.channels]
    names = [
        own if own not in signal.channels and short.count(own) == 1 else name
        for name, own in zip(signal.channels, short, strict=True)
    ]
    chosen = (
        _default(signal.channels, short, names)
        if given is None
        else _by_channel(checked_weightings(given), signal.channels, names)
    )
    if given is not None and not given:
        raise InputError(
            Argument("weightings", "{}"), " is empty; name a channel, or leave it out for all accelerations"
        )
    if not chosen:
        raise InputError(
            "no channel is named like an acceleration; state the weighting of those that are",
            *(
                AtCommandLine("weightings", f"{shlex.quote(name)}=Wk", f", with weightings as in {{{name!r}: 'Wk'}}")
                for name in [n for n in names if not _other(n)][:1]
            ),
        )
    felt = tuple(_felt(signal, names.index(name), name, kinds) for name, kinds in chosen.items())
    travels, unknown = [], []
    for i, name in enumerate(names):
        if short[i].endswith(TRAVEL) and name not in chosen:
            unit, factor, si = _unit(signal.channels[i])
            if si in ("m", ""):
                about = (signal.values[i] - signal.values[i].mean()) * factor
                travels.append(Felt(name=short[i], samples=about, turn="m", kinds=(), unit=unit))
            else:
                unknown.append(signal.channels[i])
    return felt, tuple(travels), tuple(unknown)


def shown_by(signal: Signal, felt: Sequence[Felt], *, asked: bool) -> tuple[tuple[Felt, ...], tuple[str, ...]]:
    """Return accelerations with those of their weightings of which a record shows anything, and the others.

    A record must last for a period of the fastest vibration that counts, and be sampled at twice the slowest.

    Raises
    ------
    InputError
        If a weighting that was asked for is none of these, or none is left of a channel.
    """
    seconds, top = signal.duration, 0.5 / signal.step
    kinds = dict.fromkeys(kind for one in felt for kind in one.kinds)
    hidden = [k for k in kinds if seconds * weighting_named(k).f2 < 1 or top <= weighting_named(k).f1]
    left = tuple(replace(one, kinds=tuple(k for k in one.kinds if k not in hidden)) for one in felt)
    if hidden and (asked or not all(one.kinds for one in left)):
        w = weighting_named(hidden[0])
        raise InputError(
            f"the record of {seconds:.3g} s at {1 / signal.step:.6g} Hz contains nothing in the band of {hidden[0]}, "
            f"{w.f1:g} to {w.f2:g} Hz; check the sampling rate, or record longer"
        )
    return left, tuple(hidden)


def _default(channels: Sequence[str], short: Sequence[str], names: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Return the weightings of channels that are named like accelerations."""
    return {
        name: ROTATION if own.removesuffix(ACCELERATION) in ANGLES or _unit(channel)[2] == "rad/s2" else VERTICAL
        for channel, name, own in zip(channels, names, short, strict=True)
        if _without_suffix(own)[0].endswith(ACCELERATION)
    }


def _by_channel(
    given: Mapping[str, tuple[str, ...]], channels: Sequence[str], names: Sequence[str]
) -> dict[str, tuple[str, ...]]:
    """Return weightings by the names that figures have; channels are named with or without their unit."""
    known = {**dict(zip(names, names, strict=True)), **dict(zip(channels, names, strict=True))}
    chosen: dict[str, tuple[str, ...]] = {}
    for channel, kinds in given.items():
        if channel not in known:
            raise InputError(
                Argument("weightings"), f": there is no channel {channel!r}.{nearest_names(channel, names)}"
            )
        if known[channel] in chosen:
            raise InputError(Argument("weightings"), f": channel {channel!r} is named twice")
        chosen[known[channel]] = kinds
    return chosen


def _felt(signal: Signal, row: int, name: str, kinds: tuple[str, ...]) -> Felt:
    channel = signal.channels[row]
    unit, factor, si = _unit(channel)
    turn = "rad" if bare_name(channel).removesuffix(ACCELERATION) in ANGLES else "m"
    if si not in (*ACCELERATIONS, ""):
        wanted = "rad/s2" if turn == "rad" else "m/s2"
        raise InputError(
            f"channel {channel!r}: {bracketed_unit(channel)} is not a known unit of acceleration; give it in "
            f"{wanted}, without a unit in its name (",
            Argument("scale"),
            " and ",
            Argument("rename"),
            "), or leave it out",
        )
    stem, suffix = ("", "") if unit or si else _without_suffix(channel)
    if suffix:
        raise InputError(
            f"channel {channel!r}: its name ends in {suffix}, which is a unit only in brackets: name it "
            f"'{stem} [{suffix}]' (",
            Argument("rename"),
            ")",
        )
    if not si and (channel.endswith(NO_ACCELERATION) or _other(channel)):
        raise InputError(
            Argument("weightings"),
            f": {channel!r} is not named like an acceleration, and only these are weighted; rename it",
        )
    mean = float(signal.values[row].mean())
    about = (signal.values[row] - mean) * factor
    if not np.ptp(about):
        raise InputError(f"channel {channel!r} shows no motion: constant at {signal.values[row, 0]:g}; leave it out")
    turn = si.partition("/")[0] or turn
    if si == "rad/s2" and (linear := [kind for kind in kinds if kind not in ROTATION]):
        raise InputError(
            Argument("weightings"),
            f": channel {channel!r} is a rotation, and {linear[0]} is for translation; give it {ROTATION[0]}",
        )
    return Felt(name=name, samples=np.asarray(about), turn=turn, kinds=kinds, unit=unit, level=mean * factor)


def _without_suffix(name: str) -> tuple[str, str]:
    """Return a name without the unit that it ends in, of any quantity in `SUFFIX`, and that unit; empty without one."""
    found = SUFFIX.fullmatch(name[:LONGEST_READ])
    if found is None:
        return name, ""
    return found[1], re.sub(r"p(s|h)", r"/\1", found[2].lower()) if "/" not in found[2] else found[2]


def _other(name: str) -> bool:
    """Return whether a word in a name says that it is something else than an acceleration."""
    words = re.findall(r"[a-z]+", re.sub(r"([a-z])([A-Z])", r"\1 \2", name[:LONGEST_READ]).lower())
    return bool(OF_OTHER_MOTIONS.intersection(words)) and not any(word.startswith(("acc", "beschl")) for word in words)


def _unit(channel: str) -> tuple[str, float, str]:
    """Return the unit in a channel's name where it is not SI, its factor and the SI unit; "?" of an unknown one."""
    unit = bracketed_unit(channel)
    if not unit:
        return "", 1.0, ""
    try:
        factor, si = to_si(1.0, unit)
    except InputError:
        return unit, 1.0, "?"
    return ("" if float(factor) == 1.0 else unit), float(factor), si
