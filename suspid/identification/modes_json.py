"""Modes as JSON: what `write_modes` and ``suspid identify --json`` write, `read_modes` and ``suspid reconstruct`` read.

An object with

- ``format``: ``"suspid modes 1"``;
- ``modes``: a list, ascending in frequency, of objects with

  - ``frequency_hz``, ``wn_rad_per_s``, ``zeta``: natural frequency in both units, and damping ratio [1];
  - ``wn_std_rad_per_s``, ``zeta_std``: standard deviations, or null for exact modes;
  - ``pole_rad_per_s``: real and imaginary part;
  - ``shape``: real and imaginary part at each channel, in the order of ``channels``, or null;

- ``channels``: names of the channels of the shapes;
- ``covariance``: joint covariance of Re and Im of each pole [rad/s] and, in a larger matrix, of Re and Im of the
  shapes, mode by mode and channel by channel; or null.

The command adds ``record`` (file, channels, samples, ``rate_hz``, ``start_s``), ``method``, ``forces`` (other than
linear ones) and ``amplitude_dependence`` of each mode, both empty for a linear decay, ``considered`` (poles that are no
modes, each with the reason), ``noise_std`` and ``explained`` by channel of the record, ``ridges`` with the window of
each (``start_s``, ``stop_s``, ``ends_at``), ``warnings``, and the version as ``suspid``.

A file written by hand, in JSON or TOML, needs ``modes`` alone, each with ``zeta`` and ``wn_rad_per_s`` or
``frequency_hz``, and with both standard deviations or neither.
"""

from __future__ import annotations

import json
import math
import os
import reprlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from suspid.arguments import explained
from suspid.errors import InputError
from suspid.files import naming, parsed_json, printable, read_text, replacing
from suspid.levels import SEVEN_DIGITS
from suspid.model import ModalSet, check_definite
from suspid.results import check_kind
from suspid.toml import parsed_toml
from suspid.values import LARGEST_SIZE, SMALLEST_SIZE, nearest_names

MODES_FORMAT = "suspid modes 1"
MODE_KEYS = ("frequency_hz", "wn_rad_per_s", "zeta", "wn_std_rad_per_s", "zeta_std", "pole_rad_per_s", "shape")


def modes_to_dict(modes: ModalSet) -> dict[str, object]:
    """Return the modes as plain lists and numbers, every bit kept.

    Examples
    --------
    >>> modes_to_dict(ModalSet.from_wn_zeta([10.0], [0.6]))["modes"][0]["pole_rad_per_s"]
    [-6.0, 8.0]
    """
    wn_std, zeta_std = modes.wn_std, modes.zeta_std
    entries: list[dict[str, object]] = [
        {
            "frequency_hz": float(modes.wn[k] / (2 * np.pi)),
            "wn_rad_per_s": float(modes.wn[k]),
            "zeta": float(modes.zeta[k]),
            "wn_std_rad_per_s": None if wn_std is None else float(wn_std[k]),
            "zeta_std": None if zeta_std is None else float(zeta_std[k]),
            "pole_rad_per_s": _pair(modes.poles[k]),
            "shape": None if modes.shapes is None else [_pair(value) for value in modes.shapes[:, k]],
        }
        for k in range(len(modes))
    ]
    return {
        "format": MODES_FORMAT,
        "modes": entries,
        "channels": list(modes.channels),
        "covariance": None if modes.covariance is None else modes.covariance.tolist(),
    }


def to_json(content: Mapping[str, object]) -> str:
    """Return the text of a JSON file; numbers that are not finite become null."""
    return json.dumps(_null_if_not_finite(content), indent=1, allow_nan=False) + "\n"


