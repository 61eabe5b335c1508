"""The HTML page of an identification, an estimate or a fleet: verdict first, then everything that it rests on.

The page is one file without a script. Its policy forbids the network. Its pictures are SVG in the colours of the page
(light, dark or paper). Every text that comes from a file is escaped. The same input gives the same bytes.
"""

from __future__ import annotations

import re
import shlex
from functools import cache
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from suspid.arguments import explained
from suspid.files import printable
from suspid.fleet import FleetSummary
from suspid.greybox import Estimate
from suspid.model import car_to_toml
from suspid.reporting.colours import Colour
from suspid.reporting.content import Content
from suspid.reporting.content_of import content_of
from suspid.reporting.drive_page import DriveContent, drive_fields
from suspid.reporting.estimate_page import EstimateContent, page_fields
from suspid.reporting.fleet_page import FleetContent, fleet_fields
from suspid.reporting.limit_rows import limit_rows
from suspid.reporting.numerals import digits
from suspid.reporting.performance_part import drive_to_tune, performance_fields
from suspid.reporting.pictures import MOST_CHANNELS, pictures_of
from suspid.reporting.rows import channel_rows, mode_quantities, mode_rows, pole_rows, repeat_rows
from suspid.reporting.sensitivity_part import sensitivity_fields
from suspid.reporting.source import Source, versions
from suspid.reporting.spring_rows import masses_of, spring_rows
from suspid.reporting.thinning import is_whole
from suspid.samples import held
from suspid.signals import as_signal
from suspid.units import in_print
from suspid.words import MOST_LISTED

if TYPE_CHECKING:
    from jinja2 import Template
    from markupsafe import Markup

    from suspid.analysis import Analysis, DriveAnalysis
    from suspid.identification import Identification
    from suspid.model import ModalSet
    from suspid.reconstruction import Reconstruction

AnyContent: TypeAlias = Content | EstimateContent | DriveContent | FleetContent
# Letters of a name that the page shows; the JSON has all.
MOST_LETTERS = 40
# An option of the command line, which browsers would break after its hyphens.
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z0-9-]*")


@explained
def report(
    found: Identification | Analysis | Estimate | DriveAnalysis | FleetSummary | AnyContent,
    *,
    title: str | None = None,
) -> str:
    """Return the page as HTML.

    Parameters
    ----------
    found : Identification, Analysis, Estimate, DriveAnalysis, FleetSummary, or what `content_of` returns
        The result; perhaps without modes. `content_of` adds where it comes from, and more to an identification.
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
    content = found if isinstance(found, AnyContent) else content_of(found)
    about = "Springs, dampers and modes"
    if isinstance(content, FleetContent):
        about = "Records"
        file, verdict, limits = content.found.folder.name, content.found.verdict, None
        fields, template = fleet_fields(content), "fleet.html.j2"
    elif isinstance(content, DriveContent):
        file = content.sources[0].file if len(content.sources) == 1 else content.found.drives[0].title
        verdict, limits = content.verdict, None
        fields, template = drive_fields(content), "drive.html.j2"
    elif isinstance(content, EstimateContent):
        file = content.sources[0].file if len(content.sources) == 1 else ""
        verdict, limits = content.verdict, content.limits
        fields, template = page_fields(content), "estimate.html.j2"
    else:
        recorded = str(held(content.identification, "response").title or "")
        file = ", ".join(source.file for source in content.sources) or recorded
        verdict, limits = content.analysis.verdict, content.limits
        springs = content.analysis.estimate or content.analysis.reconstruction
        about = "Modes" if springs is None else "Modes, springs and dampers"
        fields, template = _fields(content), "report.html.j2"
    return _template(template).render(
        title=_shown(title or file or "Record"),
        verdict=verdict,
        about=about,
        level=f"{100 * content.level:g} %",
        colours=list(Colour),
        sources=content.sources,
        limits_said="" if limits is None else f"{limits.verdict.headline}.",
        frame=min(verdict.level, verdict.level if limits is None else limits.verdict.level).label,
        limits_level="" if limits is None else limits.verdict.level.label,
        sizes=[_in_bytes(source.size) for source in content.sources],
        car=_car_of(content),
        warnings=[_shown(text) for text in content.warnings],
        versions=versions(),
        **fields,
    )


@cache
def _template(name: str) -> Template:
    """Return a compiled template; compiling takes longer than filling in."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("suspid.reporting", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["safe_text"] = _shown
    environment.filters["said"] = sentence_html
    environment.filters["safe_lines"] = _lines
    return environment.get_template(name)


