"""The rows of a report's tables: each value rounded together with its interval, names made safe to show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from suspid.files import printable
from suspid.levels import normal_reach
from suspid.reconstruction import parameter_values, unit_of
from suspid.signals import as_signal
from suspid.units import Ratio

if TYPE_CHECKING:
    from suspid.identification import Identification, Repeats
    from suspid.model import ModalSet
    from suspid.reconstruction import Reconstruction

NOTHING = "–"


@dataclass(frozen=True, kw_only=True, slots=True)
class Quantity:
    """A value and half the width of its interval as texts; the latter is empty where there is none."""

    value: str
    reach: str = ""


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
    """A pole that is no mode, and why."""

    frequency: str
    wn: str
    zeta: str
    reason: str
    removed: bool


@dataclass(frozen=True, kw_only=True, slots=True)
class ParameterRow:
    """A spring, a damper or a mass: value with interval, ends of that, or held at its nominal value."""

    name: str
    unit: str
    value: Quantity
    lower: str
    upper: str
    held: bool
    twins: tuple[str, ...]


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
    """The modes of all decays jointly, and those of each: its span [s], frequencies [Hz] and damping ratios [1]."""

    joint: tuple[JointRow, ...]
    single: tuple[tuple[str, str, str], ...]


def quantity(value: float, reach: float | None, *, digits: int = 6) -> Quantity:
    """Return a value rounded to the second digit of its interval; without one, to this number of significant digits.

    Examples
    --------
    >>> quantity(3.38582, 0.00123)
    Quantity(value='3.3858', reach='0.0012')
    >>> quantity(199876.4, 349.6)
    Quantity(value='199880', reach='350')
    """
    if reach is None or not np.isfinite(reach):
        return Quantity(value=signed(f"{value:.{digits}g}"))
    if reach <= 0:
        return Quantity(value=signed(f"{value:.{digits}g}"), reach="0")
    places = decimals(reach)
    return Quantity(value=fixed(value, places), reach=fixed(reach, places))


def decimals(reach: float) -> int:
    """Return how many decimals show two significant digits of a width; fewer than none for tens and more."""
    places = 1 - int(np.floor(np.log10(reach)))
    # 0.0996 is 0.10, with one decimal less than 0.099.
    return 1 - int(np.floor(np.log10(round(reach, places))))


def fixed(value: float, places: int) -> str:
    """Return a value with a number of decimals; a negative number rounds before the point."""
    return signed(f"{round(value, places):.{min(max(places, 0), 15)}f}")


def signed(text: str) -> str:
    """Return the text of a number with a true minus sign."""
    return text.replace("-", "−")


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
                loudness=f"{identification.loudness[k]:.3g}" if judged else NOTHING,
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
            chi_square=f"{agreement.chi_square:.1f}",
            freedom=f"{agreement.freedom}",
            chance=_or_nothing(agreement.probability, "{:.2g}"),
        )
        for (frequency, wn, zeta), agreement in zip(
            mode_quantities(repeats.modes, level), repeats.consistency, strict=True
        )
    )
    single = tuple(
        (
            signed(f"{start:.6g} … {stop:.6g}"),
            ", ".join(f"{wn / (2 * np.pi):.4g}" for wn in found.modes.wn) or NOTHING,
            signed(", ".join(f"{zeta:.3g}" for zeta in found.modes.zeta)) or NOTHING,
        )
        for (start, stop), found in zip(repeats.spans, repeats.each, strict=True)
    )
    return RepeatRows(joint=joint, single=single)


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
            as_signal(identification.response).channels,
            units,
            identification.explained,
            identification.noise_std,
            identification.whiteness,
            strict=True,
        )
    ]


def pole_rows(identification: Identification) -> list[PoleRow]:
    """Return a row for each pole that was considered and is no mode."""
    return [
        PoleRow(
            frequency=f"{abs(c.pole) / (2 * np.pi):.4g}",
            wn=f"{abs(c.pole):.4g}",
            zeta=signed(f"{-c.pole.real / max(abs(c.pole), 1e-300):.3g}"),
            reason=printable(c.reason),
            removed=c.removed,
        )
        for c in identification.considered
    ]


def parameter_rows(found: Reconstruction, level: Ratio) -> list[ParameterRow]:
    """Return a row for each spring and damper (and free mass), those held last, with their values in every twin."""
    values = parameter_values(found.suspension)
    twins = [parameter_values(car) for car in found.alternatives]
    ends = found.interval(level) if found.covariance is not None else {}
    stds = [None] * len(found.parameters) if found.covariance is None else np.sqrt(np.diag(found.covariance)).tolist()
    rows = []
    for name, std in zip(found.parameters, stds, strict=True):
        # From the standard deviation: an end that lies on a bound must not sharpen the value.
        reach = None if std is None else normal_reach(level) * std
        places = decimals(reach) if reach else None
        rows.append(
            ParameterRow(
                name=printable(name),
                unit=unit_of(name),
                value=quantity(values[name], reach),
                lower=_end(ends[name][0], places) if name in ends else NOTHING,
                upper=_end(ends[name][1], places) if name in ends else NOTHING,
                held=False,
                twins=tuple(signed(f"{twin[name]:.5g}") for twin in twins),
            )
        )
    rows += [
        ParameterRow(
            name=printable(name),
            unit=unit_of(name),
            value=quantity(values[name], None),
            lower=NOTHING,
            upper=NOTHING,
            held=True,
            twins=tuple(signed(f"{twin[name]:.5g}") for twin in twins),
        )
        for name in found.held
    ]
    return rows


def _end(value: float, places: int | None) -> str:
    return signed(f"{value:.6g}") if places is None or not np.isfinite(value) else fixed(value, places)


def _or_nothing(value: float, form: str) -> str:
    return form.format(value) if np.isfinite(value) else NOTHING
