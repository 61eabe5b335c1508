"""Stamps of logs whose milliseconds follow a comma, as Python writes them, before numbers that commas separate."""

from __future__ import annotations

import re

# The date, the time of day, its milliseconds, and a number that another follows.
LOGGED = re.compile(rb"(?m)^(\d{4}-\d\d-\d\d[ T]\d\d:\d\d:\d\d),(\d{3}) {1,9}(?=[-+]?[\d.][^,\s]{0,40} {0,9},)")


def with_point_stamps(text: bytes) -> bytes:
    r"""Return a text with a point before the milliseconds of such stamps, and a comma behind, if it begins with one.

    Examples
    --------
    >>> with_point_stamps(b"2021-12-27 18:06:19,663 -0.5, 2\n2021-12-27 18:06:19,673 -0.7, 2\n")
    b'2021-12-27 18:06:19.663,-0.5, 2\n2021-12-27 18:06:19.673,-0.7, 2\n'
    """
    return LOGGED.sub(rb"\1.\2,", text) if text[19:20] == b"," and LOGGED.match(text) else text
