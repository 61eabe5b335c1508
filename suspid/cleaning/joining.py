"""Joining: channels of one or several clocks on one uniform grid, without holes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from suspid.cleaning.clocks import read_clock
from suspid.cleaning.findings import Finding, found
from suspid.cleaning.gaps import MOST_FILLED, Filled, fill, runs
from suspid.cleaning.inspection import inspect
from suspid.cleaning.placing import Placed, place, resample
from suspid.cleaning.sentinels import possible
from suspid.errors import RecordError
from suspid.recordings import RawChannel
from suspid.units import Hertz, Ratio, RealArray
from suspid.values import frozen_real
from suspid.wording import Argument, moment, when
from suspid.words import AS_MISSING, Defect, Number, count, percent

# Relative difference of two rates up to which they are one, of a logger whose clock strays. A slower channel is left
# out unless asked for by name; a record at such a rate is resampled to that of others.
ONE_RATE = 0.01
# Shares of the recording that must be left where its ends are cut off: where a channel is missing at an end, and where
# a long gap lies near one. A channel that leaves less than the first is left out beside others; all that leave less
# than the second are refused. Smaller values cut without being asked what the user may have wanted.
MOST_LEFT, ENOUGH_LEFT = 0.9, 0.8
# Findings of samples that a file has, and cleaning takes away.
TAKEN_AWAY = (Defect.SENTINEL, Defect.SPIKES, Defect.DROPOUT)


def by_clock(channels: list[RawChannel]) -> list[list[RawChannel]]:
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


def placed(group: list[RawChannel], fs: Hertz | None) -> Placed:
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


def one_clock(placed: list[Placed], *, by_name: bool) -> tuple[Placed, list[Finding]]:
    """Return all channels on the fastest clock; slower ones are left out unless asked for by name."""
    lead = max(placed, key=lambda part: (1 / part.step, len(part.names)))
    together = [lead]
    findings: list[Finding] = []
    for part in placed:
        if part is lead:
            continue
        slower = part.step > lead.step * (1 + ONE_RATE)
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
            f"the channels do not overlap in time: {', '.join(map(repr, lead.names))} run "
            f"{when(lead.timepts[0], lead.timepts[-1])}; name channels that were recorded together"
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


def whole(
    placed: Placed, taken: Sequence[Finding], *, by_name: bool
) -> tuple[RealArray, dict[str, RealArray], list[Finding]]:
    """Return all channels with short gaps filled and incomplete ends cut off.

    Channels with more gaps are left out where at least as many others have none and none was asked for by name; else
    they are refused. ``taken`` are the findings so far, which tell what of a channel is in the file and not believed.
    """
    times = placed.timepts
    if not np.any(np.isnan(placed.values)):
        return times, dict(zip(placed.names, placed.values, strict=True)), []
    better = {name: fill(name, times, values) for name, values in zip(placed.names, placed.values, strict=True)}
    refused = [name for name in better if _refusal({name: better[name]}, times, MOST_LEFT, ()) is not None]
    # Where most have gaps, the stretch to take is that between the gaps of most: there, the others are left out.
    gappy = refused if 2 * len(refused) <= len(better) else _with_own_gaps(better)
    findings: list[Finding] = []
    if not by_name and 2 * len(gappy) <= len(better):
        findings = [_gappy(name, times, better.pop(name)) for name in gappy]
    refusal = _refusal(better, times, ENOUGH_LEFT, taken)
    if refusal is not None:
        raise refusal
    findings += [finding for filled in better.values() for finding in filled.findings]
    table = np.array([filled.values for filled in better.values()])
    inside = np.zeros(times.size, bool)
    inside[_kept(np.any(np.isnan(table), axis=0), ENOUGH_LEFT)] = True
    if not np.all(inside):
        findings.append(_cut(times, inside, missing=True))
    return times[inside], dict(zip(better, table[:, inside], strict=True)), findings


def _kept(holes: NDArray[np.bool_], least: Ratio) -> slice:
    """Return the samples between incomplete ends, or the longest stretch without holes where that is most of all."""
    first, last = int(np.argmin(holes)), int(holes.size - np.argmin(holes[::-1]))
    starts, stops = runs(~holes)
    longest = int(np.argmax(stops - starts))
    if stops[longest] - starts[longest] >= least * holes.size:
        first, last = int(starts[longest]), int(stops[longest])
    return slice(first, last)


def _with_own_gaps(channels: Mapping[str, Filled]) -> list[str]:
    """Return the channels with gaps that are left where most of the others have none."""
    holes = np.isnan([filled.values for filled in channels.values()])
    own = holes & (np.mean(holes, axis=0) <= 0.5)
    return [name for name, has in zip(channels, np.any(own, axis=1), strict=True) if has]


def _refusal(
    channels: Mapping[str, Filled], times: RealArray, least: Ratio, taken: Sequence[Finding]
) -> RecordError | None:
    """Return why channels have too many gaps to be one record, or None if they have not."""
    shares = {name: _share_filled(filled) for name, filled in channels.items()}
    full_of_gaps = [name for name, share in shares.items() if share > MOST_FILLED]
    if full_of_gaps:
        rows = len(full_of_gaps) == len(shares)
        first = full_of_gaps[0]
        what = "every channel has" if rows and len(shares) > 1 else f"channel {first!r} has"
        mend = "" if rows else "leave it out or "
        return RecordError(
            f"{what} gaps in {percent(shares[first])} of its samples; up to {percent(MOST_FILLED)} are filled; "
            f"{_not_believed([first], taken)}{mend}take a better stretch ({Argument('start')}, {Argument('stop')})"
        )
    missing = {name: np.isnan(filled.values) for name, filled in channels.items()}
    holes = np.any(list(missing.values()), axis=0)
    if np.all(holes):
        return RecordError("there is no time at which all channels have samples; leave one out")
    kept = _kept(holes, least)
    if not np.any(holes[kept]) and kept.stop - kept.start >= 0.5 * holes.size:
        return None
    (begin, end), (starts, stops) = runs(holes), runs(~holes)
    k, longest = int(np.argmax(end - begin)), int(np.argmax(stops - starts))
    gaps = [name for name, flags in missing.items() if np.any(flags[begin[k] : end[k]])]
    low, high = times[starts[longest]], times[stops[longest] - 1]
    return RecordError(
        f"{np.sum(holes)} of {holes.size} samples are missing in {count(begin.size, 'gap')} too long to fill, "
        f"the longest in {', '.join(map(repr, gaps))} from {moment(times[begin[k]])} to {moment(times[end[k] - 1])} s; "
        f"{_not_believed(gaps, taken)}the longest stretch without such a gap is {moment(low)} to {moment(high)} s: "
        f"take it with ",
        Argument("start", moment(low)),
        " and ",
        Argument("stop", moment(high)),
    )


def _not_believed(names: Sequence[str], taken: Sequence[Finding]) -> str:
    """Return which samples of some channels are no gaps of the file, and why cleaning takes them away."""
    of = [finding for finding in taken if finding.channel in names and finding.kind in TAKEN_AWAY]
    if not of:
        return ""
    whys = "; ".join(finding.text.removesuffix(AS_MISSING) for finding in of)
    there = count(sum(finding.samples for finding in of), "sample")
    return f"{there} of the file are treated as missing, as faults of the sensor: {whys}; "


def _gappy(name: str, times: RealArray, filled: Filled) -> Finding:
    """Return the finding of a channel that is left out for its gaps: too long ones, or more than may be filled."""
    holes = np.isnan(filled.values)
    lost, numbers = int(np.sum(holes)), dict[str, Number](rows=holes.size)
    where = times[holes]
    if _share_filled(filled) > MOST_FILLED:
        lost += filled.findings[0].samples
        numbers |= {"share": 100 * lost / holes.size, "most": 100 * MOST_FILLED}
        where = np.append(where, [filled.findings[0].start, filled.findings[0].stop])
    return found(Defect.GAPPY_CHANNEL, where, lost, numbers, channel=name)


def _share_filled(filled: Filled) -> Ratio:
    """Return the share of the samples of a channel that were filled."""
    return sum(finding.samples for finding in filled.findings) / filled.values.size


def _cut(times: RealArray, inside: NDArray[np.bool_], *, missing: bool) -> Finding:
    """Return the finding of ends that were cut off."""
    lost, kept = times[~inside], times[inside]
    numbers: dict[str, Number] = {"missing": missing, "first": float(kept[0]), "last": float(kept[-1])}
    return found(Defect.CUT, lost, lost.size, numbers)
