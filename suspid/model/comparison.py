"""A comparison of two sets of modes, or of springs and dampers: its values and its verdict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from suspid.results import Result, columns_of
from suspid.text_tables import TERMINAL, text_table
from suspid.units import UNITS, RealArray
from suspid.values import MOST_NUMBERS, FrozenMapping
from suspid.words import Remark


@dataclass(frozen=True, kw_only=True, slots=True)
class ComparedValue:
    """One row of a comparison.

    Parameters
    ----------
    item : str
        What is compared: ``"mode 2"`` (the number among the expected modes), ``"found 2"`` (a found mode without a
        partner), or the name of a strut or of a mass.
    quantity : str
        ``"wn"``, ``"zeta"``, ``"stiffness"``, ``"damping"``, ``"mount_stiffness"`` or ``"mass"``.
    unit : str
        Unit of the values.
    found, expected : float or None
        The two values; None where a mode has no partner, or a damper no mount.
    allowed : float
        Largest ``|found - expected|`` that passes, in the same unit.
    """

    item: str
    quantity: str
    unit: str
    found: float | None
    expected: float | None
    allowed: float

    @property
    def error(self) -> float | None:
        """``found - expected``; None where one of them is missing."""
        return None if self.found is None or self.expected is None else self.found - self.expected

    @property
    def verdict(self) -> Literal["ok", "off", "missing", "extra"]:
        """``"missing"``: expected but not found; ``"extra"``: found but not expected."""
        if self.error is None:
            return "missing" if self.found is None else "extra"
        return "ok" if abs(self.error) <= self.allowed else "off"


@dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)
class Comparison(Result):
    """Result of `compare`; ``str()`` is the table, and `assert_modes_close` fails with it.

    Parameters
    ----------
    table : tuple of ComparedValue
        One row per value.
    mae : mapping of str to float
        Mean absolute error, Eq. (22), over the modes that have a partner: ``"wn"`` [rad/s] and ``"zeta"`` [1]; for
        suspensions over the struts: ``"stiffness"`` [N/m] and ``"damping"`` [N s/m]. NaN if there is no such pair.
    mac : ndarray (expected mode,) or None
        Modal assurance criterion of each expected mode with its partner [1]; NaN without a partner. None unless both
        sides have shapes on at least two common channels. The verdict does not depend on it.
    rule : str
        The allowed error in words.
    remarks : tuple of Remark
        What else is to be known of the values.

    Examples
    --------
    >>> from suspid import ModalSet, compare
    >>> found = compare(ModalSet.from_wn_zeta([10.01], [0.3]), ModalSet.from_wn_zeta([10.0], [0.3]), rtol=0.01)
    >>> found.passed, round(found.mae["wn"], 6)
    (True, 0.01)
    """

    table: tuple[ComparedValue, ...]
    mae: Mapping[str, float]
    mac: RealArray | None
    rule: str
    remarks: tuple[Remark, ...] = ()

    @property
    def passed(self) -> bool:
        """Whether every error is within the allowed one, and no mode is missing or extra.

        Examples
        --------
        >>> from suspid import ModalSet, compare
        >>> modes = ModalSet.from_wn_zeta([10.0], [0.3])
        >>> compare(modes, modes, rtol=0.01).passed
        True
        """
        return all(row.verdict == "ok" for row in self.table)

    def __bool__(self) -> bool:
        """Whether it passed, so that ``assert compare(found, expected)`` works."""
        return self.passed

    def _table(self) -> Mapping[str, Sequence[object]]:
        return columns_of(self.table, ["item", "quantity", "unit", "found", "expected", "error", "allowed", "verdict"])

    def _headline(self) -> str:
        number, failed = len(self.table), sum(row.verdict != "ok" for row in self.table)
        return f"{f'{failed} of {number} values fail' if failed else f'all {number} values pass'} ({self.rule})"

    def _brief(self) -> str:
        headline, failed = self._headline(), [row for row in self.table if row.verdict != "ok"]
        texts = [f"{row.item} {row.quantity} {_text(row.found, 6)} for {_text(row.expected, 6)}" for row in failed]
        more = [f"and {len(failed) - MOST_NUMBERS} more"] if len(failed) > MOST_NUMBERS else []
        return ": ".join([headline, ", ".join([*texts[:MOST_NUMBERS], *more])]) if failed else headline

    def __str__(self) -> str:
        columns: dict[str, Sequence[str]] = {
            "": [row.item for row in self.table],
            "quantity": [f"{row.quantity} [{row.unit}]" for row in self.table],
            "found": [_text(row.found, 8) for row in self.table],
            "expected": [_text(row.expected, 8) for row in self.table],
            "error": [_text(row.error, 2) for row in self.table],
            "allowed": [_text(row.allowed, 2) for row in self.table],
            "verdict": [row.verdict for row in self.table],
        }
        # A ratio has no unit to print behind a number.
        mae = ", ".join(f"{name} {value:.3g} {UNITS[name]}".removesuffix(" 1") for name, value in self.mae.items())
        notes = [f"mean absolute error: {mae}"]
        if self.mac is not None:
            notes.append(f"MAC by expected mode: {', '.join(f'{m:.6f}' for m in self.mac)}")
        return "\n".join([self._headline(), text_table(columns, widest=TERMINAL), *notes, *map(str, self.remarks)])


def _text(value: float | None, digits: int) -> str:
    return "" if value is None else f"{value:.{digits}g}"


def mean_errors(rows: Sequence[ComparedValue], quantities: tuple[str, ...]) -> FrozenMapping:
    """Return the mean absolute error of each quantity over the rows that have both values; NaN without any."""
    errors = {q: [abs(row.error) for row in rows if row.quantity == q and row.error is not None] for q in quantities}
    return FrozenMapping({q: float(np.mean(e)) if e else np.nan for q, e in errors.items()})
