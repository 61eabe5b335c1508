"""Modes as a table of text."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.text_tables import TERMINAL, rounded, spread, text_table

if TYPE_CHECKING:
    from suspid.model.modes import ModalSet


def modal_table(modes: ModalSet) -> str:
    """Return the table that ``str(modes)`` shows: one row per mode, with units."""
    columns: dict[str, list[str]] = {
        "mode": [str(i + 1) for i in range(len(modes))],
        "f [Hz]": rounded(modes.wn / (2 * np.pi), modes.wn_std, 1 / (2 * np.pi)),
        "wn [rad/s]": rounded(modes.wn, modes.wn_std),
    }
    if modes.wn_std is not None:
        columns["±"] = [spread(s) for s in modes.wn_std]
    columns["zeta [1]"] = rounded(modes.zeta, modes.zeta_std)
    if modes.zeta_std is not None:
        columns[" ±"] = [spread(s) for s in modes.zeta_std]
    if set(modes.kinds) - {"pair"}:
        names = {"pair": "", "real": "one real pole", "rigid": "pole at zero"}
        columns["kind"] = [names[kind] for kind in modes.kinds]
    return text_table(columns, widest=TERMINAL)
