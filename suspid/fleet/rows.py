"""One record of a fleet as rows of the tables: modes, springs, or the reason why there are none."""

from __future__ import annotations

import hashlib
import tempfile
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from suspid.cleaning import read_record
from suspid.errors import InputError, RecordWarning, SuspidError
from suspid.files import printable
from suspid.fleet.manifest import environment
from suspid.fleet.parts import Row, Rows
from suspid.fleet.records import Entry
from suspid.identification import Identification, Method, identify
from suspid.model import car_from_toml
from suspid.reconstruction import ModalTest, compiled, reconstruct, reconstruction_to_dict
from suspid.signals import as_response, as_signal, cut
from suspid.units import Hertz, RadianPerSecond, Ratio, Second

if TYPE_CHECKING:
    import control

LEVEL = 0.95
LONGEST_REASON = 600


@dataclass(frozen=True, kw_only=True, slots=True)
class Job:
    """What is done with every record: the settings of `identify_many`, as plain values that travel.

    ``environment`` holds the versions of the client, which those of every worker must equal.
    """

    channels: tuple[str, ...] | None = None
    time: str | None = None
    fs: Hertz | None = None
    dbc: str | None = None
    start: Second | None = None
    stop: Second | None = None
    modes: int | None = None
    method: Method = "likelihood"
    band: tuple[RadianPerSecond, RadianPerSecond] | None = None
    bandwidth: float | None = None
    candidates: tuple[float, ...] = ()
    car: str | None = None
    fixed: tuple[str, ...] = ()
    bounds: tuple[tuple[str, float | None, float | None], ...] = ()
    ties: tuple[tuple[str, ...], ...] = ()
    nominal_std: float | tuple[tuple[str, float], ...] | None = None
    free_masses: tuple[str, ...] = ()
    added_masses: tuple[tuple[str, float], ...] = ()
    tolerance: Ratio | None = None
    search: bool = True
    halves: bool = False
    time_limit: Second | None = None
    environment: Mapping[str, str] = field(default_factory=environment)

    def settings(self) -> dict[str, object]:
        """Return what decides the results, for the manifest."""
        return asdict(self)


def record_rows(job: Job, entry: Entry, seen: dict[str, str]) -> Rows:
    """Return the rows of one record; what goes wrong becomes a row among the failures.

    Parameters
    ----------
    job : Job
        What to do.
    entry : Entry
        The record.
    seen : dict
        Takes the record's ``sha256`` and ``place`` as soon as they are known, whatever happens then.
    """
    step = "read"
    try:
        response, findings = _read(job, entry, seen)
        if job.start is not None or job.stop is not None:
            response = cut(response, start=job.start, stop=job.stop)
        step = "identify"
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = identify(
                response,
                modes=job.modes,
                method=job.method,
                band=job.band,
                bandwidth=job.bandwidth,
                candidates=job.candidates,
            )
            modes = _mode_rows(job, entry, seen["sha256"], found, findings)
    except Exception as error:
        return failure(entry, seen.get("sha256"), job, step, type(error).__name__, _reason(error, seen))
    if not modes:
        return failure(entry, seen["sha256"], job, step, "NoMode", str(found).splitlines()[0])
    if job.car is None:
        return Rows(modes=modes)
    try:
        return Rows(modes=modes, springs=_spring_rows(job, entry, seen["sha256"], found))
    except Exception as error:
        reason = _reason(error, seen)
        rows = failure(entry, seen["sha256"], job, "reconstruct", type(error).__name__, reason)
        return replace(rows, modes=modes)


def _read(job: Job, entry: Entry, seen: dict[str, str]) -> tuple[control.TimeResponseData, str]:
    """Return the record and what was found in reading it; note its hash as soon as it is known."""
    if entry.refusal:
        raise InputError(entry.refusal)
    if entry.samples is not None:
        seen["sha256"] = samples_hash(entry)
        samples = entry.samples
        response = as_response(samples.timepts, samples.values, samples.channels, title=entry.name)
        if job.channels:
            raise InputError("channels are chosen when files are read; give responses with the channels to use")
        return response, ""
    assert entry.path is not None
    with warnings.catch_warnings(record=True) as caught, _at_hand(entry.path) as path:
        warnings.simplefilter("ignore")
        warnings.simplefilter("always", RecordWarning)
        seen["place"] = str(path)
        if path.is_file():
            with path.open("rb") as stream:
                seen["sha256"] = hashlib.file_digest(stream, "sha256").hexdigest()
            size = path.stat().st_size
            if entry.size is not None and size != entry.size:
                raise InputError(f"changed since it was listed: from {entry.size} to {size} bytes")
        response = read_record(path, channels=job.channels, time=job.time, fs=job.fs, dbc=job.dbc)
        said = dict.fromkeys(_without(str(one.message), seen["place"]) for one in caught)
    return response, "; ".join(said)


