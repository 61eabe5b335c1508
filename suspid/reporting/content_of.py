"""Collect the content of a report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, overload

from suspid.analysis import Analysis, DriveAnalysis, Limit, Settings, check_limits
from suspid.arguments import explained
from suspid.cleaning import Cleaned
from suspid.errors import InputError
from suspid.fleet import FleetSummary
from suspid.greybox import DamperCurve, Estimate
from suspid.levels import LEVEL, check_level
from suspid.performance import Ride, Wear
from suspid.reporting.content import Content, used_decay
from suspid.reporting.drive_page import DriveContent
from suspid.reporting.estimate_page import EstimateContent
from suspid.reporting.fleet_page import FleetContent
from suspid.reporting.source import Source
from suspid.reporting.thinning import drawable
from suspid.results import check_kind
from suspid.samples import held
from suspid.signals import as_signal
from suspid.units import Ratio
from suspid.words import Note

if TYPE_CHECKING:
    from suspid.decays import Decay
    from suspid.greybox import Drives
    from suspid.identification import Identification, Repeats
    from suspid.reconstruction import Reconstruction
    from suspid.words import Verdict


@explained
@overload
def content_of(
    found: Identification | Analysis,
    *,
    source: Source | Sequence[Source] | None = ...,
    cleaned: Cleaned | None = ...,
    decays: Sequence[Decay] = ...,
    repeats: Repeats | None = ...,
    reconstruction: Reconstruction | None = ...,
    level: Ratio = ...,
    warnings: Sequence[str] = ...,
    ride: Ride | None = ...,
    car: Source | None = ...,
    limits: Sequence[Limit] = ...,
) -> Content: ...


@overload
def content_of(
    found: Estimate,
    *,
    source: Source | Sequence[Source] | None = ...,
    level: Ratio = ...,
    warnings: Sequence[str] = ...,
    car: Source | None = ...,
    limits: Sequence[Limit] = ...,
    curves: Sequence[DamperCurve] = ...,
    ride: Ride | None = ...,
    wear: Wear | None = ...,
) -> EstimateContent: ...


@overload
def content_of(
    found: FleetSummary, *, source: Source | Sequence[Source] | None = ..., warnings: Sequence[str] = ...
) -> FleetContent: ...


@overload
def content_of(
    found: DriveAnalysis,
    *,
    source: Source | Sequence[Source] | None = ...,
    level: Ratio = ...,
    warnings: Sequence[str] = ...,
    car: Source | None = ...,
    limits: Sequence[Limit] = ...,
    ride: Ride | None = ...,
) -> EstimateContent | DriveContent: ...


@explained
def content_of(
    found: Identification | Analysis | Estimate | DriveAnalysis | FleetSummary,
    *,
    source: Source | Sequence[Source] | None = None,
    cleaned: Cleaned | None = None,
    decays: Sequence[Decay] = (),
    repeats: Repeats | None = None,
    reconstruction: Reconstruction | None = None,
    level: Ratio = LEVEL,
    warnings: Sequence[str] = (),
    car: Source | None = None,
    limits: Sequence[Limit] = (),
    curves: Sequence[DamperCurve] = (),
    ride: Ride | None = None,
    wear: Wear | None = None,
) -> Content | EstimateContent | DriveContent | FleetContent:
    """Return what `report` and `report_to_dict` show of an analysis, an estimate, an identification, or a fleet.

    Parameters
    ----------
    found : Identification, Analysis, Estimate, DriveAnalysis or FleetSummary
        The result; perhaps without modes. An `Analysis` brings all but source and warnings, an `Estimate` all but these
        and the level, as a `DriveAnalysis` with its curves and wear; a `FleetSummary` all but source and warnings.
    source : Source, optional
        The file and the command; see `source_of`. Of several records a sequence, one for each.
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
        Warnings during the analysis.
    car : Source, optional
        The car file with its text; see `source_of`. Default: the description of the nominal car.
    limits : sequence of Limit
        Limits of modes, springs and dampers; `read_limits` reads them from a file.
    curves : sequence of DamperCurve
        Curves of dampers that an estimate's page shows as well.
    ride : Ride, optional
        The car that was found on a road, from `ride`.
    wear : Wear, optional
        Wear of the dampers of an estimate, from `wear`.

    Raises
    ------
    InputError
        If the level is not between 0 and 1.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import free_decay, identify, quarter_car, report_to_dict
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=200)
    >>> found = identify(free_decay(car, np.arange(0, 10, 0.005), initial_state={"v_chassis": 1.0}))
    >>> report_to_dict(content_of(found, level=0.9))["level"]
    0.9
    """
    check_level(level)
    check_kind(
        found,
        {
            "Identification": "identify",
            "Analysis": "analyse",
            "Estimate": "estimate",
            "DriveAnalysis": "analyse_drive",
            "FleetSummary": "fleet_summary",
        },
    )
    sources = () if source is None else (source,) if isinstance(source, Source) else tuple(source)
    if isinstance(found, FleetSummary):
        return FleetContent(found=found, sources=sources, warnings=warnings)
    judged: Verdict | None = None
    drives: Sequence[Drives] = ()
    if isinstance(found, DriveAnalysis):
        if found.estimate is None:
            return DriveContent(found=found, sources=sources, level=level, warnings=warnings)
        curves, wear, judged = curves or found.curves, wear or found.wear, found.verdict
        drives = found.drives
        found = found.estimate
    if isinstance(found, Estimate):
        return EstimateContent(
            found=found,
            judged=judged,
            drives=drives,
            sources=sources,
            level=level,
            warnings=warnings,
            car=car,
            limits=check_limits(found, limits, level=level) if limits else None,
            curves=curves,
            ride=ride,
            wear=wear,
        )
    _check_sources(found, sources)
    if isinstance(found, Analysis):
        no_springs = [str(note) for note in found.notes if note.code is Note.NO_SPRINGS]
        analysis = replace(found, identification=drawable(found.identification))
        return Content(
            analysis=analysis,
            sources=sources,
            cleaned=found.cleaned,
            warnings=(*no_springs, *warnings),
            car=car,
            limits=check_limits(found, limits, level=found.settings.level) if limits else None,
            ride=ride,
        )
    response = held(found, "response")
    used = used_decay(response, decays)
    analysis = Analysis(
        settings=Settings(level=level),
        recording=None,
        cleaned=cleaned or Cleaned(record=response, units=("",) * len(as_signal(response).channels), findings=()),
        decays=tuple(decays),
        used=() if used is None else (decays[used],),
        identification=drawable(found),
        repeats=repeats,
        reconstruction=reconstruction,
        notes=(),
    )
    checked = check_limits(analysis, limits, level=level) if limits else None
    return Content(
        analysis=analysis, sources=sources, cleaned=cleaned, warnings=warnings, car=car, limits=checked, ride=ride
    )


def _check_sources(found: Identification | Analysis, sources: Sequence[Source]) -> None:
    files = max(1, len(found.tests)) if isinstance(found, Analysis) else 1
    if len(sources) > files:
        raise InputError(f"source has {len(sources)} files, but what was found is from {files}")
