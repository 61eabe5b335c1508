"""An identification as JSON: the modes with the record, the settings, the noise and the windows of the ridges."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from suspid.errors import InputError
from suspid.identification.common_amplitude import Described
from suspid.identification.identification import Identification
from suspid.identification.modes_json import modes_from_dict, modes_to_dict, number_of
from suspid.identification.nonlinear import AmplitudeDependence
from suspid.identification.repeats import Repeats
from suspid.samples import held
from suspid.signals import Signal, as_signal
from suspid.units import RadianPerSecond
from suspid.values import frozen_real

# Radians that a mode may turn in a window of a table.
MOST_TURNS = 1e9


def amplitudes_to_dict(each: AmplitudeDependence) -> dict[str, object]:
    """Return how a mode depends on its amplitude."""
    return {
        "channel": each.channel,
        "holds_at": each.holds_at,
        "start_s": [start for start, _ in each.spans],
        "stop_s": [stop for _, stop in each.spans],
        "amplitude": each.amplitude.tolist(),
        "frequency_hz": (each.wn / (2 * np.pi)).tolist(),
        "wn_rad_per_s": each.wn.tolist(),
        "wn_std_rad_per_s": each.wn_std.tolist(),
        "zeta": each.zeta.tolist(),
        "zeta_std": each.zeta_std.tolist(),
    }


def described_from_dict(content: Mapping[str, object]) -> Described:
    """Return the modes of a file, and how each depends on its amplitude, where that is in it.

    Raises
    ------
    InputError
        If something is not as `identification_to_dict` wrote it.

    Examples
    --------
    >>> described_from_dict({"modes": [{"frequency_hz": 2.0, "zeta": 0.3}]}).tables
    (None,)
    """
    modes = modes_from_dict(content)
    entries = content.get("amplitude_dependence") or []
    if not isinstance(entries, list) or len(entries) not in (0, len(modes)):
        raise InputError(f"amplitude_dependence must be a list with a table or null for each of {len(modes)} modes")
    wn = modes.wn.tolist()
    tables = [None if entry is None else _table(k, entry, wn[k - 1]) for k, entry in enumerate(entries, start=1)]
    return Described(modes=modes, tables=tuple(tables or [None] * len(modes)))


def _table(mode: int, entry: object, near: RadianPerSecond) -> AmplitudeDependence:
    names = ("start_s", "stop_s", "amplitude", "wn_rad_per_s", "wn_std_rad_per_s", "zeta", "zeta_std")
    where = f"amplitude_dependence of mode {mode}"
    if not isinstance(entry, dict):
        raise InputError(f"{where} must be an object with channel, holds_at, {', '.join(names)}")
    columns = [column for name in names if isinstance(column := entry.get(name), list)]
    if len(columns) < len(names) or len({len(column) for column in columns}) > 1:
        raise InputError(f"{where}: {', '.join(names)} must be lists of one length")
    # A window in which something was not found has null there.
    rows = [row for row in zip(*columns, strict=True) if None not in row]
    values = np.array([[number_of(where, value) for value in row] for row in rows]).reshape(-1, len(names))
    start, stop, amplitude, wn, wn_std, zeta, zeta_std = values.T
    if not len(values) or np.min([amplitude, wn, stop - start]) <= 0 or np.min([wn_std, zeta_std]) < 0:
        raise InputError(
            f"{where}: a window at least, each with its stop after its start, amplitudes and wn above 0, standard "
            f"deviations not below 0"
        )
    if np.max(np.abs(np.log2(wn / near))) > 1 or np.max(np.abs(zeta)) >= 1 or np.max(wn * (stop - start)) > MOST_TURNS:
        raise InputError(
            f"{where}: wn must lie within half and twice that of its mode, {near:.6g} rad/s, zeta between -1 and 1, "
            f"and a window last at most {MOST_TURNS:g} / wn"
        )
    if not isinstance(entry.get("channel"), str):
        raise InputError(f"{where}: channel must be a name")
    return AmplitudeDependence(
        spans=tuple(zip(start.tolist(), stop.tolist(), strict=True)),
        channel=entry["channel"],
        amplitude=frozen_real(amplitude),
        wn=frozen_real(wn),
        zeta=frozen_real(zeta),
        wn_std=frozen_real(wn_std),
        zeta_std=frozen_real(zeta_std),
        holds_at=number_of(f"{where}: holds_at", entry.get("holds_at")),
    )


def repeats_to_dict(repeats: Repeats) -> dict[str, object]:
    """Return the modes that several decays share, each with its dependence on the amplitude or null."""
    tables = [None if each is None else amplitudes_to_dict(each) for each in repeats.amplitude_dependence]
    return {**modes_to_dict(repeats.modes), "amplitude_dependence": tables}


def identification_to_dict(identification: Identification, *, file: str, warnings: Sequence[str]) -> dict[str, object]:
    """Return the modes with the record, the settings, the noise and the windows of the ridges."""
    from importlib.metadata import version

    signal = as_signal(held(identification, "response"))
    return {
        **modes_to_dict(identification.modes),
        "record": {
            "file": file,
            "channels": list(signal.channels),
            "samples": signal.values.shape[1],
            "rate_hz": 1 / signal.step,
            "start_s": signal.start,
        },
        "method": identification.method,
        "forces": [
            {
                "kind": force.kind.value,
                "channel": signal.channels[force.channel],
                "relative_to": _name(signal, force.other),
            }
            for force in identification.forces
        ],
        "amplitude_dependence": [amplitudes_to_dict(each) for each in identification.amplitude_dependence],
        "considered": [
            {
                "pole_rad_per_s": [c.pole.real, c.pole.imag],
                "frequency_hz": abs(c.pole) / (2 * np.pi),
                "wn_rad_per_s": abs(c.pole),
                "zeta": -c.pole.real / abs(c.pole) if c.pole else 0.0,
                "reason": c.reason,
                "remark": c.remark.to_dict(),
                "removed": c.removed,
            }
            for c in identification.considered
        ],
        "noise_std": identification.noise_std.tolist(),
        "explained": identification.explained.tolist(),
        "ridges": [
            {
                "wn_rad_per_s": float(ridge.omega),
                "bandwidth": float(ridge.wavelet.bandwidth),
                "start_s": float(ridge.window.start),
                "stop_s": float(ridge.window.stop),
                "ends_at": ridge.window.reason,
            }
            for ridge in identification.ridges
        ],
        "warnings": list(warnings),
        "suspid": version("suspid"),
    }


def _name(signal: Signal, channel: int | None) -> str | None:
    return None if channel is None else signal.channels[channel]