def _fields(content: Content) -> dict[str, object]:
    """Return what the template of an identification shows beside what every page does."""
    shown, analysis = content.identification, content.analysis
    repeats, car = analysis.repeats, analysis.reconstruction
    names, level = as_signal(held(shown, "response")).channels, content.level
    best, modes = content.springs, mode_rows(shown, level)
    return {
        "record": _record_facts(shown),
        "first_of": 0 if repeats is None else len(repeats.each),
        "cards": _cards(analysis.modes),
        "method": shown.method,
        "modes": [((m.frequency, m.wn, m.zeta), m.note) for m in modes]
        if repeats is None
        else [(row, "") for row in mode_quantities(repeats.modes, level)],
        "checks": modes,
        "channels": channel_rows(shown, content.units),
        "pictures": pictures_of(
            shown, cleaned=content.cleaned, decays=analysis.decays, units=content.units, used=content.used
        ),
        "view": view_of(shown),
        "fits": [(_short(n), f"{100 * s:.2f} %") for n, s in zip(names, shown.explained, strict=True)][:MOST_CHANNELS],
        "hidden_channels": max(0, len(names) - MOST_CHANNELS),
        "names": [_short(name) for name in names],
        "cleaned": content.cleaned,
        "decays": analysis.decays,
        "remarks": content.remarks,
        "used": content.used,
        "poles": pole_rows(shown),
        "repeats": None if repeats is None else repeat_rows(repeats, level),
        "limits": limit_rows(content.limits),
        "springs": [] if best is None else spring_rows(best, level),
        "others": 0 if best is None else len(best.alternatives),
        "masses": "" if best is None else masses_of(best),
        "fitted": analysis.estimate is not None,
        "reconstruction": car,
        "from_modes": [] if car is None or best is car else spring_rows(car, level),
        **performance_fields(content.grip, content.ride, level),
        **sensitivity_fields(content.sensitivities, content.ride),
        "tuning": drive_to_tune(content.ride),
        "remade_of": "" if analysis.estimate is not None else _file_of(content),
        "chi_square": "" if car is None else _chi_square(car),
        "status": "" if car is None else _sentence(car.status),
        "steps": [str(step) for step in content.steps],
        "twins": [] if car is None else _twins(car),
    }


def _file_of(content: Content) -> str:
    """Return the name of the car file, or a name for it, as a shell takes it."""
    return shlex.quote(content.car.file) if content.car is not None and content.car.file else "car.toml"


def _car_of(content: AnyContent) -> Source | None:
    """Return the car file with its text, or the description of the nominal car where there is no file."""
    if isinstance(content, DriveContent):
        return None
    if isinstance(content, FleetContent):
        nominal, file = content.found.car, None
    else:
        springs = content.springs if isinstance(content, Content) else content.found
        nominal, file = None if springs is None else springs.nominal, content.car
    if file is not None or nominal is None:
        return file
    return Source(file="", sha256="", size=0, command="", created="", text=car_to_toml(nominal))


def _shown(text: object) -> str:
    """Return a text on one line, with nothing in it that a reader does not see; the template escapes it."""
    return printable(" ".join(str(text).split()))


def sentence_html(text: object) -> Markup:
    """Return a sentence of the library's own as `_shown`, with units as they are printed and options on one line."""
    from markupsafe import Markup, escape

    return Markup(OPTION.sub(r'<span class="option">\g<0></span>', str(escape(in_print(_shown(text))))))


def _lines(text: str) -> str:
    """Return a text line by line, with nothing in it that a reader does not see; the template escapes it."""
    return "\n".join(printable(line.replace("\t", "    ")) for line in text.splitlines())


def _sentence(text: str) -> str:
    """Return the text with a capital and a full stop."""
    text = _shown(text)
    return text[:1].upper() + text[1:] + "." * (not text.endswith((".", "!", "?")))


def _short(name: str) -> str:
    """Return a name for a figure; the table of channels has the whole."""
    shown = _shown(name)
    return shown if len(shown) <= MOST_LETTERS else f"{shown[: MOST_LETTERS - 1]}…"


def _record_facts(found: Identification) -> dict[str, str]:
    signal = as_signal(held(found, "response"))
    samples = signal.values.shape[1]
    return {
        "samples": f"{samples}",
        "rate": f"{1 / signal.step:.6g} Hz",
        "length": f"{signal.duration:.4g} s",
        "start": f"{signal.start:.6g} s".replace("-", "−"),
        "end": f"{signal.start + (samples - 1) * signal.step:.6g} s".replace("-", "−"),
        "channels": f"{len(signal.channels)} channel{'s' * (len(signal.channels) > 1)}",
    }


def _cards(modes: ModalSet) -> list[tuple[str, str]]:
    """Return frequency [Hz] and damping ratio [1] of the first modes, for a glance."""
    pairs = zip(modes.wn.tolist(), modes.zeta.tolist(), strict=True)
    cards = [(digits(wn / (2 * np.pi), 4), digits(zeta, 3)) for wn, zeta in pairs]
    return cards[:MOST_LISTED]


def view_of(found: Identification) -> dict[str, str | bool]:
    """Return what there is to know of the transform that is shown."""
    search, view, signal = found.bandwidth_search, found.steps.signal, as_signal(found.response)
    if is_whole(found):
        shown = ""
    elif view.duration < signal.duration - view.step:
        shown = f"Of {signal.duration:.4g} s it shows the first {view.duration:.4g} s, at {1 / view.step:.4g} Hz."
    else:
        shown = f"It is computed at {1 / view.step:.4g} Hz, of the record at {1 / signal.step:.4g} Hz."
    return {
        "bandwidth": f"{found.scalogram.wavelet.bandwidth:.3g}",
        "searched": search is not None,
        "at_end": search is not None and search.at_end and len(search.candidates) > 1,
        "shown": shown,
    }


def _chi_square(found: Reconstruction) -> str:
    if found.chi_square is None:
        return "The modes have no uncertainty: the fit is not tested."
    value = f"{found.chi_square if found.chi_square > 1e-6 else 0:.3g}"
    said = f"Chi-square {value} at {found.freedom} degree{'s' * (found.freedom != 1)} of freedom: "
    if not found.freedom:
        return said + "as many unknowns as equations, so the fit cannot be tested."
    if found.explains:
        return said + "with the springs and dampers found, the car explains the modes within their uncertainty."
    return (
        said + "this car, with its masses, does not explain the modes with any springs and dampers; the intervals "
        "are widened, and are a guess."
    )


def _twins(found: Reconstruction) -> list[tuple[str, str]]:
    """Return how far each twin is from the data, and what tells it apart."""
    far = [
        f"largest pole error {100 * distance:.2g} %"
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
