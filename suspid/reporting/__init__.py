"""What people look at: pictures, the HTML page, JSON.

`report` writes one HTML page, `report_to_dict` the same content as JSON (schema in ``schemas/``). `plots` draws
each step on matplotlib Axes: scalogram, skeletons, entropy, fit, mode shapes.
"""

from suspid.reporting.plots import (
    PAGE,
    plot_entropy,
    plot_fit,
    plot_identification,
    plot_scalogram,
    plot_shapes,
    plot_skeletons,
)
from suspid.reporting.report import report
from suspid.reporting.report_json import Source, judgement_of, report_to_dict, source_of
from suspid.reporting.thinning import drawable

__all__ = [
    "PAGE",
    "Source",
    "drawable",
    "judgement_of",
    "plot_entropy",
    "plot_fit",
    "plot_identification",
    "plot_scalogram",
    "plot_shapes",
    "plot_skeletons",
    "report",
    "report_to_dict",
    "source_of",
]
