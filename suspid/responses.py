"""Responses of python-control that can be printed; apart from `signals`, since python-control takes long to import."""

from __future__ import annotations

import control

from suspid.files import printable
from suspid.values import samples_in_words


class Response(control.TimeResponseData):  # type: ignore[misc]  # python-control states no types
    """A `control.TimeResponseData` whose ``str()`` has its length, rate and channels, where the base class has none."""

    def __str__(self) -> str:
        title = f"{self.title}: " if self.title else ""
        return printable(f"{title}{samples_in_words(self.time, self.output_labels)}")

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self}>"
