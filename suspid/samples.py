"""Records inside the library; converted to `control.TimeResponseData` where a user takes them.

python-control takes longer to import than everything else that a command needs. Until a user asks for a response, a
record is therefore held as `Samples`, which have the attributes of a response that the library reads.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from suspid.signals import Signal, checked
from suspid.units import RealArray

if TYPE_CHECKING:
    import control


@dataclass(frozen=True, kw_only=True, eq=False)
class Samples:
    """What a response of one trace is made of.

    Parameters
    ----------
    time : ndarray (sample,)
        Time of each sample [s].
    y : ndarray (channel, sample)
        The samples.
    output_labels : list of str
        Names of the channels.
    inputs : ndarray (input, sample) or None
        The inputs, if there are any.
    input_labels : list of str or None
        Their names.
    title : str or None
        What the record is called.
    """

    time: RealArray
    y: RealArray
    output_labels: list[str]
    inputs: RealArray | None
    input_labels: list[str] | None
    title: str | None

    def __getstate__(self) -> dict[str, Any]:
        # What follows from the fields is not written along with them.
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @cached_property
    def signal(self) -> Signal:
        """The samples as a signal, checked once."""
        return checked(self)

    @cached_property
    def response(self) -> control.TimeResponseData:
        """The record as python-control has it, squeezed if it has one channel and at most one input."""
        from suspid.responses import Response

        return Response(
            time=self.time,
            outputs=self.y,
            output_labels=self.output_labels,
            inputs=self.inputs,
            input_labels=self.input_labels,
            issiso=len(self.output_labels) == 1 and len(self.input_labels or "1") == 1,
            title=self.title,
        )


class AsResponse:
    """A field of a frozen type that may be given `Samples`, and is read as a `control.TimeResponseData`.

    `held` returns what was given.

    Examples
    --------
    >>> @dataclass(frozen=True)
    ... class Found:
    ...     record: Any = AsResponse("record")
    >>> found = Found(as_samples(np.arange(2.0), np.ones((1, 2)), ["seat"]))
    >>> type(held(found, "record")).__name__, type(found.record).__name__
    ('Samples', 'Response')
    """

    def __init__(self, name: str) -> None:
        self._key = _key(name)

    def __get__(self, instance: object, owner: type | None = None) -> control.TimeResponseData:
        if instance is None:
            # A dataclass takes what the class has as the default: there is none.
            raise AttributeError(self._key)
        given = vars(instance)[self._key]
        return given.response if isinstance(given, Samples) else given

    def __set__(self, instance: object, value: Any) -> None:
        vars(instance)[self._key] = value


def held(instance: object, name: str) -> Any:
    """Return what a field of kind `AsResponse` was given: `Samples` or a response."""
    return vars(instance)[_key(name)]


def as_samples(
    timepts: RealArray,
    values: RealArray,
    channels: Sequence[str],
    *,
    title: str = "",
    inputs: Mapping[str, RealArray] | None = None,
    copied: bool = True,
) -> Samples:
    """Return samples (channel, sample) and inputs by name as a record; the arrays are copied if others have them."""
    taken = np.array if copied else np.asarray
    return Samples(
        time=taken(timepts, float),
        y=taken(values, float),
        output_labels=list(channels),
        inputs=np.array(list(inputs.values()), float) if inputs else None,
        input_labels=list(inputs) if inputs else None,
        title=title or None,
    )


def _key(name: str) -> str:
    return f"_{name}"
