"""Fail a test unless two sets of modes agree."""

from __future__ import annotations

from typing import Protocol

from suspid.arguments import explained
from suspid.errors import InputError
from suspid.model.compare import check_rtol, compare
from suspid.model.eigenmodes import eigenmodes
from suspid.model.modes import ModalSet
from suspid.model.suspension import Suspension
from suspid.units import Ratio


class HasModes(Protocol):
    """A result that has modes."""

    @property
    def modes(self) -> ModalSet:
        """The modes."""


class System(Protocol):
    """A system of python-control, which has no types of its own."""

    def poles(self) -> object:
        """Return the poles."""


class HasSuspension(Protocol):
    """A result that has a car, whose modes are exact."""

    @property
    def suspension(self) -> Suspension:
        """The car."""


@explained
def assert_modes_close(
    found: ModalSet | Suspension | System | HasModes | HasSuspension,
    expected: ModalSet | Suspension | System | HasModes | HasSuspension,
    *,
    rtol_wn: Ratio | None = None,
    rtol_zeta: Ratio | None = None,
    sigmas: float | None = None,
) -> None:
    """Fail with the table of `compare` unless two sets of modes agree; for tests, as in `numpy.testing`.

    Parameters
    ----------
    found, expected : ModalSet, Suspension, control.LTI, or a result with ``.modes`` or ``.suspension``
        The modes, or what has them: of a `Suspension` and of a system of python-control their exact modes, of an
        identification those found, of a reconstruction those of its car.
    rtol_wn, rtol_zeta : float, optional
        Allowed error of natural frequencies and of damping ratios, relative to each expected value, below 1 [1].
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
    for name, value in (("rtol_wn", rtol_wn), ("rtol_zeta", rtol_zeta)):
        check_rtol(name, value)
    rtol = {name: value for name, value in (("wn", rtol_wn), ("zeta", rtol_zeta)) if value is not None}
    comparison = compare(_modes_of("found", found), _modes_of("expected", expected), rtol=rtol or None, sigmas=sigmas)
    if not comparison.table:
        raise InputError("neither has modes: there is nothing to compare")
    if not comparison:
        raise AssertionError(str(comparison))


def _modes_of(name: str, given: object) -> ModalSet:
    """Return modes, those of a car or of a system, or those that a result has."""
    __tracebackhide__ = True
    held = getattr(given, "modes", getattr(given, "suspension", given))
    if isinstance(held, ModalSet):
        return held
    # What a system is, eigenmodes decides; python-control is not imported for that.
    if isinstance(held, Suspension) or hasattr(held, "poles"):
        return eigenmodes(held)
    raise InputError(
        f"{name} is a {type(given).__name__}: give modes, a Suspension, a system of python-control, or a result with "
        ".modes or .suspension; of a record they are those of identify(record)"
    )
