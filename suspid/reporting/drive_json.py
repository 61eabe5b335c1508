"""A drive as JSON, as ``suspid drive --json`` writes it.

Every field is described with its unit in ``suspid/reporting/schemas/drive.schema.json`` (JSON Schema, draft 2020-12),
which `json_schema` returns.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from suspid.identification import to_json
from suspid.levels import LEVEL
from suspid.reporting.damper_curve_json import damper_curve_to_dict
from suspid.reporting.estimate_json import DRIVE_FORMAT, estimate_to_dict
from suspid.reporting.wear_json import wear_to_dict
from suspid.units import Ratio

if TYPE_CHECKING:
    from suspid.analysis import DriveAnalysis
    from suspid.greybox import BodyModes, Drives


def drive_to_dict(found: DriveAnalysis, *, level: Ratio = LEVEL) -> dict[str, object]:
    """Return what a drive tells as plain lists and numbers; numbers that are not finite are None.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import RawChannel, Recording, analyse_drive
    >>> t = np.arange(2000) / 100
    >>> still = RawChannel(name="az", unit="m/s2", timepts=t, values=1e-3 * np.sin(9 * t), rate=None)
    >>> drive_to_dict(analyse_drive(Recording(title="parked", channels=(still,))))["usable"]
    0.0
    """
    from importlib.metadata import version

    fields = {
        "format": DRIVE_FORMAT,
        "verdict": found.verdict.to_dict(),
        "level": level,
        "usable": found.usable,
        "files": [_file(one) for one in found.drives],
        "estimate": None if found.estimate is None else estimate_to_dict(found.estimate, level=level),
        "curves": [damper_curve_to_dict(one, level=level) for one in found.curves],
        "wear": None if found.wear is None else wear_to_dict(found.wear),
        "body": None if found.body is None else _body(found.body, level),
        "suspid": version("suspid"),
    }
    plain: dict[str, object] = json.loads(to_json(fields))
    return plain


def _file(drives: Drives) -> dict[str, object]:
    return {
        "title": drives.title,
        "length": drives.length,
        "usable": drives.usable,
        "stretches": [
            {
                "start": one.start,
                "stop": one.stop,
                "taken": one.taken,
                "speed": one.speed,
                "reasons": [reason.to_dict() for reason in one.reasons],
            }
            for one in drives
        ],
    }


def _body(body: BodyModes, level: Ratio) -> list[dict[str, object]]:
    rows = []
    for mode in body:
        low, high = mode.interval(level)
        rows.append(
            {
                "channel": mode.channel,
                "hertz": mode.hertz,
                "lower": low,
                "upper": high,
                "models": [{"hertz": f, "std": std} for f, std in mode.models],
                "why": None if mode.why is None else mode.why.to_dict(),
            }
        )
    return rows
