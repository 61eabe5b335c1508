"""Identifications of parts of a record: the same part is tried from several sides, and identified once."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any

from suspid.analysis.settings import Settings
from suspid.errors import SuspidError
from suspid.identification import Identification, identify, identify_linear
from suspid.signals import as_signal

if TYPE_CHECKING:
    import control

# Settings that `identify` takes.
FOR_IDENTIFY = ("modes", "method", "band_hz", "bandwidth", "candidates")
PLAIN = Settings()
# Samples of all channels up to which a result is kept: of longer records a few would fill the memory.
MOST_KEPT = 20_000

_kept: ContextVar[dict[tuple[object, ...], Identification] | None] = ContextVar("kept", default=None)


@contextmanager
def kept_tries() -> Iterator[None]:
    """Keep what is identified within: nothing of one analysis reaches the next."""
    if _kept.get() is not None:
        yield
        return
    token = _kept.set({})
    try:
        yield
    finally:
        _kept.reset(token)


def identified(record: control.TimeResponseData, settings: Settings) -> Identification:
    """Return what `identify` finds with these settings."""
    if not _is_plain(settings):
        options: dict[str, Any] = {name: getattr(settings, name) for name in FOR_IDENTIFY}
        return identify(record, **options)
    signal, kept = as_signal(record), _kept.get()
    if kept is None or signal.values.size > MOST_KEPT:
        return identify(record)
    samples = hashlib.blake2b(signal.values.tobytes(), digest_size=16).digest()
    key = signal.start, signal.step, signal.channels, signal.values.shape, samples
    if key not in kept:
        kept[key] = identify(record)
    return kept[key]


def tried(record: control.TimeResponseData, settings: Settings) -> Identification | None:
    """Return what `identify` finds, or None if it refuses the record or finds fewer modes than asked for."""
    try:
        return identified(record, settings)
    except SuspidError:
        return None


def tried_linear(record: control.TimeResponseData, settings: Settings, *, strict: bool = True) -> Identification | None:
    """Return what the linear fit of `identify` finds; None where that is not all that is needed, if ``strict``."""
    if not _is_plain(settings):
        return tried(record, settings)
    try:
        return identify_linear(record, strict=strict)
    except SuspidError:
        return None


def _is_plain(settings: Settings) -> bool:
    return all(getattr(settings, name) == getattr(PLAIN, name) for name in FOR_IDENTIFY)
