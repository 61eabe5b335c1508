"""Records in the terms of a car: channels named as it names them, in SI units."""

from __future__ import annotations

from dataclasses import replace

from suspid.analysis.reading import Read, in_si
from suspid.io import bare_name
from suspid.model import Suspension, names_channel
from suspid.records import like
from suspid.samples import held
from suspid.signals import as_signal
from suspid.words import Note


def in_terms_of(opened: Read, car: Suspension) -> Read:
    """Return a record with what the car has of its channels in SI, where the file states the unit, and without it.

    ``"chassis [mm]"`` is the coordinate ``"chassis"`` in metres. Springs and dampers from channels of other units
    would be off by the factor between them.
    """
    record = held(opened.cleaned, "record")
    channels = as_signal(record).channels
    short = [bare_name(name) for name in channels]
    named = tuple(
        own if own not in channels and short.count(own) == 1 and names_channel(car, own) else name
        for name, own in zip(channels, short, strict=True)
    )
    of_car = [name for name in named if names_channel(car, name)]
    if not of_car:
        return opened
    title = str(getattr(record, "title", None) or "")
    called = like(record, record.time, as_signal(record).values, list(named), title=title)
    cleaned, notes = in_si(replace(opened.cleaned, record=called))
    stated = {name for name, unit in zip(named, opened.cleaned.units, strict=True) if unit and name in of_car}
    said = [n for n in notes if n.code is not Note.NOT_CONVERTED or n.numbers["channel"] in stated]
    return replace(opened, cleaned=cleaned, notes=(*opened.notes, *said))
