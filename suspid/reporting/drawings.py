"""The pictures that results draw with `.plot()`, see `suspid.results`."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from suspid.analysis import Analysis, CheckedLimits, DriveAnalysis
from suspid.cleaning import Cleaned
from suspid.decays import Decays
from suspid.fleet import DamperTrends, FleetSummary
from suspid.greybox import BodyModes, DamperCurve, Drives, Estimate
from suspid.identification import Identification, Repeats, Stabilization
from suspid.model import Comparison, ModalSet
from suspid.performance import ActiveTuning, DamperTuning, Grip, Ride, RoadClass, Sensitivities, Tuning, Wear
from suspid.reconstruction import Reconstruction
from suspid.recordings import Recording
from suspid.reporting.colours import Colour
from suspid.reporting.plot_amplitude import draw_amplitudes
from suspid.reporting.plot_comparison import draw_errors
from suspid.reporting.plot_damper_curve import plot_damper_curve
from suspid.reporting.plot_drive import draw_finding, draw_stretches, plot_drive
from suspid.reporting.plot_entropy import plot_entropy
from suspid.reporting.plot_estimate import draw_changes, plot_estimate
from suspid.reporting.plot_fleet import draw_fleet, draw_losses, losses_of
from suspid.reporting.plot_grip import draw_adhesion, plot_grip
from suspid.reporting.plot_identification import PAGE, plot_identification
from suspid.reporting.plot_recording import draw_cleaned, draw_decays, draw_raw, plot_recordings
from suspid.reporting.plot_ride import draw_spectrum, plot_ride, size_of_ride
from suspid.reporting.plot_rows import draw_active, draw_body, draw_limits, draw_road
from suspid.reporting.plot_scalogram import plot_scalogram
from suspid.reporting.plot_sensitivities import plot_sensitivities, size_of
from suspid.reporting.plot_shapes import plot_shapes
from suspid.reporting.plot_skeletons import plot_modulus, plot_skeletons
from suspid.reporting.plot_stabilization import plot_stabilization, plot_stabilization_page
from suspid.reporting.plot_tuning import draw_damper, draw_front, plot_tuning
from suspid.results import Drawing
from suspid.results import drawing_of as drawing_of
from suspid.wavelets import BandwidthSearch, Ridge, Scalogram

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@drawing_of.register
def _(found: ModalSet) -> Drawing:
    return Drawing(alone=partial(_draw_modes, found))


@drawing_of.register
def _(found: Repeats) -> Drawing:
    if any(each is not None for each in found.amplitude_dependence):
        return Drawing(alone=partial(_draw_modes, found.modes), page=partial(draw_amplitudes, found))
    return Drawing(alone=partial(_draw_modes, found.modes))


@drawing_of.register
def _(found: Identification) -> Drawing:
    return Drawing(alone=partial(_draw_scalogram, found), page=partial(plot_identification, found), size=PAGE)


@drawing_of.register
def _(found: Analysis) -> Drawing | None:
    several = found.repeats if found.tests else None
    return drawing_of(found.estimate or several or found.identification)


@drawing_of.register
def _(found: Estimate) -> Drawing:
    return Drawing(alone=partial(draw_changes, found), page=partial(plot_estimate, found), size=PAGE)


@drawing_of.register
def _(found: DamperCurve) -> Drawing:
    return Drawing(alone=partial(plot_damper_curve, found))


@drawing_of.register
def _(found: DriveAnalysis) -> Drawing:
    return Drawing(alone=partial(draw_finding, found), page=partial(plot_drive, found), size=PAGE)


@drawing_of.register
def _(found: Drives) -> Drawing | None:
    return Drawing(alone=partial(_draw_stretches, found)) if len(found.course) else None


@drawing_of.register
def _(found: Cleaned) -> Drawing:
    return Drawing(alone=partial(draw_cleaned, found), page=partial(plot_recordings, found), size=(7.0, 5.5))


@drawing_of.register
def _(found: Decays) -> Drawing | None:
    return Drawing(alone=partial(draw_decays, found)) if found else None


@drawing_of.register
def _(found: Reconstruction) -> Drawing | None:
    return None if found.nominal is None else Drawing(alone=partial(draw_changes, found))


@drawing_of.register
def _(found: Comparison) -> Drawing:
    return Drawing(alone=partial(draw_errors, found))


@drawing_of.register
def _(found: Stabilization) -> Drawing:
    alone, page = partial(plot_stabilization, found), partial(plot_stabilization_page, found)
    # Room for the damping below the diagram [inch].
    return Drawing(alone=alone, page=page, size=(7.0, 5.5))


@drawing_of.register(Wear)
@drawing_of.register(DamperTrends)
def _(found: Wear | DamperTrends) -> Drawing | None:
    return Drawing(alone=partial(draw_losses, found)) if losses_of(found) else None


@drawing_of.register
def _(found: FleetSummary) -> Drawing | None:
    return Drawing(alone=partial(draw_fleet, found)) if found.distributions else None


@drawing_of.register
def _(found: Scalogram) -> Drawing:
    return Drawing(alone=lambda ax: plot_scalogram(found, ax=ax))


@drawing_of.register
def _(found: BandwidthSearch) -> Drawing:
    return Drawing(alone=lambda ax: plot_entropy(found, ax=ax))


@drawing_of.register
def _(found: Grip) -> Drawing:
    return Drawing(alone=partial(draw_adhesion, found), page=partial(plot_grip, found), size=(7.0, 5.5))


@drawing_of.register
def _(found: Ride) -> Drawing | None:
    if not found.channels:
        return None
    return Drawing(
        alone=partial(draw_spectrum, found, found.channels[0]), page=partial(plot_ride, found), size=size_of_ride(found)
    )


@drawing_of.register
def _(found: Tuning) -> Drawing:
    return Drawing(alone=partial(draw_front, found), page=partial(plot_tuning, found), size=(7.0, 8.0))


@drawing_of.register
def _(found: DamperTuning) -> Drawing:
    return Drawing(alone=partial(draw_damper, found))


@drawing_of.register
def _(found: Sensitivities) -> Drawing:
    return Drawing(
        alone=lambda ax: plot_sensitivities(found, ax),
        page=lambda figure: plot_sensitivities(found, figure.subplots()),
        size=size_of(found),
        cell=size_of(found),
    )


@drawing_of.register
def _(found: CheckedLimits) -> Drawing:
    return Drawing(alone=partial(draw_limits, found))


@drawing_of.register
def _(found: BodyModes) -> Drawing | None:
    return Drawing(alone=partial(draw_body, found)) if any(mode.models for mode in found) else None


@drawing_of.register
def _(found: ActiveTuning) -> Drawing:
    return Drawing(alone=partial(draw_active, found))


@drawing_of.register
def _(found: RoadClass) -> Drawing:
    return Drawing(alone=partial(draw_road, found))


@drawing_of.register
def _(found: Recording) -> Drawing | None:
    drawn = [channel for channel in found.channels if channel.duration > 0]
    return Drawing(alone=partial(draw_raw, drawn[0])) if drawn else None


@drawing_of.register
def _(found: Ridge) -> Drawing:
    return Drawing(
        alone=partial(plot_modulus, found),
        page=lambda figure: plot_skeletons([found], axes=figure.subplots(2, 1, squeeze=False, sharex=True)),
        size=(7.0, 5.5),
    )


def _draw_stretches(found: Drives, ax: Axes) -> None:
    draw_stretches(ax, found)
    ax.set_xlabel("time [s]")


def _draw_scalogram(found: Identification, ax: Axes) -> None:
    plot_scalogram(found.scalogram, ax=ax, ridges=found.ridges, modes=found.modes)


def _draw_modes(modes: ModalSet, ax: Axes) -> None:
    """Draw the shapes; where there are none, damping ratio against frequency with 95 % intervals."""
    if modes.shapes is not None and len(modes.channels) > 1:
        plot_shapes(modes, ax=ax)
        return
    hertz = modes.wn / (2 * np.pi)
    if modes.covariance is not None:
        ends = modes.interval()
        reach = np.abs(ends.wn.T / (2 * np.pi) - hertz), np.abs(ends.zeta.T - modes.zeta)
        ax.errorbar(hertz, modes.zeta, xerr=reach[0], yerr=reach[1], fmt="none", color=Colour.BLUE)
    ax.plot(hertz, modes.zeta, "o", color=Colour.BLUE, markersize=4)
    ax.set(xlabel="natural frequency [Hz]", ylabel="damping ratio [1]")
