"""A report as JSON: everything that the page of `suspid.reporting` shows, as numbers.

The file is that of `suspid.identification.modes_json` with more beside it; ``suspid reconstruct`` reads it as it
stands. Every field, with its unit, is described in ``suspid/reporting/schemas/report.schema.json`` (JSON Schema, draft
2020-12), which `report_schema` returns.
"""

from __future__ import annotations

import hashlib
import json
import os
import platform
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from suspid.analysis import Judgement, judge
from suspid.errors import InputError
from suspid.files import printable
from suspid.identification import identification_to_dict, modes_to_dict, to_json
from suspid.reconstruction import reconstruction_to_dict
from suspid.reporting.thinning import drawable, is_whole
from suspid.signals import as_signal
from suspid.units import Ratio

if TYPE_CHECKING:
    import control

    from suspid.cleaning import Cleaned
    from suspid.decays import Decay
    from suspid.identification import Identification, Repeats
    from suspid.reconstruction import Reconstruction

FORMAT = "suspid report 1"
PACKAGES = ("suspid", "numpy", "scipy", "control", "PyWavelets", "cvxpy")
# A record begins with a decay that is given if it starts this near to it [sampling steps].
SAME_START = 1.5


@dataclass(frozen=True, kw_only=True, slots=True)
class Source:
    """Where a record comes from, and what was done to get the report.

    Parameters
    ----------
    file : str
        Name of the file.
    sha256 : str
        Its SHA-256, in hexadecimal.
    size : int
        Its size [byte].
    command : str
        The command that made the report.
    created : str
        Date and time of the report, as the reader should see it; ISO 8601 is best.
    """

    file: str
    sha256: str
    size: int
    command: str
    created: str


def source_of(path: str | os.PathLike[str], *, command: str, created: str) -> Source:
    """Return the source that a file is, with its hash.

    Raises
    ------
    InputError
        If the file cannot be read.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "decay.csv")
    ...     _ = path.write_bytes(b"abc")
    ...     source = source_of(path, command="suspid report decay.csv", created="2026-01-01")
    >>> source.size, source.sha256[:16]
    (3, 'ba7816bf8f01cfea')
    """
    file = Path(path)
    try:
        with file.open("rb") as stream:
            digest = hashlib.file_digest(stream, "sha256").hexdigest()
            size = stream.tell()
    except (OSError, ValueError) as refusal:
        raise InputError(f"{printable(str(path))}: cannot be read: {printable(str(refusal))}") from None
    return Source(file=file.name, sha256=digest, size=size, command=command, created=created)


