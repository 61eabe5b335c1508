"""Tables of an identification, and of several joined, as text."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.files import printable
from suspid.identification.nonlinear import AmplitudeDependence
from suspid.samples import held
from suspid.signals import as_signal
from suspid.text_tables import COLUMN_GAP, NOTHING, TERMINAL, sentence_table, text_table
from suspid.wavelets import Ridge
from suspid.wording import WayOut

if TYPE_CHECKING:
    from suspid.identification.identification import Identification
    from suspid.identification.repeats import Repeats


# Where the poles, and the channels, are that a table has no room for.
WHERE_ALL_ARE = WayOut(" in .considered", "modes", "; --json FILE has all", "")
WHERE_CHANNELS_ARE = WayOut(" in .explained and .noise_std", "modes", "; --json FILE has all", "")
# Channels in a table: with the tables of the modes they fill a screen.
MOST_CHANNELS_LISTED = 24


def tables_of(found: Identification) -> str:
    """Return the tables of modes, quality, channels and rejected poles, without the verdict."""
    parts = []
    if len(found.modes):
        quality = {
            "mode": [str(i + 1) for i in range(len(found.modes))],
            "phase collinearity": [f"{value:.3f}" for value in found.collinearity],
            "disagreement of halves [sd]": [f"{value:.1f}" for value in found.halves],
            "residual / noise": [f"{value:.3g}" for value in found.loudness],
        }
        parts += [str(found.modes), text_table(quality, widest=TERMINAL)]
    else:
        parts.append("no mode")
    varying = [(mode, each) for mode, each in enumerate(found.amplitude_dependence, 1) if each.varies]
    parts += [text_table(_amplitude_columns(mode, each), widest=TERMINAL) for mode, each in varying]
    if found.method == "ridge":
        parts.append(text_table(_ridge_columns(found.ridges)))
    names = as_signal(held(found, "response")).channels
    channels = {
        "channel": names,
        "explained": [f"{100 * share:.2f} %" for share in found.explained],
        "noise std": [f"{std:.3g}" for std in found.noise_std],
        "lag-1 correlation": [f"{value:+.2f}" for value in found.whiteness],
    }
    first = {heading: cells[:MOST_CHANNELS_LISTED] for heading, cells in channels.items()}
    more = len(names) - MOST_CHANNELS_LISTED
    parts.append(text_table(first, widest=TERMINAL) + (f"\n… and {more} more{WHERE_CHANNELS_ARE}" if more > 0 else ""))
    if found.considered:
        # Rejected poles that the table shows; the rest is counted.
        shown = found.considered[:6]
        others = {
            "rejected: wn [rad/s]": [f"{abs(c.pole):.5g}" for c in shown],
            "zeta [1]": [f"{-c.pole.real / max(abs(c.pole), 1e-300):.3g}" for c in shown],
        }
        width = TERMINAL - len(text_table(others).partition("\n")[0]) - COLUMN_GAP
        table = sentence_table(others, "why", [[c.reason] for c in shown], width)
        more = len(found.considered) - len(shown)
        parts.append(table + (f"\n… and {more} more{WHERE_ALL_ARE}" if more else ""))
    return "\n\n".join(parts)


def tables_of_repeats(found: Repeats) -> str:
    """Return the tables of joint modes, agreement and single decays, without the verdict."""
    spans = [f"{start:.6g} … {stop:.6g} s" for start, stop in found.spans]
    singles = text_table(
        {
            **({"record": list(found.names)} if found.names else {}),
            "decay": spans,
            "f [Hz]": [", ".join(f"{wn / (2 * np.pi):.4g}" for wn in one.modes.wn) for one in found.each],
            "zeta [1]": [", ".join(f"{zeta:.3g}" for zeta in one.modes.zeta) for one in found.each],
        },
        widest=TERMINAL,
    )
    if not len(found.modes):
        return f"no mode in all of {len(found.spans)} decays\n\n{singles}"
    agreement = {
        "mode": [str(i + 1) for i in range(len(found.modes))],
        "disagreement, chi-square": [f"{a.chi_square:.1f}" if a.freedom else NOTHING for a in found.consistency],
        "degrees of freedom": [str(a.freedom or NOTHING) for a in found.consistency],
        "probability": [f"{a.probability:.2g}" if a.freedom else NOTHING for a in found.consistency],
        "residual / noise": [f"{value:.3g}" for value in found.loudness],
    }
    return f"{found.modes}\n\n{text_table(agreement, widest=TERMINAL)}\n\n{singles}"


def _amplitude_columns(mode: int, each: AmplitudeDependence) -> dict[str, list[str]]:
    return {
        f"mode {mode}: amplitude in {printable(each.channel)}": [f"{value:.3g}" for value in each.amplitude],
        "f [Hz]": [f"{value:.5g}" for value in each.wn / (2 * np.pi)],
        "±": [f"{value:.2g}" for value in each.wn_std / (2 * np.pi)],
        "zeta [1]": [f"{value:.3g}" for value in each.zeta],
        "± ": [f"{value:.2g}" for value in each.zeta_std],
    }


def _ridge_columns(ridges: tuple[Ridge, ...]) -> dict[str, list[str]]:
    return {
        "ridge [rad/s]": [f"{ridge.omega:.5g}" for ridge in ridges],
        "N": [f"{ridge.wavelet.bandwidth:.3g}" for ridge in ridges],
        "from [s]": [f"{ridge.window.start:.3g}" for ridge in ridges],
        "to [s]": [f"{ridge.window.stop:.3g}" for ridge in ridges],
        "ends at": [ridge.window.reason for ridge in ridges],
    }
