"""Cleaning: from the channels of a file to a record on one uniform clock, with a list of all that was found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from suspid.arguments import explained
from suspid.cleaning.cleaned import Cleaned
from suspid.cleaning.constant import alive, stilled
from suspid.cleaning.held_samples import once_each, without_those
from suspid.cleaning.joining import by_clock, one_clock, placed, whole
from suspid.cleaning.on_change import evenly
from suspid.errors import RecordError
from suspid.recordings import RawChannel, Recording
from suspid.records import span
from suspid.samples import as_samples
from suspid.signals import as_signal
from suspid.units import Hertz, Second
from suspid.values import check_rate
from suspid.wording import moment


@explained
def clean(
    recording: Recording,
    *,
    channels: Sequence[str] | str | None = None,
    fs: Hertz | None = None,
    start: Second | None = None,
    stop: Second | None = None,
) -> Cleaned:
    """Return the record of a recording on one uniform clock, and the defects found.

    Repaired where that is safe: rounded, swapped, doubled and wrong time stamps; irregular sampling; rows that an
    encoder writes when it counts on; rows that repeat a slower sensor; isolated impossible samples and short gaps
    (filled, with the error measured); gaps at the ends (cut off). Reported and left: clipping, offsets, drifts. Left
    out unless asked for by name: constant channels, those on a slower clock, and those with longer gaps where at least
    as many others have none. Anything else is an error that names the longest clean stretch.

    Parameters
    ----------
    recording : Recording
        Channels as a file holds them.
    channels : sequence of str, optional
        Channels to take, in this order. Default: all that move, on the fastest clock.
    fs : float, optional
        Sampling rate [Hz]. It replaces the stamps; a finding says how far they disagree.
    start, stop : float, optional
        First and last time to take [s].

    Returns
    -------
    Cleaned
        The record, the units of its channels, and the findings.

    Raises
    ------
    RecordError
        If a channel is missing, or a defect cannot be repaired safely.

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
    check_rate(fs)
    if not isinstance(recording, Recording):
        raise RecordError("clean takes a recording, such as from read_recording; a record needs no cleaning")
    names = [channels] if isinstance(channels, str) else list(recording.names if channels is None else channels)
    for name in names:
        if names.count(name) > 1:
            raise RecordError(f"channel {name!r} is requested twice")
    chosen = [_within(recording[name], start, stop) for name in names]
    if not chosen:
        raise RecordError("the recording contains no channel")
    by_name = channels is not None
    chosen, of_changes = evenly(chosen) if fs is None else (chosen, [])
    chosen, findings = alive(chosen, by_name=by_name)
    findings = [*of_changes, *findings]
    kept, further = one_clock([placed(group, fs) for group in by_clock(chosen)], by_name=by_name)
    findings += further
    timepts, table, further = whole(kept, findings, by_name=by_name)
    findings += further
    timepts, table, said = once_each(timepts, table)
    findings = [*without_those(findings, said), *said]
    findings += stilled(timepts, table, by_name=by_name)
    order = [name for name in names if name in table]
    record = as_samples(timepts, np.array([table.pop(name) for name in order]), order, title=recording.title)
    as_signal(record)
    units = {channel.name: channel.unit for channel in chosen}
    return Cleaned(record=record, units=tuple(units[name] for name in order), findings=tuple(findings))


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
        known = channel.timepts[np.isfinite(channel.timepts)]
        ends = f"; it lasts from {moment(known.min())} to {moment(known.max())} s" if known.size else ""
        raise RecordError(f"channel {channel.name!r} has {np.sum(inside)} samples {span(start, stop)}{ends}")
    # One array of stamps stays one array, so that the channels of a clock are known to be of one.
    return replace(channel, timepts=channel.timepts[inside], values=channel.values[inside])
