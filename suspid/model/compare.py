"""Compare an estimate with the truth."""

from __future__ import annotations

from collections.abc import Mapping
from typing import cast

import numpy as np

from suspid.arguments import explained
from suspid.errors import InputError
from suspid.levels import EXACT, NORMAL_95, ROUNDING
from suspid.model.compare_parameters import compare_parameters
from suspid.model.comparison import ComparedValue, Comparison, mean_errors
from suspid.model.force_curves import piecewise
from suspid.model.found_parameters import FoundCar, FoundParameters, found_parameters
from suspid.model.matching import common_mac, paired, with_rigid
from suspid.model.modes import ModalSet
from suspid.model.strut import Strut
from suspid.model.suspension import Suspension
from suspid.units import UNITS, Ratio, RealArray
from suspid.values import frozen_real

WN_ZETA = ("wn", "zeta")


@explained
def compare(
    found: ModalSet | Suspension | FoundCar | FoundParameters,
    expected: ModalSet | Suspension | FoundCar | FoundParameters,
    *,
    rtol: Ratio | Mapping[str, Ratio] | None = None,
    sigmas: float | None = None,
) -> Comparison:
    """Compare an estimate with the truth, or with an earlier one: modes, springs and dampers, or suspensions.

    Modes are paired by nearest poles, never by position: the optimal assignment on ``|a - b| / max(|a|, |b|)``, plus
    ``1 - MAC`` where both sides have shapes on at least two common channels. Poles further apart than half the larger
    one are not paired. A mode without a partner, or a mount that one side alone has, is ``"missing"`` or ``"extra"``,
    and the comparison fails.

    Parameters
    ----------
    found : ModalSet, Suspension, Reconstruction or Estimate
        The estimate.
    expected : ModalSet, Suspension, Reconstruction or Estimate
        The truth, or an earlier result. Modes are compared with modes, suspensions of one topology with each other. Of
        a reconstruction or estimate, the springs, dampers and masses that were found are compared, with those of
        another or of a suspension.
    rtol : float or mapping, optional
        Allowed error; of modes also by quantity as ``{"wn": 0.001, "zeta": 0.05}``; relative to each expected value,
        below 1 [1]. The error of an expected zero (an undamped mode, a missing damper, a rigid-body mode) is taken
        relative to the largest expected value of its quantity. If all of them are zero, zeta is taken relative to 1
        (critical damping), and damping relative to ``2 sqrt(k m)`` of the stiffest strut and the largest mass. Poles
        found that are exact and within this error of an expected rigid-body mode count as zero, a pair as two. Default:
        the 95 % interval of each difference, from the covariance of the results that carry one (of both, as if
        independent, when both do); otherwise 1e-9 relative. The intervals hold one by one: of 20 correctly estimated
        values one is expected to fall outside.
    sigmas : float, optional
        Width of these intervals [standard deviations]. Default: 1.96, which is 95 %.

    Returns
    -------
    Comparison
        ``passed``, ``mae``, ``mac``, ``table``; ``str()`` is the table.

    Raises
    ------
    InputError
        If the two cannot be compared, the suspensions have different masses or struts by name or arms, or rtol or
        sigmas is not such a number, or would judge nothing.

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
    mean absolute error: wn 0.005 rad/s, zeta 0
    """
    if isinstance(found, ModalSet) and isinstance(expected, ModalSet):
        known = found.covariance is not None or expected.covariance is not None
        return _compare_modes(found, expected, _by_quantity(rtol), _checked_sigmas(sigmas, known=known))
    if isinstance(found, Suspension) and isinstance(expected, Suspension):
        if isinstance(rtol, Mapping) or sigmas is not None:
            raise InputError("rtol by quantity and sigmas are for modes; two suspensions take one rtol")
        check_rtol("rtol", rtol)
        return _compare_suspensions(found, expected, rtol)
    sides = [_parameters(one) for one in (found, expected)]
    if sides[0] is not None and sides[1] is not None:
        if isinstance(rtol, Mapping):
            raise InputError("rtol by quantity is for modes; springs and dampers take one rtol")
        check_rtol("rtol", rtol)
        known = any(side is not None and side.stds is not None for side in sides)
        width = _checked_sigmas(sigmas, known=known)
        rule = _rule_in_words(rtol, width if known else None)
        return compare_parameters(sides[0], sides[1], rtol=rtol, sigmas=width, rule=rule)
    hints = [f"; take its .{a}" for x in (found, expected) for a in ("modes", "suspension") if hasattr(x, a)]
    raise InputError(
        f"compare needs two ModalSets, or two of Suspension, Reconstruction and Estimate, not "
        f"{type(found).__name__} and {type(expected).__name__}" + "".join(dict.fromkeys(hints))
    )


