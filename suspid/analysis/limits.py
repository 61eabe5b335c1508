"""Limits on natural frequencies, damping ratios, springs and dampers, as a TOML file that a person writes.

Modes by number or near a frequency, struts by name; bounds as ``min`` and ``max``, one of them or both, in the unit
that stands beside them (default: rad/s, 1, N/m, N s/m)::

    [modes.1]
    wn = { min = 1.0, max = 1.5, unit = "Hz" }
    zeta = { min = 0.2, max = 0.4 }

    [modes.hop]
    near_hz = 11.0                # the mode nearest to it, not more than an octave off
    zeta = { min = 8, unit = "%" }

    [struts.chassis]
    stiffness = { min = 18, max = 22, unit = "N/mm" }
    damping = { min = 1200 }      # N s/m
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from suspid.arguments import explained
from suspid.errors import InputError
from suspid.files import naming, read_text
from suspid.text_tables import figures_of
from suspid.toml import as_number, as_table, check_keys, parsed_toml
from suspid.units import Hertz
from suspid.values import is_count

# Units that a limit may be written in, and how large each is in SI; the first is SI's own.
SCALES: Mapping[str, Mapping[str, float]] = {
    "wn": {"rad/s": 1.0, "Hz": 2 * math.pi},
    "zeta": {"1": 1.0, "%": 0.01},
    "stiffness": {"N/m": 1.0, "kN/m": 1e3, "N/mm": 1e3},
    "damping": {"N s/m": 1.0, "kN s/m": 1e3, "N s/mm": 1e3},
}
OF_MODES, OF_STRUTS = ("wn", "zeta"), ("stiffness", "damping")
# Digits of the number of a mode: Python reads no whole number of more than some thousand.
LONGEST_NUMBER = 9


@dataclass(frozen=True, kw_only=True, slots=True)
class Limit:
    """Bounds of one quantity of a mode or a strut.

    Parameters
    ----------
    of : int or str
        Number of the mode, from 1 on; name of the strut; or any name of a mode that ``near`` finds.
    quantity : {"wn", "zeta", "stiffness", "damping"}
        What is limited.
    least, most : float
        Bounds, in SI units; infinite where there is none.
    near : float, optional
        Frequency of the mode that is meant [Hz]: the nearest, not more than an octave off.
    unit : str
        Unit in which it is shown. Default: that of SI.

    Raises
    ------
    InputError
        If the quantity or the unit is unknown, there is no such mode or bound, or ``least`` is not below ``most``.

    Examples
    --------
    >>> Limit(of="chassis", quantity="damping", least=1200.0).name
    'chassis.damping'
    """

    of: int | str
    quantity: str
    least: float = -math.inf
    most: float = math.inf
    near: Hertz | None = None
    unit: str = ""

    def __post_init__(self) -> None:
        if not isinstance(self.quantity, str) or self.quantity not in SCALES:
            raise InputError(f"quantity={self.quantity!r:.40} must be one of {', '.join(SCALES)}")
        units = SCALES[self.quantity]
        object.__setattr__(self, "unit", self.unit or next(iter(units)))
        if self.unit not in units:
            raise InputError(f"{self.name}: the unit {self.unit!r} is not one of {', '.join(units)}")
        if self.near is not None and not (math.isfinite(self.near) and self.near > 0):
            raise InputError(f"{self.name}: near_hz = {self.near!r:.40} must be positive and finite, in Hz")
        if self.quantity in OF_MODES and self.near is None and not is_count(self.of):
            raise InputError(f"of={self.of!r:.40} must be the number of a mode, from 1 on, or give near")
        if not self.least < self.most or (math.isinf(self.least) and math.isinf(self.most)):
            raise InputError(f"{self.name}: give min, max or both, with min below max")

    @property
    def name(self) -> str:
        """What is limited, such as ``"chassis.damping"`` or ``"mode 1.zeta"``.

        Examples
        --------
        >>> from suspid import Limit
        >>> Limit(of="chassis", quantity="damping", least=1200.0).name
        'chassis.damping'
        """
        return f"{f'mode {self.of}' if self.quantity in OF_MODES else self.of}.{self.quantity}"

    @property
    def scale(self) -> float:
        """Size of the unit in which it is shown, in SI units.

        Examples
        --------
        >>> from suspid import Limit
        >>> Limit(of=1, quantity="zeta", least=0.2).scale
        1.0
        """
        return SCALES[self.quantity][self.unit]

    def __str__(self) -> str:
        least, most = (figures_of(bound / self.scale, 6) for bound in (self.least, self.most))
        if math.isinf(self.most):
            return f"at least {least}"
        return f"at most {most}" if math.isinf(self.least) else f"{least} to {most}"


@explained
def read_limits(path: str | os.PathLike[str]) -> tuple[Limit, ...]:
    """Return the limits in a TOML file; its form is that of the module docstring.

    Raises
    ------
    InputError
        If the file cannot be read, is not TOML, or a table, key or value in it is wrong; the message names the file,
        the table and the key.

    Examples
    --------
    >>> [limit.name for limit in read_limits("examples/limits.toml")]
    ['mode 1.wn', 'mode 1.zeta', 'chassis.stiffness', 'chassis.damping']
    """
    with naming(path):
        return limits_from_toml(read_text(Path(path)))


def limits_from_toml(text: str) -> tuple[Limit, ...]:
    """Return the limits that a TOML text describes.

    Examples
    --------
    >>> limits_from_toml('modes.1.zeta = { min = 20, unit = "%" }')[0].least
    0.2
    """
    content = parsed_toml(text)
    check_keys("the file", content, ("modes", "struts"))
    limits = [
        *(one for name, given in _tables(content, "modes") for one in _of_mode(name, given)),
        *(one for name, given in _tables(content, "struts") for one in _of_strut(name, given)),
    ]
    if not limits:
        raise InputError("there is no limit; write one such as [struts.chassis] and damping = { min = 1200 }")
    return tuple(limits)


def _tables(content: Mapping[str, object], kind: str) -> Iterator[tuple[str, dict[str, object]]]:
    for name, given in as_table(f"[{kind}]", content.get(kind, {})).items():
        yield name, as_table(f"[{kind}.{name}]", given)


def _of_mode(name: str, given: dict[str, object]) -> Iterator[Limit]:
    where = f"[modes.{name}]"
    check_keys(where, given, ("near_hz", *OF_MODES))
    near = given.pop("near_hz", None)
    number = int(name) if len(name) <= LONGEST_NUMBER and name.isdecimal() and int(name) > 0 else None
    if near is None and number is None:
        raise InputError(f"{where} must have a number, as [modes.1], or near_hz, as near_hz = 1.2")
    found = None if near is None else as_number(where, "near_hz", near, "Hz")
    for quantity, bounds in given.items():
        yield _limit(where, name if near is not None or number is None else number, quantity, bounds, near=found)


def _of_strut(name: str, given: dict[str, object]) -> Iterator[Limit]:
    check_keys(f"[struts.{name}]", given, OF_STRUTS)
    for quantity, bounds in given.items():
        yield _limit(f"[struts.{name}]", name, quantity, bounds)


def _limit(where: str, of: int | str, quantity: str, given: object, *, near: Hertz | None = None) -> Limit:
    bounds = as_table(f"{where}: {quantity}", given)
    check_keys(f"{where}: {quantity}", bounds, ("min", "max", "unit"))
    units = SCALES[quantity]
    unit = bounds.get("unit", next(iter(units)))
    if not isinstance(unit, str) or unit not in units:
        raise InputError(f"{where}: {quantity}: unit = {unit!r:.40} must be one of {', '.join(units)}")
    ends = {
        end: as_number(f"{where}: {quantity}", key, bounds[key], unit) * units[unit]
        for key, end in (("min", "least"), ("max", "most"))
        if key in bounds
    }
    try:
        return Limit(of=of, quantity=quantity, near=near, unit=unit, **ends)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None
