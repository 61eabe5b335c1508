"""Constant channels: left out, or refused if they were asked for by name."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from suspid.cleaning.findings import Finding, found
from suspid.cleaning.sentinels import possible
from suspid.errors import RecordError
from suspid.recordings import RawChannel
from suspid.units import RealArray
from suspid.values import LARGEST_SIZE, MOST_NAMES
from suspid.words import Defect, Number, dead


def alive(channels: list[RawChannel], *, by_name: bool) -> tuple[list[RawChannel], list[Finding]]:
    """Return the channels with motion; the others are left out or, if asked for by name, refused."""
    kept: list[RawChannel] = []
    findings: list[Finding] = []
    for channel in channels:
        why = _why_dead(channel)
        if why is None:
            kept.append(channel)
            continue
        finite = channel.timepts[np.isfinite(channel.timepts)]
        findings.append(_dead(channel.name, finite, channel.values.size, why, by_name=by_name))
    if not kept:
        raise RecordError(_nothing_moves(findings))
    return kept, findings


def moves(channel: RawChannel) -> bool:
    """Return whether a channel holds a motion: numbers in half of its samples or more, and not always the same.

    Examples
    --------
    >>> t = np.arange(3) / 100
    >>> [moves(RawChannel(name="force", unit="N", timepts=t, values=y, rate=None)) for y in (t, np.ones(3))]
    [True, False]
    """
    return _why_dead(channel) is None


def _why_dead(channel: RawChannel) -> dict[str, Number] | None:
    """Return the numbers of why a channel holds no motion, or None if it holds one."""
    some = possible(channel.values)
    some = some if some is channel.values else some[np.isfinite(some)]
    # Half the samples must be numbers. Less could not be repaired: at most a tenth is filled.
    if some.size < max(2, 0.5 * channel.values.size):
        huge = int(np.sum(np.isfinite(channel.values) & (np.abs(channel.values) >= LARGEST_SIZE)))
        return {"finite": some.size, **({"huge": huge, "limit": LARGEST_SIZE} if huge else {})}
    return {"constant": float(some[0])} if _is_constant(some) else None


def stilled(times: RealArray, table: dict[str, RealArray], *, by_name: bool) -> list[Finding]:
    """Remove from the table the channels that are constant after the repairs."""
    still = [name for name, values in table.items() if _is_constant(values)]
    findings = []
    for name in still:
        why: dict[str, Number] = {"constant": float(table.pop(name)[0]), "repaired": True}
        findings.append(_dead(name, times, times.size, why, by_name=by_name))
    if not table:
        raise RecordError(_nothing_moves(findings))
    return findings


def _is_constant(some: RealArray) -> bool:
    low, high, middle = float(np.min(some)), float(np.max(some)), float(np.mean(some))
    return not max(high - middle, middle - low) > 1e-12 * max(abs(low), abs(high))


def _dead(name: str, times: RealArray, samples: int, why: dict[str, Number], *, by_name: bool) -> Finding:
    """Return the finding of a channel that is left out, or refuse it if it was asked for."""
    if by_name:
        raise RecordError(f"channel {name!r} shows no motion: {dead({'samples': samples, **why})}; leave it out")
    return found(Defect.DEAD_CHANNEL, times if times.size else np.zeros(1), samples, why, channel=name)


def _nothing_moves(findings: Sequence[Finding]) -> str:
    said = [f"{f.channel!r}: {dead(f.remark.numbers)}" for f in findings[:MOST_NAMES]]
    more = len(findings) - len(said)
    return f"no channel moves: {'; '.join(said)}{f'; and {more} more' if more else ''}"
