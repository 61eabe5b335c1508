"""The table of a car's dampers after a drive: wear, grip and curve, one line each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from suspid.greybox import DamperCurve
from suspid.performance import Wear
from suspid.text_tables import TERMINAL, rounded, spread, text_table

# What the column of the loss is, where the table above has another change of the damping.
OF_LOSS = "lost: share of the damping, beside that by which load changes a damper and its spring alike"


def damper_table(curves: Sequence[DamperCurve], wear: Wear | None) -> str:
    """Return a line for each damper; empty where nothing was found of any.

    The wear has the loss and its limits, the grip EUSAMA's adhesion and EGEA's least phase of the damper's wheel, the
    curve whether it is a line, its viscous damping of equal work, and friction.
    """
    by_name = {one.name: one for one in curves}
    worn = {} if wear is None else {one.damper: one for one in wear.dampers}
    names = list(dict.fromkeys([*worn, *by_name]))
    if not names:
        return ""
    rows = [
        {"damper": name, **_wear_cells(wear, name), **(_curve_cells(by_name.get(name)) if curves else {})}
        for name in names
    ]
    columns = {title: [row[title] for row in rows] for title in rows[0]}
    table = text_table({title: cells for title, cells in columns.items() if any(cells)}, widest=TERMINAL)
    return table if wear is None else f"{table}\n{OF_LOSS}"


def _wear_cells(wear: Wear | None, name: str) -> dict[str, str]:
    if wear is None:
        return {}
    titles = (f"against {wear.against}", "lost", "adhesion [%]", "least phase [deg]")
    one = next((one for one in wear.dampers if one.damper == name), None)
    if one is None:
        return dict.fromkeys(titles, "")
    lost = f"{one.loss.value:z.0%} (to {one.loss.high:z.0%})"
    if np.isfinite(one.loss.low):
        lost = f"{one.loss.value:z.0%} ({one.loss.low:z.0%} to {one.loss.high:z.0%})"
    return dict(zip(titles, (str(one.state), lost, *_grip_cells(wear, one.wheel)), strict=True))


def _grip_cells(wear: Wear, wheel: str | None) -> tuple[str, str]:
    if wear.after is None or wheel is None:
        return "", ""
    i = wear.after.wheels.index(wheel)
    phase, std = (float(np.degrees(part[i])) for part in (wear.after.phase, wear.after.phase_std))
    adhesion = f"{100 * wear.after.adhesion[i]:.1f} ± {100 * wear.after.adhesion_std[i]:.1f}"
    return adhesion, f"{phase:.1f} ± {std:.1f}"


def _curve_cells(curve: DamperCurve | None) -> Mapping[str, str]:
    titles = ("curve", "c of equal work [N s/m]", "friction [N]", "k beside it [N/m]")
    if curve is None:
        return dict.fromkeys(titles, "")
    if not curve.explains:
        return dict(zip(titles, ("in doubt", "", "", ""), strict=True))
    c, std = curve.equivalent_damping(), curve.equivalent_damping_std()
    shape = "a line" if curve.linear else "not a line"
    return dict(
        zip(
            titles,
            (
                f"{shape} (p = {curve.linear.p_value:.2g})",
                f"{rounded(np.array([c]), np.array([std]))[0]} ± {spread(std)}",
                f"{rounded(np.array([curve.friction]), np.array([curve.friction_std]))[0]} ± "
                f"{spread(curve.friction_std)}",
                f"{rounded(np.array([curve.stiffness]), np.array([curve.stiffness_std]))[0]} ± "
                f"{spread(curve.stiffness_std)}",
            ),
            strict=True,
        )
    )
