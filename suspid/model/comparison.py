"""Truth beside estimate: which value is off, by how much, and what was allowed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from suspid.errors import InputError
from suspid.model.modes import ModalSet, pole_distances
from suspid.model.suspension import Suspension
from suspid.units import ComplexArray, Ratio, RealArray
from suspid.values import FrozenMapping, frozen_real, text_table

UNITS = {"wn": "rad/s", "zeta": "1", "stiffness": "N/m", "damping": "N s/m", "mass": "kg"}
EXACT = 1e-9  # relative; what two ways of solving one eigenvalue problem agree to
ROUNDING = 1e-12  # of the largest expected value; below this nothing is different
STRANGERS = 0.5  # of the larger pole; two poles further apart are not one mode
REACH = 1.959963984540054  # standard deviations of a 95 % interval


@dataclass(frozen=True, kw_only=True, slots=True)
class ComparedValue:
    """One row of a comparison.

    Parameters
    ----------
    item : str
        What is compared: ``"mode 2"`` (counted among the expected modes), or the name of a strut or of a mass.
    quantity : str
        ``"wn"``, ``"zeta"``, ``"stiffness"``, ``"damping"`` or ``"mass"``.
    unit : str
        Unit of the values.
    found, expected : float or None
        The two values; None where a mode has no partner.
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
        """``found - expected``; None where a mode has no partner."""
        return None if self.found is None or self.expected is None else self.found - self.expected

    @property
    def verdict(self) -> Literal["ok", "off", "missing", "extra"]:
        """``"missing"``: expected but not found; ``"extra"``: found but not expected."""
        if self.error is None:
            return "missing" if self.found is None else "extra"
        return "ok" if abs(self.error) <= self.allowed else "off"


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Comparison:
    """What `compare` found; its text is the table, so that ``assert c.passed, c`` explains itself.

    Parameters
    ----------
    table : tuple of ComparedValue
        One row per value.
    mae : mapping of str to float
        Mean absolute error, Eq. (22), over the modes that have a partner: ``"wn"`` [rad/s] and ``"zeta"`` [1]; for
        suspensions over the struts: ``"stiffness"`` [N/m] and ``"damping"`` [N s/m]. NaN if there is no such pair.
    mac : ndarray (expected mode,) or None
        Modal assurance criterion of each expected mode with its partner [1]; NaN without one. None unless both
        sides have shapes on two common channels at least. It is shown, and not judged.
    rule : str
        What was allowed, in words.
    """

    table: tuple[ComparedValue, ...]
    mae: Mapping[str, float]
    mac: RealArray | None
    rule: str

    @property
    def passed(self) -> bool:
        """Whether every value is within what is allowed, and no mode is missing or extra."""
        return all(row.verdict == "ok" for row in self.table)

    def __bool__(self) -> bool:
        """Whether it passed, so that ``assert compare(found, expected)`` means what it says."""
        return self.passed

    def __str__(self) -> str:
        failed = [row for row in self.table if row.verdict != "ok"]
        told = [f"{len(failed)} of {len(self.table)} values fail" if failed else f"all {len(self.table)} values pass"]
        columns: dict[str, Sequence[str]] = {
            "": [row.item for row in self.table],
            "quantity": [f"{row.quantity} [{row.unit}]" for row in self.table],
            "found": [_text(row.found, 8) for row in self.table],
            "expected": [_text(row.expected, 8) for row in self.table],
            "error": [_text(row.error, 2) for row in self.table],
            "allowed": [_text(row.allowed, 2) for row in self.table],
            "verdict": [row.verdict for row in self.table],
        }
        mae = ", ".join(f"{name} {value:.3g} {UNITS[name]}" for name, value in self.mae.items())
        notes = [f"mean absolute error: {mae}"]
        if self.mac is not None:
            notes.append(f"MAC by expected mode: {', '.join(f'{m:.6f}' for m in self.mac)}")
        table = text_table(columns)
        return "\n".join([f"{told[0]} ({self.rule})", table, *notes])


