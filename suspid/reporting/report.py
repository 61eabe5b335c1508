"""The HTML page of an identification or an estimate: verdict first, then everything that it rests on.

The page is one file without a script. Its policy forbids the network. Its pictures are SVG in the colours of the page
(light, dark or paper). Every text that comes from a file is escaped. The same input gives the same bytes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.files import printable
from suspid.greybox import Estimate
from suspid.reporting.colours import Colour
from suspid.reporting.content import Content, content_of
from suspid.reporting.estimate_page import EstimateContent, page_fields
from suspid.reporting.estimate_rows import estimate_rows, masses_of
from suspid.reporting.performance_part import performance_fields
from suspid.reporting.pictures import MOST_CHANNELS, pictures_of
from suspid.reporting.rows import channel_rows, mode_rows, parameter_rows, pole_rows, repeat_rows
from suspid.reporting.source import versions
from suspid.reporting.thinning import is_whole
from suspid.signals import as_signal

if TYPE_CHECKING:
    from suspid.analysis import Analysis
    from suspid.identification import Identification
    from suspid.reconstruction import Reconstruction

# What the page shows at most: rejected poles, modes at a glance, letters of a name. The JSON has all.
MOST_POLES = 20
MOST_CARDS = 6
MOST_LETTERS = 40


def report(found: Identification | Analysis | Estimate | Content | EstimateContent, *, title: str | None = None) -> str:
    """Return the page as HTML.

    Parameters
    ----------
    found : Identification, Analysis, Estimate, or what `content_of` returns
        What was found; perhaps no mode. `content_of` adds where it comes from, and more to an identification.
    title : str, optional
        Heading. Default: name of the file, or title of the record.

    Returns
    -------
    str
        The page. A long record is drawn by the extremes of its samples and stays below 2 MB.

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

    environment = Environment(
        loader=PackageLoader("suspid.reporting", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["safe_text"] = _shown
    if isinstance(found, Estimate):
        found = content_of(found)
    if isinstance(found, EstimateContent):
        file = found.sources[0].file if len(found.sources) == 1 else ""
        fields, template = page_fields(found), "estimate.html.j2"
        verdict, sources = found.found.verdict, found.sources
    else:
        content = found if isinstance(found, Content) else content_of(found)
        sources = (content.source,) if content.source else ()
        file = sources[0].file if sources else str(content.identification.response.title or "")
        fields, template, verdict = _fields(content), "report.html.j2", content.analysis.verdict
        found = content
    return environment.get_template(template).render(
        title=_shown(title or file or "Record"),
        verdict=verdict,
        level=f"{100 * found.level:g} %",
        colours=list(Colour),
        sources=sources,
        sizes=[_in_bytes(source.size) for source in sources],
        warnings=[_shown(text) for text in found.warnings],
        versions=versions(),
        **fields,
    )


def _fields(content: Content) -> dict[str, object]:
    """Return what the template of an identification shows beside what every page does."""
    shown, analysis = content.identification, content.analysis
    repeats, car = analysis.repeats, analysis.reconstruction
    names, level = as_signal(shown.response).channels, content.level
    return {
        "record": _record_facts(shown),
        "cards": _cards(shown),
        "method": shown.method,
        "modes": mode_rows(shown, level),
        "channels": channel_rows(shown, content.units),
        "pictures": pictures_of(
            shown, cleaned=content.cleaned, decays=analysis.decays, units=content.units, used=content.used
        ),
        "view": _view(shown),
        "fits": [(_short(n), f"{100 * s:.2f} %") for n, s in zip(names, shown.explained, strict=True)][:MOST_CHANNELS],
        "hidden_channels": max(0, len(names) - MOST_CHANNELS),
        "names": [_short(name) for name in names],
        "cleaned": content.cleaned,
        "decays": analysis.decays,
        "remarks": content.remarks,
        "used": content.used,
        "poles": pole_rows(shown)[:MOST_POLES],
        "hidden_poles": max(0, len(shown.considered) - MOST_POLES),
        "repeats": None if repeats is None else repeat_rows(repeats, level),
        "estimate": [] if analysis.estimate is None else estimate_rows(analysis.estimate, level),
        "masses": "" if analysis.estimate is None else masses_of(analysis.estimate),
        "reconstruction": car,
        "parameters": [] if car is None else parameter_rows(car, level),
        **performance_fields(content.grip, content.ride, level),
        "chi_square": "" if car is None else _chi_square(car),
        "status": "" if car is None else _sentence(car.status),
        "twins": [] if car is None else _twins(car),
    }


def _shown(text: object) -> str:
    """Return a text on one line, with nothing in it that a reader does not see; the template escapes it."""
    return printable(" ".join(str(text).split()))


def _sentence(text: str) -> str:
    """Return the text with a capital and a full stop."""
    text = _shown(text)
    return text[:1].upper() + text[1:] + "." * (not text.endswith((".", "!", "?")))


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
