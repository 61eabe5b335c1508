"""Errors and warnings. An error carries the best result found before it."""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING, Self

from suspid.wording import Wording

if TYPE_CHECKING:
    from suspid.model import ModalSet, Suspension


class SuspidError(Exception):
    """Base of all errors that suspid raises; its message is made of the parts that it is given.

    Attributes
    ----------
    source : str
        The file or record that it is about, with which the message begins; empty where there is none.

    Examples
    --------
    >>> from suspid import read_recording
    >>> try:
    ...     read_recording("nowhere.csv")
    ... except SuspidError as error:
    ...     print(error)
    nowhere.csv: there is no such file in ...; check the path
    """

    source: str = ""

    @property
    def message(self) -> str:
        """What is wrong, without the name of the source.

        Examples
        --------
        >>> from suspid.errors import SuspidError
        >>> error = SuspidError("is empty").about("bump.csv")
        >>> str(error), error.message
        ('bump.csv: is empty', 'is empty')
        """
        return str(Wording(self.args))

    @property
    def wording(self) -> Wording:
        """The message in parts, which keep the arguments that it speaks of.

        Examples
        --------
        >>> from suspid import RecordError
        >>> RecordError("is empty").about("bump.csv").wording.parts
        ('bump.csv: ', 'is empty')
        """
        return Wording((f"{self.source}: ", *self.args) if self.source else self.args)

    def __str__(self) -> str:
        return str(self.wording)

    def about(self, source: str) -> Self:
        """Return this error with the name of its source, unless it has one.

        Examples
        --------
        >>> print(RecordError("is empty").about("bump.csv").about("test 1"))
        bump.csv: is empty
        """
        named = copy.copy(self)
        named.source = self.source or source
        return named


class InputError(SuspidError, ValueError):
    """A value cannot be used; the message says which, why, and what to do.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> try:
    ...     quarter_car(chassis_mass=-400, tire_mass=40, chassis_stiffness=20e3,
    ...                 tire_stiffness=200e3, chassis_damping=1500)
    ... except InputError as error:
    ...     print(error)
    mass 'chassis' = -400 kg must be positive
    """


class RecordError(InputError):
    """A record or its file cannot be used.

    Examples
    --------
    >>> from suspid import identify
    >>> try:
    ...     identify([0.0, 1.0, 0.5])
    ... except RecordError as error:
    ...     print(error)
    an array has no time: write as_record(data, fs=...) with the sampling rate in Hz, ...
    """


class RecordWarning(UserWarning):
    r"""Something was repaired in a record while it was read, or was noticed and left as it is.

    Examples
    --------
    >>> import numpy as np
    >>> import tempfile, warnings
    >>> from pathlib import Path
    >>> from suspid import read_record
    >>> with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings(record=True) as said:
    ...     warnings.simplefilter("always")
    ...     path = Path(folder, "bump.csv")
    ...     rows = [f"{k / 100},{np.cos(k / 5) if k - 40 else -9999}" for k in range(200)]
    ...     _ = path.write_text("\n".join(["time [s],seat [m]", *rows]))
    ...     record = read_record(path)
    >>> issubclass(said[0].category, RecordWarning)
    True
    """


class IdentificationError(SuspidError):
    """The requested modes could not be found.

    Attributes
    ----------
    found : ModalSet or None
        The modes that were found.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import as_record, identify
    >>> t = np.arange(400) / 100
    >>> noise = 1e-3 * np.random.default_rng(1).standard_normal(t.size)
    >>> record = as_record(np.exp(-t) * np.cos(20 * t) + noise, timepts=t)
    >>> try:
    ...     identify(record, modes=3)
    ... except IdentificationError as error:
    ...     print(error, error.found.wn.round(1))
    3 modes were requested, 1 could be found, at 20.03 rad/s; no other pole of that fit is a mode: ... [20.]
    """

    def __init__(self, *parts: object, found: ModalSet | None = None) -> None:
        super().__init__(*parts)
        self.found = found


class _NoSuspensionError(SuspidError):
    """No suspension explains what was measured.

    Attributes
    ----------
    best : Suspension or None
        The best suspension found.
    """

    def __init__(self, *parts: object, best: Suspension | None = None) -> None:
        super().__init__(*parts)
        self.best = best


class ReconstructionError(_NoSuspensionError):
    """No springs and dampers explain the modes; ``.best`` is the best suspension found, or None.

    Examples
    --------
    >>> from suspid import ModalSet, quarter_car, reconstruct
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> try:
    ...     reconstruct(ModalSet.from_wn_zeta([1.0, 2.0], [0.9, 0.001]), car)
    ... except ReconstructionError as error:
    ...     print(error)
    no suspension of this topology and these masses with k > 0 and c >= 0 was found to have these modes: ...
    """


class EstimationError(_NoSuspensionError):
    """The records do not determine the suspension, or none explains them; ``.best`` is the best one found, or None.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import as_record, estimate, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> record = as_record(np.zeros(200), fs=100, channels=["chassis"])
    >>> try:
    ...     estimate(record, car)
    ... except EstimationError as error:
    ...     print(error)
    the records do not determine chassis.stiffness, tire.stiffness, chassis.damping, tire.damping: ...; fix one
    with fixed=…, state nominal_std=…, or measure at more coordinates
    """
