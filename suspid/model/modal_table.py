"""Modes as a table of text."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.text_tables import TERMINAL, rounded, spread, text_table

if TYPE_CHECKING:
    from suspid.model.modes import ModalSet


def modal_table(modes: ModalSet) -> str:
    """Return the table that ``str(modes)`` shows: one row per mode, with units."""
    kinds = np.array(modes.kinds)
    # What follows from the kind of a pole is not estimated: the ratio of a single one, the frequency of one at zero.
    wn_std = None if modes.wn_std is None else np.where(kinds == "rigid", np.nan, modes.wn_std)
    zeta_std = None if modes.zeta_std is None else np.where(kinds == "pair", modes.zeta_std, np.nan)
    columns: dict[str, list[str]] = {
        "mode": [str(i + 1) for i in range(len(modes))],
        "f [Hz]": rounded(modes.wn / (2 * np.pi), wn_std, 1 / (2 * np.pi)),
        "wn [rad/s]": rounded(modes.wn, wn_std),
    }
    if wn_std is not None:
        columns["±"] = [spread(s) for s in wn_std.tolist()]
    columns["zeta [1]"] = rounded(modes.zeta, zeta_std)
    if zeta_std is not None:
        columns[" ±"] = [spread(s) for s in zeta_std.tolist()]
    if set(modes.kinds) - {"pair"}:
        names = {"pair": "", "real": "one real pole", "rigid": "pole at zero"}
        columns["kind"] = [names[kind] for kind in modes.kinds]
    return text_table(columns, widest=TERMINAL)