def report_to_dict(
    identification: Identification,
    *,
    source: Source | None = None,
    cleaned: Cleaned | None = None,
    decays: Sequence[Decay] = (),
    repeats: Repeats | None = None,
    reconstruction: Reconstruction | None = None,
    level: Ratio = 0.95,
    warnings: Sequence[str] = (),
) -> dict[str, object]:
    """Return everything that `report` shows as plain lists and numbers; what is not finite is None.

    The parameters are those of `report`.

    Examples
    --------
    >>> from suspid import free_decay, identify, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=200)
    >>> found = identify(free_decay(car, np.arange(0, 10, 0.005), initial_state={"v_chassis": 1.0}))
    >>> report_to_dict(found)["verdict"]["headline"]
    '2 modes found'
    """
    shown = drawable(identification)
    modes = shown.modes
    ends = modes.interval(level) if modes.covariance is not None else None
    used = used_decay(shown.response, decays)
    turn = 2 * np.pi
    judgement = judgement_of(
        shown, cleaned=cleaned, decays=decays, repeats=repeats, reconstruction=reconstruction, level=level
    )
    halves, collinearity = shown.halves, shown.collinearity
    content = identification_to_dict(shown, file=source.file if source else "", warnings=warnings)
    content |= {
        "report": FORMAT,
        "level": level,
        "verdict": {
            "headline": judgement.headline,
            "trust": judgement.trust,
            "said": judgement.said,
            "support": list(judgement.support),
            "doubts": list(judgement.doubts),
            "notes": list(judgement.notes),
        },
        "quality": [
            {
                "kind": kind,
                "frequency_interval_hz": None if ends is None else (ends.wn[k] / turn).tolist(),
                "wn_interval_rad_per_s": None if ends is None else ends.wn[k].tolist(),
                "zeta_interval": None if ends is None else ends.zeta[k].tolist(),
                "phase_collinearity": float(collinearity[k]),
                "halves_apart_std": float(halves[k]),
                "residual_over_noise": float(shown.loudness[k]),
            }
            for k, kind in enumerate(modes.kinds)
        ],
        "units": list(units_of(shown.response, cleaned)),
        "lag_1_correlation": shown.whiteness.tolist(),
        "considered": [
            {
                "pole_rad_per_s": [c.pole.real, c.pole.imag],
                "frequency_hz": abs(c.pole) / turn,
                "wn_rad_per_s": abs(c.pole),
                "zeta": -c.pole.real / abs(c.pole) if c.pole else 0.0,
                "reason": c.reason,
                "removed": c.removed,
            }
            for c in shown.considered
        ],
        "wavelet": {"bandwidth": shown.scalogram.wavelet.bandwidth, "whole_record": is_whole(shown)},
        "findings": None
        if cleaned is None
        else [
            {
                "kind": str(finding.kind),
                "channel": finding.channel,
                "start_s": finding.start,
                "stop_s": finding.stop,
                "samples": finding.samples,
                "text": finding.text,
                "repaired": finding.repaired,
            }
            for finding in cleaned.findings
        ],
        "decays": [
            {
                "start_s": decay.start,
                "stop_s": decay.stop,
                "kind": decay.kind,
                "cycles": decay.cycles,
                "doubts": [str(doubt) for doubt in decay.doubts],
                "used": i == used,
            }
            for i, decay in enumerate(decays)
        ],
        "decay_remarks": list(remarks_of(decays)),
        "repeats": None if repeats is None else _repeats_to_dict(repeats),
        "reconstruction": None if reconstruction is None else reconstruction_to_dict(reconstruction, level=level),
        "source": None
        if source is None
        else {
            "file": source.file,
            "sha256": source.sha256,
            "size_bytes": source.size,
            "command": source.command,
            "created": source.created,
        },
        "versions": versions(),
    }
    plain: dict[str, object] = json.loads(to_json(content))
    return plain


def _repeats_to_dict(repeats: Repeats) -> dict[str, object]:
    return {
        **modes_to_dict(repeats.modes),
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


def report_schema() -> dict[str, object]:
    """Return the JSON Schema of what `report_to_dict` returns.

    Examples
    --------
    >>> report_schema()["$schema"]
    'https://json-schema.org/draft/2020-12/schema'
    """
    from importlib.resources import files

    text = files("suspid.reporting").joinpath("schemas", "report.schema.json").read_text(encoding="utf-8")
    schema: dict[str, object] = json.loads(text)
    return schema


def judgement_of(
    identification: Identification,
    *,
    cleaned: Cleaned | None,
    decays: Sequence[Decay],
    repeats: Repeats | None,
    reconstruction: Reconstruction | None,
    level: Ratio,
) -> Judgement:
    """Return the verdict on all that a report is given."""
    used = used_decay(identification.response, decays)
    return judge(
        identification,
        decay_doubts=() if used is None else [str(doubt) for doubt in decays[used].doubts],
        unrepaired=0 if cleaned is None else len(cleaned.verdict.doubts),
        repeats=repeats,
        reconstruction=reconstruction,
        level=level,
    )


def used_decay(response: control.TimeResponseData, decays: Sequence[Decay]) -> int | None:
    """Return which of the decays the record is, or None if it is none of them."""
    signal = as_signal(response)
    near = [i for i, decay in enumerate(decays) if abs(decay.start - signal.start) <= SAME_START * signal.step]
    return min(near, key=lambda i: abs(decays[i].stop - signal.start - signal.duration), default=None)


def remarks_of(decays: Sequence[Decay]) -> tuple[str, ...]:
    """Return what was said of stretches that are no decay, if the decays come with remarks."""
    return tuple(str(remark) for remark in getattr(decays, "remarks", ()))


def units_of(response: control.TimeResponseData, cleaned: Cleaned | None) -> tuple[str, ...]:
    """Return the unit of each channel of the record; empty where it is not known."""
    names = as_signal(response).channels
    if cleaned is None:
        return ("",) * len(names)
    known = dict(zip(as_signal(cleaned.record).channels, cleaned.units, strict=True))
    return tuple(known.get(name, "") for name in names)


def versions() -> dict[str, str]:
    """Return the versions of what did the work."""
    from importlib.metadata import version

    return {"python": platform.python_version()} | {name: version(name) for name in PACKAGES}
