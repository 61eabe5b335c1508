"""Pictures of each step, the report as an HTML page, and the same content as JSON.

`report` writes one HTML page, `report_to_dict` the same as JSON (schema in ``schemas/``), of what `content_of` puts
together. Each ``plot_…`` draws one picture on matplotlib Axes; the page shows the same pictures as SVG. ``drawings``
says which of them a result draws with ``.plot()`` and in a notebook.

To add a picture to the page: draw it on Axes in a module of its own, as in ``plot_entropy.py``; add a field to
`Pictures` in ``pictures.py`` and fill it with `picture`; place it in ``templates/report.html.j2`` with
``{{ figure(pictures.…) }}``. Take colours from ``colours.py``: they have counterparts for dark screens.
"""

from suspid.reporting.content import Content
from suspid.reporting.content_of import content_of
from suspid.reporting.damper_curve_json import damper_curve_to_dict, read_curves
from suspid.reporting.drawings import drawing_of
from suspid.reporting.drive_json import drive_to_dict
from suspid.reporting.drive_page import DriveContent
from suspid.reporting.estimate_json import estimate_from_dict, estimate_to_dict, read_estimate
from suspid.reporting.estimate_page import EstimateContent
from suspid.reporting.fleet_page import FleetContent
from suspid.reporting.json_schema import json_schema
from suspid.reporting.pdf import browser, write_pdf
from suspid.reporting.plot_amplitude import plot_amplitude
from suspid.reporting.plot_comparison import plot_comparison
from suspid.reporting.plot_damper_curve import plot_damper_curve
from suspid.reporting.plot_drive import plot_drive
from suspid.reporting.plot_entropy import plot_entropy
from suspid.reporting.plot_estimate import plot_estimate
from suspid.reporting.plot_fit import plot_fit
from suspid.reporting.plot_frf import plot_frf
from suspid.reporting.plot_grip import plot_grip
from suspid.reporting.plot_identification import PAGE, plot_identification
from suspid.reporting.plot_recording import plot_recording
from suspid.reporting.plot_ride import plot_ride
from suspid.reporting.plot_scalogram import plot_scalogram
from suspid.reporting.plot_sensitivities import plot_sensitivities
from suspid.reporting.plot_shapes import plot_shapes
from suspid.reporting.plot_skeletons import plot_skeletons
from suspid.reporting.plot_spectra import plot_spectra
from suspid.reporting.plot_stabilization import plot_stabilization
from suspid.reporting.plot_tuning import plot_tuning
from suspid.reporting.report import report
from suspid.reporting.report_json import report_to_dict
from suspid.reporting.ride_json import ride_to_dict, tuning_to_dict
from suspid.reporting.source import Source, source_of
from suspid.reporting.wear_json import comparison_to_dict, grip_result, wear_to_dict

__all__ = [
    "PAGE",
    "Content",
    "DriveContent",
    "EstimateContent",
    "FleetContent",
    "Source",
    "browser",
    "comparison_to_dict",
    "content_of",
    "damper_curve_to_dict",
    "drawing_of",
    "drive_to_dict",
    "estimate_from_dict",
    "estimate_to_dict",
    "grip_result",
    "json_schema",
    "plot_amplitude",
    "plot_comparison",
    "plot_damper_curve",
    "plot_drive",
    "plot_entropy",
    "plot_estimate",
    "plot_fit",
    "plot_frf",
    "plot_grip",
    "plot_identification",
    "plot_recording",
    "plot_ride",
    "plot_scalogram",
    "plot_sensitivities",
    "plot_shapes",
    "plot_skeletons",
    "plot_spectra",
    "plot_stabilization",
    "plot_tuning",
    "read_curves",
    "read_estimate",
    "report",
    "report_to_dict",
    "ride_to_dict",
    "source_of",
    "tuning_to_dict",
    "wear_to_dict",
    "write_pdf",
]
