"""Responses of python-control that can be printed; apart from `signals`, since python-control takes long to import."""

from __future__ import annotations

from typing import TYPE_CHECKING

from suspid.files import printable
from suspid.values import samples_in_words

if TYPE_CHECKING:
    from suspid.units import RealArray

    class TimeResponseData:
        """What is used of `control.TimeResponseData`: python-control states no types."""

        title: str | None
        time: RealArray
        output_labels: list[str]

        def __init__(self, *args: object, **kwargs: object) -> None: ...
else:
    from control import TimeResponseData


class Response(TimeResponseData):
    """A `control.TimeResponseData` whose ``str()`` has its length, rate and channels, where the base class has none."""

    def __str__(self) -> str:
        title = f"{self.title}: " if self.title else ""
        return printable(f"{title}{samples_in_words(self.time, self.output_labels)}")

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self}>"
