"""The HTML page of an identification, an estimate or a fleet: verdict first, then everything that it rests on.

The page is one file without a script. Its policy forbids the network. Its pictures are SVG in the colours of the page
(light, dark or paper). Every text that comes from a file is escaped. The same input gives the same bytes.
"""

from __future__ import annotations

import shlex
from functools import cache
from typing import TYPE_CHECKING, TypeAlias

from suspid.arguments import explained
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
from suspid.reporting.page_text import full_sentence, plain_line, plain_lines, sentence_html, short_name
from suspid.reporting.performance_part import drive_to_tune, performance_fields
from suspid.reporting.pictures import MOST_CHANNELS, pictures_of
from suspid.reporting.record_facts import chi_square_text, in_bytes, mode_cards, record_facts, twin_texts, view_of
from suspid.reporting.rows import channel_rows, mode_quantities, mode_rows, pole_rows, repeat_rows
from suspid.reporting.sensitivity_part import sensitivity_fields
from suspid.reporting.source import Source, versions
from suspid.reporting.spring_rows import masses_of, spring_rows
from suspid.samples import held
from suspid.signals import as_signal

if TYPE_CHECKING:
    from jinja2 import Template

    from suspid.analysis import Analysis, DriveAnalysis
    from suspid.identification import Identification

AnyContent: TypeAlias = Content | EstimateContent | DriveContent | FleetContent


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
        The page; ``Path("report.html").write_text(report(found), encoding="utf-8")`` writes it. A long record is drawn
        by the extremes of its samples and stays below 2 MB.

    Examples
    --------
    >>> import numpy as np
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
        title=plain_line(title or file or "Record"),
        verdict=verdict,
        about=about,
        level=f"{100 * content.level:g} %",
        colours=list(Colour),
        sources=content.sources,
        limits_said="" if limits is None else f"{limits.verdict.headline}.",
        frame=min(verdict.level, verdict.level if limits is None else limits.verdict.level).label,
        limits_level="" if limits is None else limits.verdict.level.label,
        sizes=[in_bytes(source.size) for source in content.sources],
        car=_car_of(content),
        warnings=[plain_line(text) for text in content.warnings],
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
    environment.filters["safe_text"] = plain_line
    environment.filters["said"] = sentence_html
    environment.filters["safe_lines"] = plain_lines
    return environment.get_template(name)


def _fields(content: Content) -> dict[str, object]:
    """Return what the template of an identification shows in addition to what every page has."""
    shown, analysis = content.identification, content.analysis
    repeats, car = analysis.repeats, analysis.reconstruction
    names, level = as_signal(held(shown, "response")).channels, content.level
    best, modes = content.springs, mode_rows(shown, level)
    return {
        "record": record_facts(shown),
        "first_of": 0 if repeats is None else len(repeats.each),
        "cards": mode_cards(analysis.modes),
        "method": shown.method,
        "modes": [((m.frequency, m.wn, m.zeta), m.note) for m in modes]
        if repeats is None
        else [(row, "") for row in mode_quantities(repeats.modes, level)],
        "checks": modes,
        "channels": channel_rows(shown, content.units),
        "pictures": pictures_of(
            shown,
            cleaned=content.cleaned,
            decays=analysis.decays,
            units=content.units,
            used=content.used,
            repeats=repeats,
        ),
        "view": view_of(shown),
        "fits": [(short_name(n), f"{100 * s:.2f} %") for n, s in zip(names, shown.explained, strict=True)][
            :MOST_CHANNELS
        ],
        "hidden_channels": max(0, len(names) - MOST_CHANNELS),
        "names": [short_name(name) for name in names],
        "cleaned": content.cleaned,
        "decays": analysis.decays,
        "remarks": content.remarks,
        "used": content.used,
        "poles": pole_rows(shown),
        "repeats": None if repeats is None else repeat_rows(repeats, level),
        "bent_repeats": repeats is not None and bool(repeats.amplitude_dependence),
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
        "chi_square": "" if car is None else chi_square_text(car),
        "status": "" if car is None else full_sentence(car.status),
        "steps": [str(step) for step in content.steps],
        "twins": [] if car is None else twin_texts(car),
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
