"""Fail a test unless two sets of modes agree."""

from __future__ import annotations

from typing import Protocol

from suspid.arguments import explained
from suspid.errors import InputError
from suspid.model.compare import compare
from suspid.model.eigenmodes import eigenmodes
from suspid.model.modes import ModalSet
from suspid.model.suspension import Suspension
from suspid.units import Ratio


class HasModes(Protocol):
    """A result that has modes."""

    @property
    def modes(self) -> ModalSet:
        """The modes."""


@explained
def assert_modes_close(
    found: ModalSet | Suspension | HasModes,
    expected: ModalSet | Suspension | HasModes,
    *,
    rtol_wn: Ratio | None = None,
    rtol_zeta: Ratio | None = None,
    sigmas: float | None = None,
) -> None:
    """Fail with the table of `compare` unless two sets of modes agree; for tests, as in `numpy.testing`.

    Parameters
    ----------
    found, expected : ModalSet, Suspension, or a result that has ``.modes``
        The modes, or what has them: of a `Suspension` its exact modes, of an identification those found.
    rtol_wn, rtol_zeta : float, optional
        Allowed error of natural frequencies and of damping ratios, relative to each expected value [1].
    sigmas : float, optional
        Allowed error of what has no ``rtol``, in its standard deviations [1]. Default: as in
        `compare`, 1.96 where there are any, else 1e-9 relative.

    Raises
    ------
    AssertionError
        If a value is off, or a mode is missing or extra; the message is the table.
    InputError
        If something has no modes, or a limit is no such number.

    Examples
    --------
    >>> expected = ModalSet.from_wn_zeta([10.0, 70.0], [0.3, 0.2])
    >>> found = ModalSet.from_wn_zeta([10.01, 70.0], [0.31, 0.2])
    >>> assert_modes_close(found, expected, rtol_wn=0.002, rtol_zeta=0.05)
    >>> assert_modes_close(found, expected, rtol_wn=0.002, rtol_zeta=0.01)
    Traceback (most recent call last):
        ...
    AssertionError: 1 of 4 values fail (allowed: wn 0.002 relative, zeta 0.01 relative)
              quantity    found    expected    error    allowed    verdict
    ------  ----------  -------  ----------  -------  ---------  ---------
    mode 1  wn [rad/s]    10.01          10     0.01       0.02         ok
    mode 1    zeta [1]     0.31         0.3     0.01      0.003        off
    mode 2  wn [rad/s]       70          70        0       0.14         ok
    mode 2    zeta [1]      0.2         0.2        0      0.002         ok
    mean absolute error: wn 0.005 rad/s, zeta 0.005
    """
    __tracebackhide__ = True
    rtol = {name: value for name, value in (("wn", rtol_wn), ("zeta", rtol_zeta)) if value is not None}
    comparison = compare(_modes_of("found", found), _modes_of("expected", expected), rtol=rtol or None, sigmas=sigmas)
    if not comparison.table:
        raise InputError("neither has modes: there is nothing to compare")
    if not comparison:
        raise AssertionError(str(comparison))


def _modes_of(name: str, given: object) -> ModalSet:
    """Return modes, those of a car, or those that a result has."""
    modes = eigenmodes(given) if isinstance(given, Suspension) else getattr(given, "modes", given)
    if not isinstance(modes, ModalSet):
        raise InputError(
            f"{name} is a {type(given).__name__}: give modes, a Suspension, or a result with .modes; of a system the "
            f"modes are eigenmodes(system)"
        )
    return modes