def _parameters(one: object) -> FoundParameters | None:
    """Return the parameters of what may stand on one side; None of what has none."""
    if isinstance(one, FoundParameters):
        return one
    if isinstance(one, Suspension):
        values = {f"{name}.mass": mass for name, mass in one.masses.items()}
        values |= {f"{s.name}.{what}": float(getattr(s, what)) for s in one.struts for what in ("stiffness", "damping")}
        return FoundParameters(values=values, stds=None)
    if all(hasattr(one, name) for name in ("suspension", "parameters", "covariance")):
        return found_parameters(cast("FoundCar", one))
    return None


def check_rtol(name: str, value: Ratio | None) -> None:
    """Refuse an allowed relative error that is no ratio; one of 100 % and more would pass values of the wrong sign.

    Examples
    --------
    >>> check_rtol("rtol", 2)
    Traceback (most recent call last):
    suspid.errors.InputError: rtol=2 allows an error of 200%: it is a ratio below 1, 1 % is 0.01
    """
    if value is not None and not (np.isfinite(value) and value >= 0):
        raise InputError(f"{name}={value} must be a finite number >= 0, relative to each expected value")
    if value is not None and value >= 1:
        raise InputError(f"{name}={value:g} allows an error of {value:.0%}: it is a ratio below 1, 1 % is 0.01")


def _by_quantity(rtol: Ratio | Mapping[str, Ratio] | None) -> dict[str, Ratio]:
    """Return the relative errors that are allowed by quantity; those that have none are left out."""
    if not isinstance(rtol, Mapping):
        check_rtol("rtol", rtol)
        return {} if rtol is None else dict.fromkeys(WN_ZETA, rtol)
    for name, value in rtol.items():
        if name not in WN_ZETA:
            raise InputError(f"rtol[{name!r}]: modes have {' and '.join(WN_ZETA)}")
        check_rtol(f"rtol[{name!r}]", value)
    return dict(rtol)


def _checked_sigmas(sigmas: float | None, *, known: bool) -> float:
    if sigmas is None:
        return NORMAL_95
    if not (np.isfinite(sigmas) and sigmas > 0):
        raise InputError(f"{sigmas=} must be a number above 0, such as 3")
    if not known:
        raise InputError(f"{sigmas=}: neither side has standard deviations; give rtol")
    return sigmas


def _compare_modes(found: ModalSet, expected: ModalSet, rtol: Mapping[str, Ratio], sigmas: float) -> Comparison:
    found = with_rigid(found, expected, EXACT if rtol.get("wn") is None else rtol["wn"])
    mac = common_mac(found, expected)
    # Modes further apart, as a share of the larger pole, are never paired: with a wider gate a missing and an extra
    # mode would be reported as one mode that is off, with a narrower one a poor estimate as a missing and an extra
    # mode.
    partner = paired(found, expected, mac=mac, gate=max(0.5, rtol.get("wn", 0.0)))
    extra = sorted(set(range(len(found))) - set(partner.values()))
    rows = [
        _mode_row(found, expected, partner.get(j), j, name, rtol.get(name), sigmas)
        for j in range(len(expected))
        for name in WN_ZETA
    ]
    rows += [_row(f"found {i + 1}", name, float(getattr(found, name)[i]), None, 0.0) for i in extra for name in WN_ZETA]
    matched_mac = None
    if mac is not None:
        matched_mac = frozen_real([mac[partner[j], j] if j in partner else np.nan for j in range(len(expected))])
    known = found.covariance is not None or expected.covariance is not None
    rules = {name: _rule_in_words(rtol.get(name), sigmas if known else None) for name in WN_ZETA}
    same = len(set(rules.values())) == 1
    rule = f"allowed: {rules['wn'] if same else ', '.join(f'{name} {rule}' for name, rule in rules.items())}"
    return Comparison(table=tuple(rows), mae=mean_errors(rows, WN_ZETA), mac=matched_mac, rule=rule)


def _rule_in_words(rtol: Ratio | None, sigmas: float | None) -> str:
    """Return the allowed error in words."""
    if rtol is not None or sigmas is None:
        return f"{EXACT if rtol is None else rtol:g} relative"
    if sigmas == NORMAL_95:
        return "the 95 % interval of each difference"
    return f"{sigmas:g} standard deviations of each difference"


