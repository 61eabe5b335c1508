"""The rows of a report's tables: each value rounded together with its interval, names made safe to show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from suspid.files import printable
from suspid.reporting.numerals import NOTHING, Quantity, digits, quantity, signed
from suspid.samples import held
from suspid.signals import as_signal
from suspid.units import Ratio
from suspid.words import MOST_LISTED, Code

if TYPE_CHECKING:
    from suspid.identification import Considered, Identification, Repeats
    from suspid.model import ModalSet

# Sentences that are listed of poles rejected for one kind of reason; the JSON has all.
MOST_REASONS = 2


@dataclass(frozen=True, kw_only=True, slots=True)
class ModeRow:
    """A mode: frequency [Hz], angular frequency [rad/s], damping ratio [1], and how it stood the checks."""

    number: int
    frequency: Quantity
    wn: Quantity
    zeta: Quantity
    note: str
    halves: str
    loudness: str
    collinearity: str


@dataclass(frozen=True, kw_only=True, slots=True)
class ChannelRow:
    """A channel: its unit, the share that is explained [%], the noise, and how white the residual is [1]."""

    name: str
    unit: str
    explained: str
    noise: str
    whiteness: str


@dataclass(frozen=True, kw_only=True, slots=True)
class PoleRow:
    """Poles that are no modes for one reason: how many, their frequencies [Hz], damping ratios [1], and why."""

    number: int
    frequency: str
    zeta: str
    reason: str
    removed: bool


@dataclass(frozen=True, kw_only=True, slots=True)
class JointRow:
    """A mode of several decays: as in `ModeRow`, and whether the decays agree on it."""

    frequency: Quantity
    wn: Quantity
    zeta: Quantity
    chi_square: str
    freedom: str
    chance: str


@dataclass(frozen=True, kw_only=True, slots=True)
class RepeatRows:
    """The modes of all decays jointly, and those of each: its name, span [s], frequencies [Hz], damping ratios [1]."""

    joint: tuple[JointRow, ...]
    single: tuple[tuple[str, str, str, str], ...]


def mode_rows(identification: Identification, level: Ratio) -> list[ModeRow]:
    """Return a row for each mode."""
    modes, halves = identification.modes, identification.halves
    if not len(modes):
        return []
    notes = {"pair": "", "real": "overdamped: one real pole", "rigid": "rigid body: pole at zero"}
    collinearity = identification.collinearity if modes.shapes is not None else np.full(len(modes), np.nan)
    rows = []
    for k, (kind, (frequency, wn, zeta)) in enumerate(zip(modes.kinds, mode_quantities(modes, level), strict=True)):
        judged = identification.method != "ridge"
        rows.append(
            ModeRow(
                number=k + 1,
                frequency=frequency,
                wn=wn,
                zeta=zeta,
                note=notes[kind],
                halves=_or_nothing(float(halves[k]), "{:.1f}"),
                loudness=digits(float(identification.loudness[k]), 3) if judged else NOTHING,
                collinearity=_or_nothing(float(collinearity[k]), "{:.3f}"),
            )
        )
    return rows


def mode_quantities(modes: ModalSet, level: Ratio) -> list[tuple[Quantity, Quantity, Quantity]]:
    """Return frequency [Hz], angular frequency [rad/s] and damping ratio [1] of each mode."""
    ends = modes.interval(level) if modes.covariance is not None else None
    turn, rows = 2 * np.pi, []
    for k, (wn, zeta, kind) in enumerate(zip(modes.wn.tolist(), modes.zeta.tolist(), modes.kinds, strict=True)):
        reach = None if ends is None else float(ends.wn[k, 1] - wn)
        reach_zeta = None if ends is None or kind != "pair" else float(ends.zeta[k, 1] - zeta)
        hertz = quantity(wn / turn, None if reach is None else reach / turn)
        rows.append((hertz, quantity(wn, reach), quantity(zeta, reach_zeta, digits=4)))
    return rows


def repeat_rows(repeats: Repeats, level: Ratio) -> RepeatRows:
    """Return the rows of the modes of several decays."""
    joint = tuple(
        JointRow(
            frequency=frequency,
            wn=wn,
            zeta=zeta,
            # A mode of one decay alone agrees with nothing.
            chi_square=f"{agreement.chi_square:.1f}" if agreement.freedom else NOTHING,
            freedom=f"{agreement.freedom}" if agreement.freedom else NOTHING,
            chance=_or_nothing(agreement.probability, "{:.2g}"),
        )
        for (frequency, wn, zeta), agreement in zip(
            mode_quantities(repeats.modes, level), repeats.consistency, strict=True
        )
    )
    names = repeats.names or [f"decay {k}" for k in range(1, len(repeats.each) + 1)]
    single = tuple(
        (
            printable(name),
            signed(f"{start:.6g} … {stop:.6g}"),
            ", ".join(_with_reach(row[0]) for row in mode_quantities(found.modes, level)) or NOTHING,
            ", ".join(_with_reach(row[2]) for row in mode_quantities(found.modes, level)) or NOTHING,
        )
        for name, (start, stop), found in zip(names, repeats.spans, repeats.each, strict=True)
    )
    return RepeatRows(joint=joint, single=single)


def _with_reach(one: Quantity) -> str:
    return f"{one.value} ± {one.reach}" if one.reach else one.value


def channel_rows(identification: Identification, units: Sequence[str]) -> list[ChannelRow]:
    """Return a row for each channel."""
    return [
        ChannelRow(
            name=printable(name),
            unit=printable(unit) or NOTHING,
            explained=signed(f"{100 * share:.2f}"),
            noise=signed(f"{std:#.3g}"),
            whiteness=signed(f"{round(white, 2) + 0.0:+.2f}"),
        )
        for name, unit, share, std, white in zip(
            as_signal(held(identification, "response")).channels,
            units,
            identification.explained,
            identification.noise_std,
            identification.whiteness,
            strict=True,
        )
    ]


def pole_rows(identification: Identification) -> list[PoleRow]:
    """Return a row for each reason why poles that were considered are no modes."""
    kinds: dict[tuple[Code, bool], list[Considered]] = {}
    for considered in identification.considered:
        kinds.setdefault((considered.remark.code, considered.removed), []).append(considered)
    return [_pole_row(some, removed=removed) for (_, removed), some in kinds.items()]


def _pole_row(some: Sequence[Considered], *, removed: bool) -> PoleRow:
    """Return the row of poles of one kind, by frequency."""
    reasons = list(dict.fromkeys(printable(c.reason) for c in some))
    more = f"; … {len(reasons) - MOST_REASONS} more in the JSON" if len(reasons) > MOST_REASONS else ""
    hertz = sorted(abs(c.pole) / (2 * np.pi) for c in some)
    zeta = sorted(-c.pole.real / max(abs(c.pole), 1e-300) for c in some)
    shown = ", ".join(digits(one, 4) for one in hertz[:MOST_LISTED])
    return PoleRow(
        number=len(some),
        frequency=shown + (f", … {digits(hertz[-1], 4)}" if len(hertz) > MOST_LISTED else ""),
        zeta=signed(f"{zeta[0]:.3g}" if len(zeta) == 1 else f"{zeta[0]:.3g} … {zeta[-1]:.3g}"),
        reason="; ".join(reasons[:MOST_REASONS]) + more,
        removed=removed,
    )


def _or_nothing(value: float, form: str) -> str:
    return form.format(value) if np.isfinite(value) else NOTHING
