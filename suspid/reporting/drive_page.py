"""The HTML page of drives without springs and dampers: verdict, frequencies of the body, stretches taken and left."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from suspid.files import printable
from suspid.reporting.fleet_tables import FleetTable, Heading
from suspid.reporting.numerals import NOTHING
from suspid.reporting.pictures import Picture, picture
from suspid.reporting.plot_drive import draw_finding, draw_stretches
from suspid.reporting.svg import page_style
from suspid.units import in_print
from suspid.words import Verdict, count

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from suspid.analysis import DriveAnalysis
    from suspid.greybox import BodyModes, Drives
    from suspid.reporting.source import Source
    from suspid.units import Ratio

# Files that the page draws, and stretches of each in its table; the JSON has all.
MOST_FILES, MOST_STRETCHES = 12, 60


@dataclass(frozen=True, kw_only=True, slots=True)
class DriveContent:
    """Drives and where they come from.

    Parameters
    ----------
    found : DriveAnalysis
        What was found; no springs and dampers.
    sources : sequence of Source
        The files and the command.
    level : float
        Probability of all intervals [1].
    warnings : sequence of str
        Warnings during the analysis.
    """

    found: DriveAnalysis
    sources: Sequence[Source]
    level: Ratio
    warnings: Sequence[str]

    @property
    def verdict(self) -> Verdict:
        """The verdict on the drives."""
        return self.found.verdict


def drive_fields(content: DriveContent) -> dict[str, object]:
    """Return what the template of drives shows in addition to what every page has."""
    found = content.found
    length = sum(one.length for one in found.drives)
    with page_style():
        return {
            "facts": f"{count(len(found.drives), 'file')}, {length:.4g} s, of which {found.usable:.4g} s can be used",
            "bodies": FleetTable() if found.body is None else _body_table(found.body, content.level),
            "spectra": None if found.body is None else _spectra(found),
            **stretch_fields(found.drives),
        }


def stretch_fields(drives: Sequence[Drives]) -> dict[str, object]:
    """Return what the template of stretches shows: the course of each file and its stretches."""
    shown = [(printable(one.title), _course(one, k), _stretches(one)) for k, one in enumerate(drives[:MOST_FILES])]
    return {"files": shown, "hidden": max(0, len(drives) - MOST_FILES)}


def _body_table(found: BodyModes, level: Ratio) -> FleetTable:
    headings = (
        Heading(text="channel", number=False),
        Heading(text="f [Hz]", number=True),
        Heading(text=f"{100 * level:g} % interval [Hz]", number=True),
        Heading(text="damping ratio", number=False),
    )
    ends = [mode.interval(level) for mode in found]
    return FleetTable(
        headings=headings,
        rows=tuple(
            (
                printable(mode.channel),
                f"{mode.hertz:.3g}" if mode.models else NOTHING,
                f"{low:.3g} … {high:.3g}" if np.isfinite(low) else NOTHING,
                "not reported" if mode.why is None else str(mode.why),
            )
            for mode, (low, high) in zip(found, ends, strict=True)
        ),
    )


def _stretches(drives: Drives) -> FleetTable:
    headings = (
        *(Heading(text=text, number=True) for text in ("start [s]", "stop [s]", "speed [m/s]")),
        Heading(text="use", number=False),
        Heading(text="because", number=False),
    )
    rows = tuple(
        (
            f"{one.start:.6g}",
            f"{one.stop:.6g}",
            NOTHING if np.isnan(one.speed) else f"{one.speed:.3g}",
            "taken" if one.taken else "left",
            in_print(printable("; ".join(map(str, one.reasons)))),
        )
        for one in drives
    )
    return FleetTable(headings=headings, rows=rows[:MOST_STRETCHES], more=max(0, len(rows) - MOST_STRETCHES))


def _spectra(found: DriveAnalysis) -> Picture:
    described = "Spectra of the body over all usable stretches, with the intervals of its frequency"
    return picture(partial(_draw_spectra, found), name="spectra", described=described, height=2.8, wide_height=2.8)


def _draw_spectra(found: DriveAnalysis, figure: Figure) -> None:
    draw_finding(found, figure.subplots())


def _course(drives: Drives, which: int) -> Picture:
    described = f"Stretches of file {which + 1} over time, taken and left"
    draw = partial(_draw_course, drives)
    return picture(draw, name=f"stretches-{which}", described=described, height=1.6, wide_height=1.6)


def _draw_course(drives: Drives, figure: Figure) -> None:
    ax = figure.subplots()
    draw_stretches(ax, drives)
    ax.set_title("", loc="left")
    ax.set_xlabel("time [s]")
