"""Parts: tables one below the other in a file, as tests of their own or as the pages of one record."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from suspid.errors import RecordError
from suspid.io.column_plan import NO_TIME
from suspid.io.runs import of_test
from suspid.io.tables import Table
from suspid.io.time_columns import time_names
from suspid.recordings import RawChannel, Recording
from suspid.units import RealArray
from suspid.words import Remark

# Steps from the last stamp of a page to the first of the next one, at most.
NEXT_PAGE = 1.5


def recording_of_parts(
    table: Table,
    channels: Sequence[str] | None,
    time: str | None,
    read: Callable[[Table, Sequence[str] | None], Recording],
) -> Recording:
    """Return the recording of a table that has parts, each of which is ``read``.

    Where each goes on one step after the one before, they are pages. Else they are tests of their own, if each part has
    a time or states its rate: without, nothing tells which. A rate above the first part holds for all. Channels may be
    named with their test, or without.
    """
    untold = [part for part in table.parts if not (part.rates or part.clocks or time not in (None, NO_TIME))]
    titles = [part.title for part in table.parts]
    named = all(titles) and len(set(titles)) == len(titles)
    prefixes = [f"{title}: " for title in titles] if named else [f"Run {k + 1}: " for k in range(len(titles))]
    found = list[tuple[str, Recording]]()
    for prefix, part in zip(prefixes, table.parts, strict=True):
        wanted = None if channels is None else _wanted(channels, prefix, prefixes)
        part = replace(part, title=table.title, rates=part.rates or table.parts[0].rates)
        found += [] if wanted == [] else [(prefix, read(part, wanted))]
    recordings = [recording for _, recording in found]
    left_out = _together([tuple(table.unusable.items()), *(each.left_out for each in recordings)])
    if len(found) > 1 and _go_on(recordings):
        return replace(_joined(recordings), left_out=left_out)
    if any(not time_names(part) for part in untold):
        raise RecordError(
            "the names of the columns stand again, and no time tells whether the file holds several recordings, one "
            "below the other: save each in a file of its own"
        )
    tests = tuple(of_test(channel, prefix.removesuffix(": ")) for prefix, each in found for channel in each.channels)
    return replace(recordings[0], channels=tests, left_out=left_out)


def _wanted(channels: Sequence[str], prefix: str, prefixes: Sequence[str]) -> list[str]:
    """Return the channels to take from a part: its own, and those of all."""
    others = tuple(other for other in prefixes if other != prefix)
    return [name.removeprefix(prefix) for name in channels if not name.startswith(others)]


def _go_on(recordings: Sequence[Recording]) -> bool:
    """Return whether each recording has the channels of the one before and begins a step after its end."""
    return all(
        before.names == after.names
        and all(_follows(one, other) for one, other in zip(before.channels, after.channels, strict=True))
        for before, after in itertools.pairwise(recordings)
    )


def _follows(before: RawChannel, after: RawChannel) -> bool:
    """Return whether a channel begins about a step after another ends."""
    stamps = np.concatenate([before.timepts, after.timepts])
    step = float(np.nanmedian(np.abs(np.diff(stamps))))
    apart = float(after.timepts[0] - before.timepts[-1])
    return bool(step > 0 and 0 < apart < NEXT_PAGE * step)


def _joined(pages: Sequence[Recording]) -> Recording:
    """Return pages as one recording; channels that shared their stamps do so again."""
    stamps: dict[int, RealArray] = {}
    channels = list[RawChannel]()
    for own in zip(*(page.channels for page in pages), strict=True):
        first = own[0]
        key = id(first.timepts)
        if key not in stamps:
            stamps[key] = np.concatenate([channel.timepts for channel in own])
            stamps[key].flags.writeable = False
        values = np.concatenate([channel.values for channel in own])
        values.flags.writeable = False
        channels.append(replace(first, timepts=stamps[key], values=values))
    return replace(pages[0], channels=tuple(channels))


def _together(parts: Sequence[Sequence[tuple[str, Remark]]]) -> tuple[tuple[str, Remark], ...]:
    """Return what was left out of all parts, what is said of each alike only once."""
    # By its sentence: numbers of a remark have no hash.
    said = {(name, str(remark)): remark for name, remark in itertools.chain.from_iterable(parts)}
    return tuple((name, remark) for (name, _), remark in said.items())
