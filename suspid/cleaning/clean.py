"""Cleaning: from the channels of a file to a record on one uniform clock, with a list of all that was met."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from tabulate import tabulate

from suspid.cleaning.clocks import read_clock
from suspid.cleaning.findings import Finding as Finding
from suspid.cleaning.findings import found
from suspid.cleaning.gaps import MOST_FILLED, fill, runs
from suspid.cleaning.inspection import inspect, possible
from suspid.cleaning.placing import Placed, place, resample
from suspid.errors import RecordError
from suspid.files import printable
from suspid.recordings import RawChannel, Recording
from suspid.signals import as_response, as_signal
from suspid.units import Hertz, RealArray, Second
from suspid.values import frozen_real
from suspid.words import Cleaning, Defect, Number, Remark, Verdict, dead

if TYPE_CHECKING:
    import control

# Clocks are one rate if they differ by less than this; a channel slower than that is another clock's.
SAME_RATE = 0.01
# Share of a channel's samples below which there is no channel.
FEWEST = 0.5
# What must be left of the recording where its ends are cut off: where an end is missing, and where there is a long gap.
LEAST_LEFT, MOST_LEFT = 0.5, 0.9
# Characters of a line in which a finding is explained.
WIDTH = 60


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Cleaned:
    """A record that can be used, and what was done to make it so.

    Parameters
    ----------
    record : control.TimeResponseData
        Finite samples on a uniform clock.
    units : tuple of str
        Units of the channels as the file states them.
    findings : tuple of Finding
        What was met; none for a clean recording, whose samples and stamps are unchanged to the last bit.
    """

    record: control.TimeResponseData
    units: tuple[str, ...]
    findings: tuple[Finding, ...]

    @property
    def verdict(self) -> Verdict:
        """Whether the record can be used as it is: defects left alone call for care, repairs are notes."""
        repaired = sum(finding.repaired for finding in self.findings)
        headline = Remark(Cleaning.UNCHANGED)
        if self.findings:
            headline = Remark(Cleaning.REPAIRED, {"repaired": repaired, "left": len(self.findings) - repaired})
        return Verdict(headline, tuple(finding.check for finding in self.findings))

    def __str__(self) -> str:
        if not self.findings:
            return str(self.verdict)
        columns = {
            "found": [str(finding.kind) for finding in self.findings],
            "channel": [printable(finding.channel) or "(time)" for finding in self.findings],
            "from [s]": [f"{finding.start:.6g}" for finding in self.findings],
            "to [s]": [f"{finding.stop:.6g}" for finding in self.findings],
            "samples": [str(finding.samples) for finding in self.findings],
            "repaired": ["yes" if finding.repaired else "no" for finding in self.findings],
            "what": [printable(finding.text) for finding in self.findings],
        }
        widths = [None, 24, *[None] * 4, WIDTH]
        table = tabulate(columns, headers="keys", disable_numparse=True, maxcolwidths=widths)
        return f"{printable(str(self.verdict))}\n\n{table}"


def clean(
    recording: Recording,
    *,
    channels: Sequence[str] | str | None = None,
    fs: Hertz | None = None,
    start: Second | None = None,
    stop: Second | None = None,
) -> Cleaned:
    """Return the record that a recording holds, on one uniform clock, and what had to be done for it.

    Repaired where that is safe: rounded, swapped, doubled and wrong time stamps; irregular sampling;
    isolated samples that cannot be motion and short gaps (filled, with the error measured); gaps at
    the ends (cut off). Reported and left: clipping, offsets, drifts. Left out unless asked for by
    name: constant channels and those on a slower clock. The rest is an error that says where the longest
    clean stretch is.

    Parameters
    ----------
    recording : Recording
        Channels as a file holds them.
    channels : sequence of str, optional
        Channels to take, in this order. Default: all that are of use.
    fs : float, optional
        Sampling rate [Hz]. It replaces the stamps; a finding says how far they disagree.
    start, stop : float, optional
        First and last time to take [s]: what lies outside is not looked at.

    Returns
    -------
    Cleaned
        The record, the units of its channels, and the findings.

    Raises
    ------
    RecordError
        If a channel is not there, or what is wrong cannot be repaired safely.

    Examples
    --------
    >>> from suspid.recordings import RawChannel, Recording
    >>> t = np.arange(300) / 100
    >>> values = np.exp(-t) * np.sin(12 * t)
    >>> values[40] = -9999.0
    >>> seat = RawChannel(name="seat", unit="m", timepts=t, values=values, rate=None)
    >>> cleaned = clean(Recording(title="bump", channels=(seat,)))
    >>> [finding.kind.value for finding in cleaned.findings], bool(abs(cleaned.record.y[0, 40]) < 1)
    (['sentinel', 'missing'], True)
    """
    if fs is not None and not (np.isfinite(fs) and fs > 0):
        raise RecordError(f"{fs=} Hz must be positive and finite")
    names = [channels] if isinstance(channels, str) else list(recording.names if channels is None else channels)
    for name in names:
        if names.count(name) > 1:
            raise RecordError(f"channel {name!r} is asked for twice")
    chosen = [_within(recording[name], start, stop) for name in names]
    if not chosen:
        raise RecordError("the recording holds no channel")
    by_name = channels is not None
    chosen, findings = _alive(chosen, by_name=by_name)
    kept, further = _one_clock([_placed(group, fs) for group in _by_clock(chosen)], by_name=by_name)
    findings += further
    timepts, table, further = _whole(kept)
    findings += further
    findings += _stilled(timepts, table, by_name=by_name)
    order = [name for name in names if name in table]
    response = as_response(timepts, np.array([table.pop(name) for name in order]), order, title=recording.title)
    as_signal(response)
    units = {channel.name: channel.unit for channel in chosen}
    return Cleaned(record=response, units=tuple(units[name] for name in order), findings=tuple(findings))


def _within(channel: RawChannel, start: Second | None, stop: Second | None) -> RawChannel:
    """Return the part of a channel between two times."""
    if channel.values.size != channel.timepts.size:
        raise RecordError(
            f"channel {channel.name!r} has {channel.values.size} samples, but {channel.timepts.size} time stamps"
        )
    if start is None and stop is None:
        return channel
    low, high = -np.inf if start is None else start, np.inf if stop is None else stop
    inside = (channel.timepts >= low) & (channel.timepts <= high)
    if np.sum(inside) < 2:
        raise RecordError(f"channel {channel.name!r} has {np.sum(inside)} samples between {low:g} and {high:g} s")
    # One array of stamps stays one array, so that the channels of a clock are known to be of one.
    return replace(channel, timepts=channel.timepts[inside], values=channel.values[inside])


def _alive(channels: list[RawChannel], *, by_name: bool) -> tuple[list[RawChannel], list[Finding]]:
    """Return the channels that move; the others are left out or, if asked for by name, refused."""
    kept: list[RawChannel] = []
    findings: list[Finding] = []
    for channel in channels:
        some = possible(channel.values)
        some = some if some is channel.values else some[np.isfinite(some)]
        if some.size < max(2, FEWEST * channel.values.size):
            why: dict[str, Number] = {"finite": some.size}
        elif _is_constant(some):
            why = {"constant": float(some[0])}
        else:
            kept.append(channel)
            continue
        finite = channel.timepts[np.isfinite(channel.timepts)]
        findings.append(_dead(channel.name, finite, channel.values.size, why, by_name=by_name))
    if not kept:
        raise RecordError(_nothing_moves(findings))
    return kept, findings


def _stilled(times: RealArray, table: dict[str, RealArray], *, by_name: bool) -> list[Finding]:
    """Take out the channels of which nothing that moves was left by the repairs."""
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
    return f"no channel moves: {'; '.join(f'{f.channel!r}: {dead(f.remark.numbers)}' for f in findings)}"


def _by_clock(channels: list[RawChannel]) -> list[list[RawChannel]]:
    """Return the channels in groups that share their stamps."""
    groups: list[list[RawChannel]] = []
    for channel in channels:
        for group in groups:
            first = group[0]
            shared = channel.timepts is first.timepts or np.array_equal(channel.timepts, first.timepts, equal_nan=True)
            if shared and channel.rate == first.rate:
                group.append(channel)
                break
        else:
            groups.append([channel])
    return groups


def _placed(group: list[RawChannel], fs: Hertz | None) -> Placed:
    """Return the channels of one clock on their uniform grid."""
    stated = group[0].rate
    values = frozen_real([channel.values for channel in group])
    rate = stated if fs is None else fs
    clock = read_clock(group[0].timepts, possible(values), rate=rate, override=fs is not None)
    table = values if np.array_equal(clock.rows, np.arange(values.shape[1])) else values[:, clock.rows]
    rows = list(table)
    inspected = [inspect(channel.name, clock.stamps, row) for channel, row in zip(group, rows, strict=True)]
    if any(channel.values is not row for channel, row in zip(inspected, rows, strict=True)):
        table = np.array([channel.values for channel in inspected])
    findings = [finding for channel in inspected for finding in channel.findings]
    return place(clock, [channel.name for channel in group], table, findings)


def _one_clock(placed: list[Placed], *, by_name: bool) -> tuple[Placed, list[Finding]]:
    """Return all channels on the fastest clock; slower ones are left out unless asked for by name."""
    lead = max(placed, key=lambda part: (1 / part.step, len(part.names)))
    together = [lead]
    findings: list[Finding] = []
    for part in placed:
        if part is lead:
            continue
        slower = part.step > lead.step * (1 + SAME_RATE)
        numbers: dict[str, Number] = {"channels": part.names, "rate": 1 / part.step, "onto": 1 / lead.step}
        if by_name or not slower:
            moved, numbers["error"] = resample(part, lead)
            together.append(moved)
        kind = Defect.SLOWER_CLOCK if slower else Defect.SHIFTED_CLOCK
        findings.append(found(kind, part.timepts[[0, -1]], part.timepts.size, numbers))
    findings = [finding for part in together for finding in part.findings] + findings
    first = max(part.timepts[0] for part in together)
    last = min(part.timepts[-1] for part in together)
    inside = (lead.timepts >= first - 1e-6 * lead.step) & (lead.timepts <= last + 1e-6 * lead.step)
    if np.sum(inside) < 2:
        raise RecordError(
            f"the channels share no time: {', '.join(map(repr, lead.names))} run from {lead.timepts[0]:g} to "
            f"{lead.timepts[-1]:g} s; ask for channels that were recorded together"
        )
    if np.all(inside) and len(together) == 1:
        return lead, findings
    if not np.all(inside):
        findings.append(_cut(lead.timepts, inside, missing=False))
    return replace(
        lead,
        timepts=lead.timepts[inside],
        names=tuple(name for part in together for name in part.names),
        values=np.concatenate([part.values[:, inside] for part in together]),
    ), findings


def _whole(placed: Placed) -> tuple[RealArray, dict[str, RealArray], list[Finding]]:
    """Return all channels with short gaps filled, the ends cut where one is missing; refuse longer gaps."""
    findings: list[Finding] = []
    times = placed.timepts
    if not np.any(np.isnan(placed.values)):
        return times, dict(zip(placed.names, placed.values, strict=True)), findings
    better: list[RealArray] = []
    for name, values in zip(placed.names, placed.values, strict=True):
        filled = fill(name, times, values)
        findings += filled.findings
        share = sum(finding.samples for finding in filled.findings) / values.size
        if share > MOST_FILLED:
            raise RecordError(
                f"channel {name!r} has gaps in {100 * share:.2g} % of its samples; up to {100 * MOST_FILLED:.0f} % are "
                f"filled; leave it out or take a better stretch (start, stop)"
            )
        better.append(filled.values)
    table = np.array(better)
    holes = np.any(np.isnan(table), axis=0)
    if np.all(holes):
        raise RecordError("there is no time at which all channels have samples; leave one out")
    first, last = int(np.argmin(holes)), int(holes.size - np.argmin(holes[::-1]))
    starts, stops = runs(~holes)
    longest = int(np.argmax(stops - starts))
    if stops[longest] - starts[longest] >= MOST_LEFT * holes.size:
        first, last = int(starts[longest]), int(stops[longest])
    if np.any(holes[first:last]) or last - first < LEAST_LEFT * holes.size:
        begin, end = runs(holes)
        k = int(np.argmax(end - begin))
        gaps = [name for name, row in zip(placed.names, table, strict=True) if np.any(np.isnan(row[begin[k] : end[k]]))]
        low, high = times[starts[longest]], times[stops[longest] - 1]
        raise RecordError(
            f"{np.sum(holes)} of {holes.size} samples are missing in {begin.size} gaps too long to fill, the longest "
            f"in {', '.join(map(repr, gaps))} from {times[begin[k]]:.6g} to {times[end[k] - 1]:.6g} s; the longest "
            f"stretch without such a gap is {low:.6g} to {high:.6g} s: take it with start={low:.6g}, stop={high:.6g}"
        )
    inside = np.zeros(holes.size, bool)
    inside[first:last] = True
    if not np.all(inside):
        findings.append(_cut(times, inside, missing=True))
    return times[inside], dict(zip(placed.names, table[:, inside], strict=True)), findings


def _cut(times: RealArray, inside: NDArray[np.bool_], *, missing: bool) -> Finding:
    """Return the finding of ends that were cut off."""
    lost, kept = times[~inside], times[inside]
    numbers: dict[str, Number] = {"missing": missing, "first": float(kept[0]), "last": float(kept[-1])}
    return found(Defect.CUT, lost, lost.size, numbers)