def compare(found: ModalSet | Suspension, expected: ModalSet | Suspension, *, rtol: Ratio | None = None) -> Comparison:
    """Compare an estimate with the truth: two sets of modes, or two suspensions of one topology.

    Modes are paired by nearest poles (optimal assignment on ``|a - b| / max(|a|, |b|)``, plus ``1 - MAC`` where both
    sides have shapes on two common channels at least), never by position. Poles further apart than half the larger
    are not taken for one mode. A mode without a partner is ``"missing"`` or ``"extra"``, and the comparison fails.

    Parameters
    ----------
    found : ModalSet or Suspension
        The estimate.
    expected : ModalSet or Suspension
        The truth, of the same type.
    rtol : float, optional
        Allowed error, relative to each expected value [1]. An expected zero (an undamped mode, a missing damper, a
        rigid-body mode) is judged against the largest expected value of its quantity; if all are zero, zeta is judged
        against 1 (critical damping), and damping against ``2 sqrt(k m)`` of the stiffest strut and largest mass.
        Default: the 95 % interval of each difference, from the covariance of the modes that carry one (of both, as
        if independent, when both do); otherwise 1e-9 relative. Each interval is one of 95 %: of 20 values
        estimated well, one is expected to fall outside.

    Returns
    -------
    Comparison
        ``passed``, ``mae``, ``mac``, ``table``; ``str()`` is the table.

    Raises
    ------
    InputError
        If the two are of different types, the suspensions have different masses or struts by name or arms, or rtol is
        negative or not finite.

    Examples
    --------
    >>> found = ModalSet.from_wn_zeta([10.01, 70.0], [0.3, 0.2])
    >>> c = compare(found, ModalSet.from_wn_zeta([10.0, 70.0], [0.3, 0.2]), rtol=1e-4)
    >>> c.passed
    False
    >>> print(c)
    1 of 4 values fail (allowed: 0.0001 relative)
              quantity    found    expected    error    allowed    verdict
    ------  ----------  -------  ----------  -------  ---------  ---------
    mode 1  wn [rad/s]    10.01          10     0.01      0.001        off
    mode 1    zeta [1]      0.3         0.3        0      3e-05         ok
    mode 2  wn [rad/s]       70          70        0      0.007         ok
    mode 2    zeta [1]      0.2         0.2        0      2e-05         ok
    mean absolute error: wn 0.005 rad/s, zeta 0 1
    """
    if rtol is not None and not (np.isfinite(rtol) and rtol >= 0):
        raise InputError(f"{rtol=} must be a finite number >= 0, relative to each expected value")
    if isinstance(found, ModalSet) and isinstance(expected, ModalSet):
        return _compare_modes(found, expected, rtol)
    if isinstance(found, Suspension) and isinstance(expected, Suspension):
        return _compare_suspensions(found, expected, rtol)
    hints = [f"; take its .{a}" for x in (found, expected) for a in ("modes", "suspension") if hasattr(x, a)]
    raise InputError(
        f"compare needs two ModalSets or two Suspensions, not {type(found).__name__} and {type(expected).__name__}"
        + "".join(dict.fromkeys(hints))
    )


def modal_assurance(a: ComplexArray, b: ComplexArray) -> RealArray:
    """Return ``|a^H b|^2 / (a^H a b^H b)`` of every shape (column) of ``a`` with every one of ``b`` [1].

    1 for shapes that differ by a complex factor, 0 for orthogonal ones or where a shape is zero.

    Examples
    --------
    >>> modal_assurance(np.array([[1.0], [1j]]), np.array([[2j], [-2.0]])).round(12)
    array([[1.]])
    """
    powers = np.sum(np.abs(a) ** 2, axis=0)[:, None] * np.sum(np.abs(b) ** 2, axis=0)
    return np.asarray(np.abs(a.conj().T @ b) ** 2 / np.where(powers > 0, powers, 1.0))


def _compare_modes(found: ModalSet, expected: ModalSet, rtol: Ratio | None) -> Comparison:
    mac = _common_mac(found, expected)
    partner = _pairs(found, expected, mac, max(STRANGERS, rtol or 0.0))
    rows: list[ComparedValue] = []
    deviations: dict[str, list[float]] = {"wn": [], "zeta": []}
    stds = {"wn": (found.wn_std, expected.wn_std), "zeta": (found.zeta_std, expected.zeta_std)}
    estimated = any(std is not None for pair in stds.values() for std in pair)
    for j in range(len(expected)):
        i = partner.get(j)
        for name in ("wn", "zeta"):
            truth: RealArray = getattr(expected, name)
            scale = float(np.max(np.abs(truth)))
            if name == "zeta" and scale <= ROUNDING:
                scale = 1.0
            value = None if i is None else float(getattr(found, name)[i])
            allowed = _allowed(float(truth[j]), scale, EXACT if rtol is None else rtol)
            if rtol is None and estimated and i is not None:
                both = [std[k] for std, k in zip(stds[name], (i, j), strict=True) if std is not None]
                allowed = max(REACH * float(np.linalg.norm(both)), ROUNDING * scale)
            rows.append(
                ComparedValue(
                    item=f"mode {j + 1}",
                    quantity=name,
                    unit=UNITS[name],
                    found=value,
                    expected=float(truth[j]),
                    allowed=allowed,
                )
            )
            if value is not None:
                deviations[name].append(abs(value - float(truth[j])))
    rows += [
        ComparedValue(
            item=f"found {i + 1}",
            quantity=name,
            unit=UNITS[name],
            found=float(getattr(found, name)[i]),
            expected=None,
            allowed=0.0,
        )
        for i in sorted(set(range(len(found))) - set(partner.values()))
        for name in ("wn", "zeta")
    ]
    matched_mac = None
    if mac is not None:
        matched_mac = frozen_real([mac[partner[j], j] if j in partner else np.nan for j in range(len(expected))])
    rule = "allowed: the 95 % interval of each difference" if rtol is None and estimated else _rule(rtol)
    mae = FrozenMapping({name: float(np.mean(d)) if d else np.nan for name, d in deviations.items()})
    return Comparison(table=tuple(rows), mae=mae, mac=matched_mac, rule=rule)