def modes_from_dict(content: Mapping[str, object]) -> ModalSet:
    """Return the modes that were written by `modes_to_dict`, or by hand.

    Examples
    --------
    >>> modes_from_dict({"modes": [{"frequency_hz": 2.0, "zeta": 0.3}]}).zeta
    array([0.3])
    """
    if content.get("format", MODES_FORMAT) != MODES_FORMAT:
        unknown = f"format {reprlib.repr(content['format'])} is not known; known: {MODES_FORMAT!r}"
        raise InputError(f"{unknown}; update suspid, or write the modes again")
    entries = content.get("modes")
    if entries == []:
        raise InputError("no mode was found in this record: modes is empty; use a record with a free decay")
    if not isinstance(entries, list):
        if {"masses", "struts", "quarter_car", "half_car", "full_car"} & set(content):
            raise InputError("is a car, not modes: name the modes first and the car last")
        raise InputError(
            f"modes is missing; write it with write_modes or suspid identify --json, or give a list of "
            f"objects with {', '.join(MODE_KEYS[:3])}"
        )
    found, shapes, stds = zip(*[_mode(f"mode {k}", entry) for k, entry in enumerate(entries, start=1)], strict=True)
    channels = content.get("channels") or ()
    if not isinstance(channels, (list, tuple)) or not all(isinstance(name, str) for name in channels):
        raise InputError(f"channels = {reprlib.repr(channels)} must be a list of names")
    if len({None if shape is None else len(shape) for shape in shapes}) > 1:
        raise InputError("some modes have no shape, or one of another length; give all modes shapes of one length")
    if any(std is None for std in stds) and any(std is not None for std in stds):
        raise InputError("some modes have no standard deviations; give them for all modes or for none")
    poles = np.array(found)
    covariance = content.get("covariance")
    if covariance is not None:
        covariance = np.array(_numbers("covariance", covariance))
        check_definite(covariance)
    elif stds[0] is not None:
        if np.any(poles.imag <= 0):
            raise InputError("standard deviations of an overdamped mode can only be given as covariance")
        covariance = np.zeros((2 * len(poles), 2 * len(poles)))
        for k, (pole, (wn_std, zeta_std)) in enumerate(zip(found, stds, strict=True)):
            alone = ModalSet.from_wn_zeta([abs(pole)], [-pole.real / abs(pole)], wn_std=[wn_std], zeta_std=[zeta_std])
            covariance[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] = alone.covariance
    shape = None if shapes[0] is None else np.array(shapes).T
    return ModalSet(poles=poles, shapes=shape, channels=channels, covariance=covariance)


def read_content(path: Path) -> dict[str, Any]:
    """Return what a JSON or TOML file holds.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "modes.toml")
    ...     _ = path.write_text("zeta = 0.3")
    ...     read_content(path)
    {'zeta': 0.3}
    """
    text = read_text(path)
    return parsed_toml(text) if path.suffix.lower() == ".toml" else parsed_json(text)


@explained
def read_modes(path: str | os.PathLike[str]) -> ModalSet:
    r"""Return the modes in a file that `write_modes` or ``suspid identify --json`` wrote, or that was written by hand.

    Parameters
    ----------
    path : path
        A JSON or TOML file. Written by hand it needs ``modes``, each with ``zeta`` and ``wn_rad_per_s`` or
        ``frequency_hz``, and perhaps ``wn_std_rad_per_s`` and ``zeta_std``.

    Returns
    -------
    ModalSet
        The modes with shapes and covariance, where the file has them.

    Raises
    ------
    InputError
        If the file cannot be read or used; it begins with the name of the file.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "modes.toml")
    ...     _ = path.write_text("[[modes]]\nfrequency_hz = 2.0\nzeta = 0.3\n")
    ...     modes = read_modes(path)
    >>> modes.zeta
    array([0.3])
    """
    file = Path(path)
    with naming(file):
        return modes_from_dict(read_content(file))


@explained
def write_modes(modes: ModalSet, path: str | os.PathLike[str]) -> None:
    """Write modes as JSON, every bit kept: frequencies, damping ratios, poles, shapes and covariance.

    Parameters
    ----------
    modes : ModalSet
        The modes, such as ``identify(record).modes``.
    path : path
        The file, by custom ``.json``; `read_modes` and the commands read it.

    Raises
    ------
    InputError
        If the file cannot be written, or its suffix is one of TOML.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "modes.json")
    ...     write_modes(ModalSet.from_wn_zeta([10.0], [0.6]), path)
    ...     again = read_modes(path)
    >>> again.poles
    array([-6.+8.j])
    """
    check_kind(modes, {"ModalSet": "eigenmodes, or identify as .modes,"})
    if Path(path).suffix.lower() == ".toml":
        raise InputError("modes are written as JSON; name the file .json").about(printable(str(path)))
    with replacing(path) as draft:
        draft.write_text(to_json(modes_to_dict(modes)), encoding="utf-8")


