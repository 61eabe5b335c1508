"""A page on one identification, to print or to send: verdict first, then everything that it rests on.

One file of HTML without a script: its policy forbids the network, its figures are drawn in the colours of the page
(light, dark or paper), and every text that comes from a file is escaped. The same input gives the same bytes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from suspid.analysis import as_sentence
from suspid.files import printable
from suspid.reporting.charts import HEIGHT, WIDTH, Chart
from suspid.reporting.figures import (
    DECIBELS,
    ShapeBar,
    fit_charts,
    recording_chart,
    scalogram_chart,
    shape_bars,
    skeleton_charts,
)
from suspid.reporting.report_json import Source as Source
from suspid.reporting.report_json import judgement_of, remarks_of, units_of, used_decay, versions
from suspid.reporting.report_json import report_to_dict as report_to_dict
from suspid.reporting.report_json import source_of as source_of
from suspid.reporting.rows import channel_rows, mode_rows, parameter_rows, pole_rows, repeat_rows
from suspid.reporting.thinning import drawable as drawable
from suspid.reporting.thinning import is_whole
from suspid.signals import as_signal
from suspid.units import Ratio

if TYPE_CHECKING:
    from suspid.cleaning import Cleaned
    from suspid.decays import Decay
    from suspid.identification import Identification, Repeats
    from suspid.reconstruction import Reconstruction

# What a page shows at most; the JSON has all.
MOST_CHANNELS = 24
MOST_RIDGES = 8
MOST_POLES = 20
MOST_OVERVIEWS = 3
MOST_CARDS = 6
MOST_LETTERS = 40


@dataclass(frozen=True, kw_only=True, slots=True)
class FitPart:
    """The figures of one channel."""

    name: str
    explained: str
    charts: tuple[Chart, ...]


@dataclass(frozen=True, kw_only=True, slots=True)
class ShapePart:
    """The shape of one mode: a bar for each channel."""

    number: int
    frequency: str
    bars: tuple[tuple[str, ShapeBar], ...]


def report(
    identification: Identification,
    *,
    source: Source | None = None,
    cleaned: Cleaned | None = None,
    decays: Sequence[Decay] = (),
    repeats: Repeats | None = None,
    reconstruction: Reconstruction | None = None,
    level: Ratio = 0.95,
    warnings: Sequence[str] = (),
    title: str | None = None,
) -> str:
    """Return the page as HTML.

    Parameters
    ----------
    identification : Identification
        What was found; perhaps no mode.
    source : Source, optional
        The file and the command; see `source_of`.
    cleaned : Cleaned, optional
        The whole recording and what was done to it. Its units are those of the figures.
    decays : sequence of Decay, optional
        The stretches that were found or given; the record should begin with one of them.
    repeats : Repeats, optional
        The decays identified one by one and jointly.
    reconstruction : Reconstruction, optional
        Springs and dampers from these modes.
    level : float
        Probability of all intervals [1].
    warnings : sequence of str
        Warnings that were given on the way.
    title : str, optional
        Heading. Default: name of the file, or title of the record.

    Returns
    -------
    str
        The page. A long record is drawn by the extremes of its samples and stays below 2 MB.

    Raises
    ------
    InputError
        If the level is not between 0 and 1.

    Examples
    --------
    >>> from suspid import free_decay, identify, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=200)
    >>> found = identify(free_decay(car, np.arange(0, 10, 0.005), initial_state={"v_chassis": 1.0}))
    >>> page = report(found)
    >>> page.startswith("<!doctype html>"), "2 modes found" in page
    (True, True)
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined

    found = drawable(identification)
    signal, units = as_signal(found.response), units_of(found.response, cleaned)
    used = used_decay(found.response, decays)
    heading = title or (source.file if source else str(found.response.title or "")) or "Record"
    environment = Environment(
        loader=PackageLoader("suspid.reporting", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["safe_text"] = _shown
    return environment.get_template("report.html.j2").render(
        title=_shown(heading),
        source=source,
        size="" if source is None else _in_bytes(source.size),
        record=_record_facts(found),
        verdict=judgement_of(
            found, cleaned=cleaned, decays=decays, repeats=repeats, reconstruction=reconstruction, level=level
        ),
        cards=_cards(found),
        level=f"{100 * level:g} %",
        method=found.method,
        modes=mode_rows(found, level),
        channels=channel_rows(found, units),
        scalogram=scalogram_chart(found),
        view=_view(found),
        decibels=f"{DECIBELS:g}",
        fits=[
            FitPart(
                name=_short(name),
                explained=f"{100 * found.explained[k]:.2f} %",
                charts=fit_charts(found, k, _shown(units[k])),
            )
            for k, name in enumerate(signal.channels[:MOST_CHANNELS])
        ],
        hidden_channels=max(0, len(signal.channels) - MOST_CHANNELS),
        shapes=_shapes(found),
        skeletons=[skeleton_charts(ridge) for ridge in found.ridges[:MOST_RIDGES]],
        names=[_short(name) for name in signal.channels],
        cleaned=cleaned,
        decays=decays,
        remarks=remarks_of(decays),
        used=used,
        overviews=_overviews(found, cleaned, decays, used),
        poles=pole_rows(found)[:MOST_POLES],
        hidden_poles=max(0, len(found.considered) - MOST_POLES),
        repeats=None if repeats is None else repeat_rows(repeats, level),
        reconstruction=reconstruction,
        parameters=[] if reconstruction is None else parameter_rows(reconstruction, level),
        chi_square="" if reconstruction is None else _chi_square(reconstruction),
        status="" if reconstruction is None else as_sentence(reconstruction.status),
        twins=[] if reconstruction is None else _twins(reconstruction),
        warnings=[_shown(text) for text in warnings],
        versions=versions(),
        width=WIDTH,
        height=HEIGHT,
    )


def _shown(text: object) -> str:
    """Return a text on one line, with nothing in it that a reader does not see; the template escapes it."""
    return printable(" ".join(str(text).split()))


def _short(name: str) -> str:
    """Return a name for a figure; the table of channels has the whole."""
    shown = _shown(name)
    return shown if len(shown) <= MOST_LETTERS else f"{shown[: MOST_LETTERS - 1]}…"


def _record_facts(found: Identification) -> dict[str, str]:
    signal = as_signal(found.response)
    samples = signal.values.shape[1]
    return {
        "samples": f"{samples}",
        "rate": f"{1 / signal.step:.6g} Hz",
        "length": f"{signal.duration:.4g} s",
        "start": f"{signal.start:.6g} s".replace("-", "−"),
        "end": f"{signal.start + (samples - 1) * signal.step:.6g} s".replace("-", "−"),
        "channels": f"{len(signal.channels)} channel{'s' * (len(signal.channels) > 1)}",
    }


def _cards(found: Identification) -> list[tuple[str, str]]:
    """Return frequency [Hz] and damping ratio [1] of the first modes, for a glance."""
    modes = found.modes
    pairs = zip(modes.wn.tolist(), modes.zeta.tolist(), strict=True)
    return [(f"{wn / (2 * np.pi):.4g}", f"{zeta:.3g}".replace("-", "−")) for wn, zeta in pairs][:MOST_CARDS]


def _view(found: Identification) -> dict[str, str | bool]:
    """Return what there is to know of the transform that is shown."""
    search, view = found.bandwidth_search, found.steps.signal
    return {
        "bandwidth": f"{found.scalogram.wavelet.bandwidth:.3g}",
        "searched": search is not None,
        "at_end": search is not None and search.at_end and len(search.candidates) > 1,
        "whole": is_whole(found),
        "length": f"{view.duration:.4g} s",
        "rate": f"{1 / view.step:.4g} Hz",
    }


def _shapes(found: Identification) -> list[ShapePart]:
    if len(found.modes.channels) < 2:
        return []
    names = [_short(name) for name in found.modes.channels]
    return [
        ShapePart(number=k, frequency=f"{wn / (2 * np.pi):.4g} Hz", bars=tuple(zip(names, bars, strict=True)))
        for k, (wn, bars) in enumerate(zip(found.modes.wn.tolist(), shape_bars(found.modes), strict=True), 1)
    ]


def _overviews(
    found: Identification, cleaned: Cleaned | None, decays: Sequence[Decay], used: int | None
) -> list[Chart]:
    """Return charts of the first channels of the whole recording, if it is more than the record."""
    if cleaned is None or not decays:
        return []
    whole, names = as_signal(cleaned.record), as_signal(found.response).channels
    units = dict(zip(whole.channels, cleaned.units, strict=True))
    stretches = [(decay.start, decay.stop) for decay in decays]
    shown = [name for name in names if name in units][:MOST_OVERVIEWS]
    return [
        recording_chart(whole, whole.channels.index(name), _short(name), _shown(units[name]), stretches, used)
        for name in shown
    ]


def _chi_square(found: Reconstruction) -> str:
    if found.chi_square is None:
        return "The modes state no uncertainty: how well they are met is not judged."
    value = f"{found.chi_square if found.chi_square > 1e-6 else 0:.3g}"
    said = f"Chi-square {value} at {found.freedom} degree{'s' * (found.freedom != 1)} of freedom: "
    if not found.freedom:
        return said + "as many unknowns as equations, so nothing is left to judge the car by."
    if found.explains:
        return said + "the car as described explains the modes within their uncertainty."
    return said + "the car as described does not explain the modes; the intervals are widened for it, and are a guess."


def _twins(found: Reconstruction) -> list[tuple[str, str]]:
    """Return how far each twin is from the data, and what tells it apart."""
    far = [
        f"worst pole off by {100 * distance:.2g} %"
        if found.chi_square is None
        else f"chi-square {distance if distance > 1e-6 else 0:.3g}"
        for distance in found.distances
    ]
    return list(zip(far, (_shown(text) for text in found.told_apart), strict=True))


def _in_bytes(size: int) -> str:
    for unit, step in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if size >= step:
            return f"{size / step:.3g} {unit} ({size} bytes)"
    return f"{size} bytes"
