"""The HTML page of an estimate: verdict, springs and dampers, modes, and the records with their fit."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from suspid.files import printable
from suspid.greybox import quantities_in
from suspid.performance import Ride, grip_if_any
from suspid.reporting.axes import plot_residual, shown, unit_ticks
from suspid.reporting.channel_units import channel_unit
from suspid.reporting.drive_page import stretch_fields
from suspid.reporting.frf import Frf, responses
from suspid.reporting.limit_rows import limit_rows, limit_steps
from suspid.reporting.numerals import signed
from suspid.reporting.performance_part import drive_to_tune, performance_fields
from suspid.reporting.pictures import Picture, picture, shape_pictures
from suspid.reporting.plot_damper_curve import plot_damper_curve
from suspid.reporting.plot_estimate import draw_changes, lively, time_label
from suspid.reporting.plot_frf import draw_gain, draw_phase
from suspid.reporting.plot_spectra import density_label, draw_spectra
from suspid.reporting.rows import mode_quantities
from suspid.reporting.sensitivity_part import sensitivities_of, sensitivity_fields
from suspid.reporting.spring_rows import masses_of, spring_rows
from suspid.reporting.svg import page_style
from suspid.reporting.wear_part import wear_fields
from suspid.signals import as_signal
from suspid.words import MOST_LISTED, Verdict, count, next_steps

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from suspid.analysis import CheckedLimits
    from suspid.greybox import DamperCurve, Drives, Estimate
    from suspid.performance import Wear
    from suspid.reporting.source import Source
    from suspid.units import Ratio


@dataclass(frozen=True, kw_only=True)
class EstimateContent:
    """An estimate and where it comes from.

    Parameters
    ----------
    found : Estimate
        What was found.
    sources : sequence of Source
        The file of each record and the command.
    level : float
        Probability of all intervals [1].
    warnings : sequence of str
        Warnings during the analysis.
    curves : sequence of DamperCurve
        Curves of the dampers, if they were found as well.
    ride : Ride or None
        The car on a road.
    car : Source or None
        The car file with its text.
    wear : Wear or None
        Wear of the dampers.
    limits : CheckedLimits or None
        The limits that were given, judged.
    judged : Verdict or None
        The verdict of the whole analysis, such as that of drives.
    drives : sequence of Drives
        The stretches of the drives that were used and left out, if the records come from drives.
    """

    found: Estimate
    sources: Sequence[Source]
    level: Ratio
    warnings: Sequence[str]
    curves: Sequence[DamperCurve] = ()
    ride: Ride | None = None
    car: Source | None = None
    wear: Wear | None = None
    limits: CheckedLimits | None = None
    judged: Verdict | None = None
    drives: Sequence[Drives] = ()

    @property
    def verdict(self) -> Verdict:
        """The verdict of the page: of the whole analysis if it is given, else of the estimate."""
        return self.judged or self.found.verdict


@dataclass(frozen=True, kw_only=True, slots=True)
class RecordPart:
    """What the page shows of one record: pictures by channel, unit, noise and whiteness of every channel."""

    heading: str
    pictures: tuple[tuple[str, tuple[Picture, ...]], ...]
    channels: tuple[tuple[str, str, str, str], ...]


def page_fields(content: EstimateContent) -> dict[str, object]:
    """Return what the template of an estimate shows in addition to what every page has."""
    found, level, grip = content.found, content.level, grip_if_any(content.found)
    meant = [one.verdict for one in (content.wear, grip) if one is not None]
    steps = next_steps(content.verdict, car=True, further=meant)
    records = found.residual
    samples = sum(as_signal(residual).timepts.size for residual in records)
    seconds = sum(as_signal(residual).duration for residual in records)
    tested = f"{found.chi_square:.4g} at {count(found.freedom, 'degree')} of freedom"
    hidden = max(0, len(records) - MOST_LISTED)
    with page_style():
        return {
            "facts": f"{count(len(records), 'record')}, {samples} samples, {seconds:.4g} s",
            "limits": limit_rows(content.limits),
            "springs": spring_rows(found, level),
            "found_others": len(found.alternatives),
            "steps": [str(step) for step in (*limit_steps(content.limits), *steps)],
            "masses": masses_of(found),
            "quantities": quantities_in(found.parameters),
            "chi_square": tested if found.freedom else "was not tested: the residual is rounding",
            "changed": _changes(found, level),
            "modes": [(quantities, "") for quantities in mode_quantities(found.modes, level)],
            "shapes": list(shape_pictures(found.modes)),
            **wear_fields(content.wear),
            **stretch_fields(content.drives),
            "curves": [(printable(one.name), str(one.verdict.headline), _curve(one, k, level))
                       for k, one in enumerate(content.curves)],
            "records": [_part(content, k) for k in range(min(len(records), MOST_LISTED))],
            **performance_fields(grip, content.ride, level),
            **sensitivity_fields(sensitivities_of(found, content.ride), content.ride),
            "tuning": drive_to_tune(content.ride),
            "remade_of": "",
            "hidden": count(hidden, "further record") if hidden else "",
        }  # fmt: skip


def _changes(found: Estimate, level: Ratio) -> Picture:
    described = "Change of each parameter from nominal with its interval"
    height = 0.6 + 0.22 * (2 + len(found.parameters))
    draw = partial(_draw_changes, found, level)
    return picture(draw, name="changes", described=described, height=height, wide_height=height)


def _draw_changes(found: Estimate, level: Ratio, figure: Figure) -> None:
    ax = figure.subplots()
    draw_changes(found, ax, level)
    ax.set_title("", loc="left")


def _curve(found: DamperCurve, which: int, level: Ratio) -> Picture:
    described = f"Force of damper {which + 1} over its velocity with its band"
    return picture(
        partial(_draw_curve, found, level), name=f"curve-{which}", described=described, height=2.6, wide_height=2.6
    )


def _draw_curve(found: DamperCurve, level: Ratio, figure: Figure) -> None:
    plot_damper_curve(found, figure.subplots(), level=level)


def _part(content: EstimateContent, which: int) -> RecordPart:
    found = content.found
    residual = as_signal(found.residual[which])
    named = f": {printable(content.sources[which].file)}" if len(content.sources) == len(found.residual) else ""
    rate = f"{residual.timepts.size} samples at {1 / residual.step:.6g} Hz"
    noise, white = found.noise_std[which].tolist(), found.whiteness[which].tolist()
    return RecordPart(
        heading=f"Record {which + 1}{named}, {rate}",
        pictures=tuple(_pictures(found, which)),
        channels=tuple(
            (printable(name), channel_unit(found.suspension, name), f"{std:#.3g}", signed(f"{correlation:+.2f}"))
            for name, std, correlation in zip(residual.channels, noise, white, strict=True)
        ),
    )


def _pictures(found: Estimate, which: int) -> Iterator[tuple[str, tuple[Picture, ...]]]:
    residual = as_signal(found.residual[which])
    causes = found.causes[which]
    for k, name in enumerate(residual.channels[:MOST_LISTED]):
        described = f"channel {k + 1} of record {which + 1} with fit and residual"
        frf = () if not causes or name in causes else _responses(found, which, k)
        yield (
            printable(name),
            (
                picture(partial(_draw_time, found, which, k), name=f"time-{which}-{k}", height=1.75,
                        described=f"Motion of {described}"),
                picture(partial(_draw_spectra, found, which, k), name=f"spectrum-{which}-{k}", height=1.75,
                        described=f"Power spectra of {described}"),
                *frf,
            ),
        )  # fmt: skip


def _responses(found: Estimate, which: int, channel: int) -> tuple[Picture, ...]:
    name = as_signal(found.fitted[which]).channels[channel]
    described = f"frequency response of channel {channel + 1} of record {which + 1} and of its fit"
    return (
        picture(partial(_draw_frf, found, which, name, draw_gain), name=f"gain-{which}-{channel}", height=1.75,
                described=f"Gain of the {described}"),
        picture(partial(_draw_frf, found, which, name, draw_phase), name=f"phase-{which}-{channel}", height=1.75,
                described=f"Phase of the {described}"),
    )  # fmt: skip


def _draw_frf(found: Estimate, which: int, name: str, draw: Callable[[Axes, Frf], None], figure: Figure) -> None:
    ax = figure.subplots()
    frf = responses(found, record=which, channels=[name])[name]
    draw(ax, frf)
    ax.set_title(f"response to {shown(frf.cause)}", loc="left", fontsize="small")
    ax.set_xlabel("frequency [Hz]")


def _draw_time(found: Estimate, which: int, channel: int, figure: Figure) -> None:
    fitted, residual, kept = as_signal(found.fitted[which]), as_signal(found.residual[which]), lively(found, which)
    fit, left = fitted.values[channel, kept], residual.values[channel, kept]
    ax = figure.subplots()
    plot_residual(ax, residual.timepts[kept], fit + left, fit, left)
    ax.set_xlabel(time_label(found, which))
    unit_ticks(ax, channel_unit(found.suspension, fitted.channels[channel]))


def _draw_spectra(found: Estimate, which: int, channel: int, figure: Figure) -> None:
    fitted, residual = as_signal(found.fitted[which]), as_signal(found.residual[which])
    fit, left = fitted.values[channel], residual.values[channel]
    ax = figure.subplots()
    draw_spectra(ax, fit + left, fit, left, 1 / residual.step, modes=found.modes, band=found.band_hz)
    ax.set_ylabel(density_label(channel_unit(found.suspension, fitted.channels[channel])))
    ax.set_xlabel("frequency [Hz]")