@contextmanager
def _at_hand(address: str) -> Iterator[Path]:
    """Give a file of this machine: the one named, or a copy of one elsewhere."""
    if "://" not in address:
        yield Path(address)
        return
    import fsspec

    with tempfile.TemporaryDirectory(prefix="suspid-") as folder:
        files, place = fsspec.core.url_to_fs(address)
        copy = Path(folder, Path(place).name)
        try:
            files.get_file(place, str(copy))
        except FileNotFoundError:
            raise InputError("there is no such file") from None
        yield copy


def samples_hash(entry: Entry) -> str:
    """Return the sha256 of a response: its channels, times and samples."""
    assert entry.samples is not None
    content = hashlib.sha256("\n".join(entry.samples.channels).encode("utf-8", "surrogatepass"))
    for array in (entry.samples.timepts, entry.samples.values):
        content.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
    return content.hexdigest()


def _mode_rows(job: Job, entry: Entry, digest: str, found: Identification, findings: str) -> tuple[Row, ...]:
    modes, signal = found.modes, as_signal(found.response)
    if not len(modes):
        return ()
    nothing = [None] * len(modes)
    certain = modes.wn_std is None or modes.zeta_std is None
    ends = None if certain else modes.interval(LEVEL)
    explained, collinearity = found.explained, found.collinearity
    halves = found.halves.tolist() if job.halves else nothing
    shapes = modes.shapes
    assert shapes is not None
    return tuple(
        {
            **_which(entry, digest, job),
            "mode": k + 1,
            "modes": len(modes),
            "kind": modes.kinds[k],
            "f_hz": float(modes.wn[k] / (2 * np.pi)),
            "wn_rad_per_s": float(modes.wn[k]),
            "wn_std_rad_per_s": None if modes.wn_std is None else float(modes.wn_std[k]),
            "wn_low_rad_per_s": None if ends is None else float(ends.wn[k, 0]),
            "wn_high_rad_per_s": None if ends is None else float(ends.wn[k, 1]),
            "zeta": float(modes.zeta[k]),
            "zeta_std": None if modes.zeta_std is None else float(modes.zeta_std[k]),
            "zeta_low": None if ends is None else float(ends.zeta[k, 0]),
            "zeta_high": None if ends is None else float(ends.zeta[k, 1]),
            "pole_real_rad_per_s": float(modes.poles[k].real),
            "pole_imag_rad_per_s": float(modes.poles[k].imag),
            "collinearity": float(collinearity[k]),
            "loudness": float(found.loudness[k]),
            "halves_apart": halves[k],
            "explained_least": float(np.min(explained)),
            "samples": signal.values.shape[1],
            "rate_hz": 1 / signal.step,
            "channels": [printable(name) for name in signal.channels],
            "explained": explained.tolist(),
            "noise_std": found.noise_std.tolist(),
            "shape_real": shapes[:, k].real.tolist(),
            "shape_imag": shapes[:, k].imag.tolist(),
            "findings": printable(findings),
        }
        for k in range(len(modes))
    )


def _spring_rows(job: Job, entry: Entry, digest: str, found: Identification) -> tuple[Row, ...]:
    assert job.car is not None
    # A solver keeps what it met before; the bytes of a record's rows must not depend on the records before it.
    compiled.cache_clear()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        nominal_std = dict(job.nominal_std) if isinstance(job.nominal_std, tuple) else job.nominal_std
        car = reconstruct(
            [ModalTest(modes=found.modes, added_masses=dict(job.added_masses))],
            car_from_toml(job.car),
            fixed=job.fixed,
            bounds={name: (low, high) for name, low, high in job.bounds},
            ties=job.ties,
            nominal_std=nominal_std,
            free_masses=job.free_masses,
            tolerance=job.tolerance,
            search=job.search,
        )
    content = reconstruction_to_dict(car, level=LEVEL)
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
                **_which(entry, digest, job),
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


def _which(entry: Entry, digest: str | None, job: Job) -> dict[str, object]:
    return {"record": entry.name, "sha256": digest, "suspid": job.environment["suspid"]}


def failure(entry: Entry, digest: str | None, job: Job, step: str, error: str, reason: str) -> Rows:
    """Return the rows of a record that failed: one, with the step, the kind of error and the reason in words."""
    said = printable(" ".join(reason.split()))
    said = said if len(said) <= LONGEST_REASON else said[: LONGEST_REASON - 1] + "…"
    row = {**_which(entry, digest, job), "step": step, "error": error, "reason": said}
    return Rows(failures=(row,), failed=1)


def _reason(error: Exception, seen: Mapping[str, str]) -> str:
    if isinstance(error, MemoryError):
        return "there was not enough memory for this record"
    text = _without(str(error), seen.get("place", ""))
    return text if isinstance(error, SuspidError) else f"{type(error).__name__}: {text}"


def _without(text: str, place: str) -> str:
    """Return a message without the name of the file that it begins with: the row has it, and a copy has another."""
    return text.removeprefix(f"{printable(place)}: ").replace(place, "the file") if place else text