def _mode_row(
    found: ModalSet, expected: ModalSet, i: int | None, j: int, name: str, rtol: Ratio | None, sigmas: float
) -> ComparedValue:
    """Return wn or zeta of the expected mode j and that of its partner i, if it has one."""
    truth: RealArray = getattr(expected, name)
    scale = float(np.max(np.abs(truth)))
    if name == "zeta" and scale <= ROUNDING:
        scale = 1.0
    value = None if i is None else float(getattr(found, name)[i])
    allowed = _allowed(float(truth[j]), scale, EXACT if rtol is None else rtol)
    if rtol is None and i is not None:
        sides: list[tuple[RealArray | None, int]] = [(getattr(found, f"{name}_std"), i)]
        sides.append((getattr(expected, f"{name}_std"), j))
        stds = [std[k] for std, k in sides if std is not None]
        if stds:
            allowed = max(sigmas * float(np.linalg.norm(stds)), ROUNDING * scale)
    return _row(f"mode {j + 1}", name, value, float(truth[j]), allowed)


def _compare_suspensions(found: Suspension, expected: Suspension, rtol: Ratio | None) -> Comparison:
    _check_topology(found, expected)
    struts = {strut.name: strut for strut in found.struts}
    stiffest = max((s.stiffness for s in expected.struts), default=0.0)
    strongest = max((s.damping for s in expected.struts), default=0.0)
    largest = max(expected.masses.values())
    scales = {"stiffness": stiffest, "damping": strongest or 2 * (stiffest * largest) ** 0.5, "mass": largest}
    values: list[tuple[str, str, float | None, float | None]] = []
    values += [(name, "mass", found.masses[name], mass) for name, mass in expected.masses.items()]
    for strut in expected.struts:
        values.append((strut.name, "stiffness", struts[strut.name].stiffness, strut.stiffness))
        values.append((strut.name, "damping", struts[strut.name].damping, strut.damping))
        mounts = (struts[strut.name].mount_stiffness, strut.mount_stiffness)
        if mounts != (None, None):
            values.append((strut.name, "mount_stiffness", *mounts))
        if strut.friction or struts[strut.name].friction:
            values.append((strut.name, "friction", struts[strut.name].friction, strut.friction))
        values += _curve_forces(struts[strut.name], strut)
    scales["mount_stiffness"] = stiffest
    for what in ("friction", "force"):
        scales[what] = max((abs(true) for _, quantity, _, true in values if quantity == what and true), default=1.0)
    tolerance = EXACT if rtol is None else rtol
    rows = [
        _row(item, what, value, truth, 0.0 if truth is None else _allowed(truth, scales[what], tolerance))
        for item, what, value, truth in values
    ]
    mae = mean_errors(rows, ("stiffness", "damping"))
    return Comparison(table=tuple(rows), mae=mae, mac=None, rule=_rule(rtol))


def _curve_forces(found: Strut, expected: Strut) -> list[tuple[str, str, float | None, float | None]]:
    """Return the forces of two dampers at the velocities of their curves; none where both are viscous."""
    velocities = np.array(sorted({v for strut in (found, expected) for v, _ in strut.curve or () if v}))
    ours, theirs = (piecewise(s.curve or ((0.0, 0.0), (1.0, s.damping)), velocities) for s in (found, expected))
    return [
        (f"{expected.name} at {v:g} m/s", "force", float(a), float(b))
        for v, a, b in zip(velocities, ours, theirs, strict=True)
    ]


def _check_topology(found: Suspension, expected: Suspension) -> None:
    """Refuse suspensions whose masses, struts or arms differ."""
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
        if _nonzero(strut.arms) != _nonzero(struts[strut.name].arms):
            raise InputError(
                f"strut {strut.name!r} has the arms {dict(struts[strut.name].arms)} in found and "
                f"{dict(strut.arms)} in expected; compare suspensions of one topology"
            )


def _row(item: str, quantity: str, found: float | None, expected: float | None, allowed: float) -> ComparedValue:
    unit = UNITS[quantity]
    return ComparedValue(item=item, quantity=quantity, unit=unit, found=found, expected=expected, allowed=allowed)


def _allowed(expected: float, scale: float, rtol: Ratio) -> float:
    zero = abs(expected) <= ROUNDING * scale
    return max(rtol * (scale if zero else abs(expected)), ROUNDING * scale)


def _nonzero(arms: Mapping[str, float]) -> dict[str, float]:
    return {name: arm for name, arm in arms.items() if arm}


def _rule(rtol: Ratio | None) -> str:
    return f"allowed: {EXACT if rtol is None else rtol:g} relative"
