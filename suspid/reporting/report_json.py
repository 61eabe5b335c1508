"""A report as JSON: everything that the page of `report` shows, as numbers.

The file is that of `identification_to_dict` with further fields; ``suspid reconstruct`` reads it as it is. Every field
is described with its unit in ``suspid/reporting/schemas/report.schema.json`` (JSON Schema, draft 2020-12), which
`json_schema` returns.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np

from suspid.arguments import explained
from suspid.identification import identification_to_dict, repeats_to_dict, to_json
from suspid.model import car_to_toml
from suspid.performance import grip_if_any
from suspid.reconstruction import reconstruction_to_dict
from suspid.reporting.content import Content
from suspid.reporting.content_of import content_of
from suspid.reporting.estimate_json import estimate_to_dict
from suspid.reporting.estimate_page import EstimateContent
from suspid.reporting.limits_json import limits_to_dict
from suspid.reporting.ride_json import ride_to_dict
from suspid.reporting.sensitivity_part import sensitivities_of
from suspid.reporting.source import Source, versions
from suspid.reporting.thinning import is_whole
from suspid.reporting.wear_json import grip_to_dict
from suspid.results import check_kind
from suspid.units import Ratio

if TYPE_CHECKING:
    from suspid.analysis import Analysis
    from suspid.cleaning import Cleaned
    from suspid.greybox import Estimate
    from suspid.identification import Identification, Repeats
    from suspid.performance import Sensitivities
    from suspid.reconstruction import Reconstruction


@explained
def report_to_dict(found: Identification | Analysis | Content | EstimateContent) -> dict[str, object]:
    """Return everything that `report` shows as plain lists and numbers; numbers that are not finite are None.

    Takes an identification, an analysis, or what `content_of` makes of them or of an estimate: the file is then that of
    `estimate_to_dict` with grip, ride and sensitivities.

    Examples
    --------
    >>> from suspid import free_decay, identify, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=200)
    >>> found = identify(free_decay(car, np.arange(0, 10, 0.005), initial_state={"v_chassis": 1.0}))
    >>> report_to_dict(found)["verdict"]["level"]
    'sound'
    """
    if isinstance(found, EstimateContent):
        return _of_estimate(found)
    check_kind(found, {"Identification": "identify", "Analysis": "analyse", "Content": "content_of"})
    content = found if isinstance(found, Content) else content_of(found)
    shown, source, analysis = content.identification, content.source, content.analysis
    repeats, car = analysis.repeats, analysis.reconstruction
    fields = identification_to_dict(shown, file=source.file if source else "", warnings=content.warnings)
    fields |= {
        "report": "suspid report 3",
        "level": content.level,
        "verdict": analysis.verdict.to_dict(),
        "quality": _quality(shown, content.level),
        "units": list(content.units),
        "lag_1_correlation": shown.whiteness.tolist(),
        "wavelet": {"bandwidth": shown.scalogram.wavelet.bandwidth, "whole_record": is_whole(shown)},
        "findings": None if content.cleaned is None else _findings(content.cleaned),
        "decays": _decays(content),
        "decay_remarks": list(content.remarks),
        "repeats": None if repeats is None else _repeats_to_dict(repeats),
        "reconstruction": None if car is None else reconstruction_to_dict(car, level=content.level),
        "estimate": None if analysis.estimate is None else estimate_to_dict(analysis.estimate, level=content.level),
        "grip": None if content.grip is None else grip_to_dict(content.grip, level=content.level),
        "ride": None if content.ride is None else ride_to_dict(content.ride, level=content.level),
        "sensitivities": _sensitivities(content.sensitivities),
        "limits": limits_to_dict(content.limits),
        "next_steps": [step.to_dict() for step in content.steps],
        "car": car_to_plain(content.car, content.springs),
        "source": None if source is None else _source(source),
        "sources": [_source(one) for one in content.sources],
        "versions": versions(),
    }
    plain: dict[str, object] = json.loads(to_json(fields))
    return plain


def _of_estimate(content: EstimateContent) -> dict[str, object]:
    grip, level = grip_if_any(content.found), content.level
    fields = estimate_to_dict(content.found, level=level, limits=content.limits) | {
        "grip": None if grip is None else grip_to_dict(grip, level=level),
        "ride": None if content.ride is None else ride_to_dict(content.ride, level=level),
        "sensitivities": _sensitivities(sensitivities_of(content.found, content.ride)),
    }
    plain: dict[str, object] = json.loads(to_json(fields))
    return plain


def _sensitivities(found: Sensitivities | None) -> dict[str, object] | None:
    return None if found is None else {
        "names": list(found.names),
        "values": found.values.tolist(),
        "parameters": list(found.parameters),
        "elasticity": found.elasticity.tolist(),
    }  # fmt: skip


def _quality(shown: Identification, level: Ratio) -> list[dict[str, object]]:
    modes = shown.modes
    ends = modes.interval(level) if modes.covariance is not None else None
    halves, collinearity = shown.halves, shown.collinearity
    return [
        {
            "kind": kind,
            "frequency_interval_hz": None if ends is None else (ends.wn[k] / (2 * np.pi)).tolist(),
            "wn_interval_rad_per_s": None if ends is None else ends.wn[k].tolist(),
            "zeta_interval": None if ends is None else ends.zeta[k].tolist(),
            "phase_collinearity": float(collinearity[k]),
            "halves_apart_std": float(halves[k]),
            "residual_over_noise": float(shown.loudness[k]),
        }
        for k, kind in enumerate(modes.kinds)
    ]


def _findings(cleaned: Cleaned) -> list[dict[str, object]]:
    return [
        {
            "kind": str(finding.kind),
            "channel": finding.channel,
            "start_s": finding.start,
            "stop_s": finding.stop,
            "samples": finding.samples,
            "text": finding.text,
            "remark": finding.remark.to_dict(),
            "repaired": finding.repaired,
        }
        for finding in cleaned.findings
    ]


def _decays(content: Content) -> list[dict[str, object]]:
    used = content.used
    return [
        {
            "start_s": decay.start,
            "stop_s": decay.stop,
            "kind": decay.kind,
            "cycles": decay.cycles,
            "doubts": [str(doubt) for doubt in decay.doubts],
            "remarks": [doubt.to_dict() for doubt in decay.doubts],
            "used": i == used,
        }
        for i, decay in enumerate(content.analysis.decays)
    ]


def _source(source: Source) -> dict[str, object]:
    return {
        "file": source.file,
        "sha256": source.sha256,
        "size_bytes": source.size,
        "command": source.command,
        "created": source.created,
    }


def car_to_plain(file: Source | None, springs: Estimate | Reconstruction | None) -> dict[str, object] | None:
    """Return the text of the car file with its hash, or of the nominal car; None without one."""
    if file is not None:
        return {"file": file.file, "sha256": file.sha256, "toml": file.text}
    if springs is None or springs.nominal is None:
        return None
    return {"file": "", "sha256": "", "toml": car_to_toml(springs.nominal)}


def _repeats_to_dict(repeats: Repeats) -> dict[str, object]:
    return {
        **repeats_to_dict(repeats),
        "agreement": [
            {
                "chi_square": agreement.chi_square,
                "freedom": agreement.freedom,
                "probability": agreement.probability,
                "widening": agreement.widening,
            }
            for agreement in repeats.consistency
        ],
        "each": [
            {
                "start_s": start,
                "stop_s": stop,
                "frequency_hz": (found.modes.wn / (2 * np.pi)).tolist(),
                "wn_rad_per_s": found.modes.wn.tolist(),
                "zeta": found.modes.zeta.tolist(),
            }
            for (start, stop), found in zip(repeats.spans, repeats.each, strict=True)
        ],
    }