def _compare_suspensions(found: Suspension, expected: Suspension, rtol: Ratio | None) -> Comparison:
    struts = {strut.name: strut for strut in found.struts}
    sides = [("masses", set(found.masses), set(expected.masses))]
    sides.append(("struts", set(struts), {strut.name for strut in expected.struts}))
    for what, ours, theirs in sides:
        if ours != theirs:
            raise InputError(
                f"the suspensions differ in their {what}: only found has {sorted(ours - theirs)}, "
                f"only expected has {sorted(theirs - ours)}; compare suspensions of one topology"
            )
    for strut in expected.struts:
        if _ties(strut.arms) != _ties(struts[strut.name].arms):
            raise InputError(
                f"strut {strut.name!r} has the arms {dict(struts[strut.name].arms)} in found and "
                f"{dict(strut.arms)} in expected; compare suspensions of one topology"
            )
    stiffest = max((s.stiffness for s in expected.struts), default=0.0)
    strongest = max((s.damping for s in expected.struts), default=0.0)
    largest = max(expected.masses.values())
    scales = {"stiffness": stiffest, "damping": strongest or 2 * (stiffest * largest) ** 0.5, "mass": largest}
    values = [(name, "mass", found.masses[name], mass) for name, mass in expected.masses.items()]
    for strut in expected.struts:
        values.append((strut.name, "stiffness", struts[strut.name].stiffness, strut.stiffness))
        values.append((strut.name, "damping", struts[strut.name].damping, strut.damping))
    rows = tuple(
        ComparedValue(
            item=item,
            quantity=quantity,
            unit=UNITS[quantity],
            found=value,
            expected=truth,
            allowed=_allowed(truth, scales[quantity], EXACT if rtol is None else rtol),
        )
        for item, quantity, value, truth in values
    )
    mae = {}
    for name in ("stiffness", "damping"):
        errors = [abs(value - truth) for _, quantity, value, truth in values if quantity == name]
        mae[name] = float(np.mean(errors)) if errors else np.nan
    return Comparison(table=rows, mae=FrozenMapping(mae), mac=None, rule=_rule(rtol))


def _common_mac(found: ModalSet, expected: ModalSet) -> RealArray | None:
    """Return the MAC of every found with every expected mode on the channels that both have."""
    common = [c for c in expected.channels if c in found.channels]
    if found.shapes is None or expected.shapes is None or len(common) < 2:
        return None
    return modal_assurance(
        found.shapes[[found.channels.index(c) for c in common]],
        expected.shapes[[expected.channels.index(c) for c in common]],
    )


def _pairs(found: ModalSet, expected: ModalSet, mac: RealArray | None, gate: float) -> dict[int, int]:
    """Return the found mode that belongs to each expected mode that has one."""
    from scipy.optimize import linear_sum_assignment

    distance = pole_distances(found.poles, expected.poles)
    cost = distance if mac is None else distance + (1 - mac)
    # Strangers cost more than any set of real pairs, so that they never push a real pair apart.
    cost = np.where(distance > gate, 1e3 * (1 + cost), cost)
    pairs = zip(*linear_sum_assignment(cost), strict=True)
    return {int(j): int(i) for i, j in pairs if distance[i, j] <= gate}


def _allowed(expected: float, scale: float, rtol: Ratio) -> float:
    zero = abs(expected) <= ROUNDING * scale
    return max(rtol * (scale if zero else abs(expected)), ROUNDING * scale)


def _ties(arms: Mapping[str, float]) -> dict[str, float]:
    return {name: arm for name, arm in arms.items() if arm}


def _rule(rtol: Ratio | None) -> str:
    return f"allowed: {EXACT if rtol is None else rtol:g} relative"


def _text(value: float | None, digits: int) -> str:
    return "" if value is None else f"{value:.{digits}g}"
