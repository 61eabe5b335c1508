"""Tables of an identification, and of several joined, as text."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.identification.nonlinear import AmplitudeDependence
from suspid.samples import held
from suspid.signals import as_signal
from suspid.text_tables import COLUMN_GAP, NOTHING, TERMINAL, named, sentence_table, text_table
from suspid.wavelets import Ridge
from suspid.wording import WayOut

if TYPE_CHECKING:
    from suspid.identification.identification import Identification
    from suspid.identification.repeats import Repeats


# Where the rows are that a table has no room for.
WHERE_ALL_ARE = WayOut(" in .details()", "modes", "; --json FILE has all", "")
# Rows of a table that fits a screen beside the others: of channels, of rejected poles, of amplitudes of a mode.
MOST_CHANNELS_LISTED = 24
MOST_REJECTED_LISTED = 6
MOST_AMPLITUDES_LISTED = 5


def tables_of(found: Identification, *, whole: bool = False) -> str:
    """Return the tables of modes, quality, channels and rejected poles: the rows that fit a screen, or the whole."""
    parts = []
    varying = [(mode, each) for mode, each in enumerate(found.amplitude_dependence, 1) if each.varies]
    if len(found.modes):
        quality = {
            "mode": [str(i + 1) for i in range(len(found.modes))],
            "phase collinearity": [f"{value:.3f}" for value in found.collinearity],
            "disagreement of halves [sd]": [f"{value:.1f}" for value in found.halves],
            "residual / noise": [f"{value:.3g}" for value in found.loudness],
        }
        held_at = [
            f"mode {mode}: means over all cycles; the frequency is that at an amplitude of {each.holds_at:.3g} in "
            f"{named(each.channel)}, others are below"
            for mode, each in varying
        ]
        parts += ["\n".join([str(found.modes), *held_at]), text_table(quality, widest=TERMINAL)]
    else:
        parts.append("no mode")
    parts += [_of_amplitudes(mode, each, whole=whole) for mode, each in varying]
    if found.method == "ridge":
        parts.append(text_table(_ridge_columns(found.ridges)))
    names = as_signal(held(found, "response")).channels
    channels = {
        "channel": names,
        "explained": [f"{100 * share:.2f} %" for share in found.explained],
        "noise std": [f"{std:.3g}" for std in found.noise_std],
        "lag-1 correlation": [f"{value:+.2f}" for value in found.whiteness],
    }
    listed = len(names) if whole else MOST_CHANNELS_LISTED
    first = {heading: cells[:listed] for heading, cells in channels.items()}
    parts.append(text_table(first, widest=TERMINAL) + _more(len(names) - listed))
    if found.considered:
        shown = found.considered if whole else found.considered[:MOST_REJECTED_LISTED]
        others = {
            "rejected: wn [rad/s]": [f"{abs(c.pole):.5g}" for c in shown],
            "zeta [1]": [f"{-c.pole.real / max(abs(c.pole), 1e-300):.3g}" for c in shown],
        }
        width = TERMINAL - len(text_table(others).partition("\n")[0]) - COLUMN_GAP
        table = sentence_table(others, "why", [[c.reason] for c in shown], width)
        parts.append(table + _more(len(found.considered) - len(shown)))
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
    varying = [(k, each) for k, each in enumerate(found.amplitude_dependence, 1) if each is not None and each.varies]
    # Of a mode that one decay alone holds, the table of modes has the mean.
    said = ["mean over all cycles; the frequency is that at", "at"]
    held_at = [
        f"mode {k}: {said[len(found.consistency[k - 1].held) > 1]} an amplitude of {each.holds_at:.3g} in "
        f"{named(each.channel)}, others are below"
        for k, each in varying
    ]
    modes = "\n".join([str(found.modes), *held_at])
    parts = [modes, text_table(agreement, widest=TERMINAL), *(_of_amplitudes(*one, whole=False) for one in varying)]
    return "\n\n".join([*parts, singles])


def _more(rows: int) -> str:
    """Return a line that says how many rows a table has no room for, if any."""
    return f"\n… and {rows} more{WHERE_ALL_ARE}" if rows > 0 else ""


def _of_amplitudes(mode: int, each: AmplitudeDependence, *, whole: bool) -> str:
    """Return the table of a mode over its amplitude, of all or of some from the largest to the smallest."""
    columns, count = _amplitude_columns(mode, each), len(each.amplitude)
    rows = np.unique(np.linspace(0, count - 1, count if whole else min(count, MOST_AMPLITUDES_LISTED)).round())
    cells = {heading: [column[int(i)] for i in rows] for heading, column in columns.items()}
    title = next(iter(cells))
    table = text_table(cells)
    if len(table.partition("\n")[0]) > TERMINAL:
        # Of a channel with a long name the title stands above the table.
        table = f"{title}\n{text_table({'amplitude': cells.pop(title), **cells})}"
    return table + _more(count - len(rows))


def _amplitude_columns(mode: int, each: AmplitudeDependence) -> dict[str, list[str]]:
    return {
        f"mode {mode}: amplitude in {named(each.channel)}": [f"{value:.3g}" for value in each.amplitude],
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
