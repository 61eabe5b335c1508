"""An identification as JSON: the modes with the record, the settings, the noise and the windows of the ridges."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from suspid.identification.identification import Identification
from suspid.identification.modes_json import modes_to_dict
from suspid.samples import held
from suspid.signals import Signal, as_signal


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
        "amplitude_dependence": [
            {
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
            for each in identification.amplitude_dependence
        ],
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
