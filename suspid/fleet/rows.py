"""One record of a fleet as rows of the tables: modes and springs, a drive, or the reason why there are none."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

from suspid.analysis import STEPS, Analysis, analyse
from suspid.files import printable
from suspid.fleet.drive_rows import drive_rows
from suspid.fleet.failures import failure, which, why_of
from suspid.fleet.job import Job
from suspid.fleet.records import Entry, Seen, source_of
from suspid.fleet.tables import Row, Rows, doubts_of
from suspid.model import car_from_toml
from suspid.reconstruction import reconstruction_to_dict
from suspid.samples import held
from suspid.signals import as_signal
from suspid.words import Failure, Note, Remark, Step

STEP_OF = dict(zip(STEPS, (Step.READ, Step.FIND_DECAYS, Step.IDENTIFY, Step.RECONSTRUCT), strict=True))


def record_rows(job: Job, entry: Entry, tell: Callable[[Seen], None]) -> Rows:
    """Return the rows of one record: those of `analyse` or `analyse_drive`; what fails is a row among the failures.

    ``tell`` is called with what is known of the record as soon as it is known.
    """
    seen = [Seen()]

    def know(now: Seen) -> None:
        seen.append(now)
        tell(now)

    try:
        with warnings.catch_warnings(), source_of(entry, know) as source:
            # What is found in a record has its columns.
            warnings.simplefilter("ignore")
            if job.drive is not None:
                return drive_rows(job, job.drive, entry, source, seen[-1], know)
            found = analyse(
                source,
                car=None if job.car is None else car_from_toml(job.car),
                settings=job.settings,
                progress=lambda step: know(replace(seen[-1], step=STEP_OF[step])),
            )
            modes = _mode_rows(job, entry, seen[-1], found)
            springs = _spring_rows(job, entry, seen[-1], found)
    except Exception as error:
        return failure(job, entry, seen[-1], why_of(error))
    if not modes:
        verdict = found.verdict
        why = "; ".join(str(one) for one in (*verdict.doubts, *found.notes)) or str(verdict.headline)
        checks = [str(one.code) for one in (*verdict.doubts, *found.notes)]
        return failure(job, entry, replace(seen[-1], step=Step.IDENTIFY), Remark(Failure.NO_MODE, {"why": why}), checks)
    missing = [note for note in found.notes if note.code is Note.NO_SPRINGS]
    if missing:
        rows = failure(job, entry, seen[-1], Remark(Failure.NO_SPRINGS, {"why": missing[0].numbers["why"]}))
        return replace(rows, modes=modes)
    return Rows(modes=modes, springs=springs)


def _mode_rows(job: Job, entry: Entry, seen: Seen, found: Analysis) -> tuple[Row, ...]:
    modes, single = found.modes, found.identification
    if not len(modes):
        return ()
    signal = as_signal(held(single, "response"))
    certain = modes.wn_std is None or modes.zeta_std is None
    ends = None if certain else modes.interval(job.settings.level)
    # Those of one decay are not those of the joint modes.
    alone = found.repeats is None
    shapes = modes.shapes
    assert shapes is not None
    shared = {
        **which(job, entry, seen),
        "modes": len(modes),
        "explained_least": float(np.min(single.explained)),
        "decays": len(found.used),
        "start_s": float(signal.start),
        "samples": signal.values.shape[1],
        "rate_hz": 1 / signal.step,
        "channels": [printable(name) for name in signal.channels],
        "explained": single.explained.tolist(),
        "noise_std": single.noise_std.tolist(),
        **_said(found),
    }
    columns: dict[str, Iterable[object]] = {
        "mode": range(1, len(modes) + 1),
        "kind": modes.kinds,
        "shape_real": shapes.T.real.tolist(),
        "shape_imag": shapes.T.imag.tolist(),
    }
    numbers = {
        "f_hz": modes.wn / (2 * np.pi),
        "wn_rad_per_s": modes.wn,
        "wn_std_rad_per_s": modes.wn_std,
        "wn_low_rad_per_s": None if ends is None else ends.wn[:, 0],
        "wn_high_rad_per_s": None if ends is None else ends.wn[:, 1],
        "zeta": modes.zeta,
        "zeta_std": modes.zeta_std,
        "zeta_low": None if ends is None else ends.zeta[:, 0],
        "zeta_high": None if ends is None else ends.zeta[:, 1],
        "pole_real_rad_per_s": modes.poles.real,
        "pole_imag_rad_per_s": modes.poles.imag,
        "collinearity": single.collinearity if alone else None,
        "loudness": (found.repeats or single).loudness,
        "halves_apart": single.halves if alone else None,
    }
    columns |= {name: [None] * len(modes) if one is None else one.tolist() for name, one in numbers.items()}
    return tuple(shared | dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True))


def _said(found: Analysis) -> dict[str, object]:
    """Return the verdict, the codes of what was doubted, found and done, and all of it in words."""
    verdict, findings = found.verdict, found.cleaned.findings
    sentences = dict.fromkeys([*map(str, verdict.doubts), *map(str, findings), *map(str, found.notes)])
    return {
        "verdict": verdict.level.label,
        **doubts_of(verdict),
        "findings": list(dict.fromkeys(str(one.kind) for one in findings)),
        "notes": list(dict.fromkeys(str(one.code) for one in found.notes)),
        "remarks": printable("; ".join(sentences)),
    }


def _spring_rows(job: Job, entry: Entry, seen: Seen, found: Analysis) -> tuple[Row, ...]:
    car = found.reconstruction
    if car is None:
        return ()
    content = reconstruction_to_dict(car, level=job.settings.level)
    shared = {
        "explains": car.explains,
        "chi_square": car.chi_square,
        "freedom": car.freedom,
        "residual": float(car.residual),
        "alternatives": len(car.alternatives),
        "status": printable(car.status),
    }
    rows: list[Row] = []
    for key in ("parameters", "held"):
        entries = content[key]
        assert isinstance(entries, list)
        rows += [
            {
                **which(job, entry, seen),
                "parameter": one["name"],
                "unit": one["unit"],
                "value": one["value"],
                "std": one.get("std"),
                "low": one.get("lower"),
                "high": one.get("upper"),
                "held": key == "held",
                **shared,
            }
            for one in entries
        ]
    return tuple(rows)