def _mode(where: str, entry: object) -> tuple[complex, list[complex] | None, tuple[float, float] | None]:
    """Return pole, shape, and standard deviations of wn and zeta."""
    if not isinstance(entry, dict):
        raise InputError(f"{where} must be an object with {', '.join(MODE_KEYS[:3])}, not {reprlib.repr(entry)}")
    for key in entry:
        if key not in MODE_KEYS:
            raise InputError(f"{where} has the unknown key {key!r}.{nearest_names(key, MODE_KEYS)}")
    given = {key: number_of(f"{where}: {key}", entry[key]) for key in MODE_KEYS[:5] if entry.get(key) is not None}
    if entry.get("pole_rad_per_s") is not None:
        pole = _complex(f"{where}: pole_rad_per_s", entry["pole_rad_per_s"])
    else:
        wn = given.get("wn_rad_per_s", given.get("frequency_hz", 0.0) * 2 * np.pi)
        if "zeta" not in given or not ("wn_rad_per_s" in given or "frequency_hz" in given):
            raise InputError(f"{where} needs zeta, and wn_rad_per_s or frequency_hz")
        if not SMALLEST_SIZE <= wn <= LARGEST_SIZE or not abs(given["zeta"]) < 1:
            raise InputError(
                f"{where}: {wn = :g} rad/s must lie from {SMALLEST_SIZE:g} to {LARGEST_SIZE:g}, "
                f"zeta = {given['zeta']:g} between -1 and 1 (a ratio: 30 % is 0.3)"
            )
        pole = complex(ModalSet.from_wn_zeta([wn], [given["zeta"]]).poles[0])
    if pole and not SMALLEST_SIZE <= abs(pole) <= LARGEST_SIZE:
        raise InputError(f"{where}: the pole {pole:g} rad/s must lie from {SMALLEST_SIZE:g} to {LARGEST_SIZE:g}")
    alone = ModalSet(poles=np.array([pole]))
    means = {"frequency_hz": alone.wn[0] / (2 * np.pi), "wn_rad_per_s": alone.wn[0], "zeta": alone.zeta[0]}
    for key, meant in means.items():
        if not math.isclose(given.get(key, meant), meant, rel_tol=SEVEN_DIGITS, abs_tol=SEVEN_DIGITS):
            raise InputError(f"{where}: {key} = {given[key]:g} contradicts the other keys, which give {meant:.9g}")
    stds = [given.get(key) for key in MODE_KEYS[3:5]]
    if (stds[0] is None) != (stds[1] is None):
        raise InputError(f"{where}: give both wn_std_rad_per_s and zeta_std, or neither")
    shape = entry.get("shape")
    if shape is not None and (not isinstance(shape, list) or not shape):
        raise InputError(f"{where}: shape must be a list with real and imaginary part at each channel")
    return (
        pole,
        None if shape is None else [_complex(f"{where}: shape", value) for value in shape],
        None if stds[0] is None or stds[1] is None else (stds[0], stds[1]),
    )


def _pair(value: complex) -> list[float]:
    return [float(value.real), float(value.imag)]


def number_of(what: str, value: object) -> float:
    """Return a finite number of a file.

    Examples
    --------
    >>> number_of("mode 1: zeta", 0.1)
    0.1
    """
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise InputError(f"{what} = {reprlib.repr(value)} must be a number")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise InputError(f"{what} must be finite")
    if abs(number) > LARGEST_SIZE:
        raise InputError(f"{what} = {number:g} is beyond {LARGEST_SIZE:g}")
    return number


def _complex(what: str, value: object) -> complex:
    if not isinstance(value, list) or len(value) != 2:
        raise InputError(f"{what} = {reprlib.repr(value)} must be a real and an imaginary part")
    return complex(number_of(what, value[0]), number_of(what, value[1]))


def _numbers(what: str, rows: object) -> list[list[float]]:
    if not isinstance(rows, list) or not all(isinstance(row, list) and len(row) == len(rows) for row in rows):
        raise InputError(f"{what} must be a square list of lists of numbers")
    return [[number_of(what, value) for value in row] for row in rows]


def _null_if_not_finite(content: object) -> object:
    if isinstance(content, dict):
        return {key: _null_if_not_finite(value) for key, value in content.items()}
    if isinstance(content, list):
        return [_null_if_not_finite(value) for value in content]
    return None if isinstance(content, float) and not math.isfinite(content) else content
