"""Numbers as a page shows them: rounded by their intervals, with true minus signs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from suspid.text_tables import NOTHING as NOTHING


@dataclass(frozen=True, kw_only=True, slots=True)
class Quantity:
    """A value and half the width of its interval as texts; the latter is empty where there is none."""

    value: str
    reach: str = ""


def quantity(value: float, reach: float | None, *, digits: int = 6) -> Quantity:
    """Return a value rounded to the second digit of its interval; without one, to this number of significant digits.

    Examples
    --------
    >>> quantity(3.38582, 0.00123)
    Quantity(value='3.3858', reach='0.0012')
    >>> quantity(199876.4, 349.6)
    Quantity(value='199880', reach='350')
    """
    if reach is None or not np.isfinite(reach):
        return Quantity(value=signed(f"{value:.{digits}g}"))
    if reach <= 0:
        return Quantity(value=signed(f"{value:.{digits}g}"), reach="0")
    places = decimals(reach)
    return Quantity(value=fixed(value, places), reach=fixed(reach, places))


def digits(value: float, count: int) -> str:
    """Return a value to a number of significant digits, without an exponent; zeros at the end stay.

    Examples
    --------
    >>> digits(7.98, 4), digits(134641.2, 4), digits(0.002, 3)
    ('7.980', '134641', '0.00200')
    """
    if not np.isfinite(value) or value == 0:
        return f"{value:g}"
    return fixed(value, max(0, count - 1 - int(np.floor(np.log10(abs(value))))))


def plain(value: float) -> str:
    """Return a value with up to six significant digits, without an exponent.

    Examples
    --------
    >>> plain(1e6), plain(0.25), plain(-1234.5678)
    ('1000000', '0.25', '−1234.57')
    """
    return signed(np.format_float_positional(float(f"{value:.6g}"), trim="-")) if np.isfinite(value) else f"{value:g}"


def decimals(reach: float) -> int:
    """Return how many decimals show two significant digits of a width; fewer than none for tens and more."""
    places = 1 - int(np.floor(np.log10(reach)))
    # 0.0996 is 0.10, with one decimal less than 0.099.
    return 1 - int(np.floor(np.log10(round(reach, places))))


def fixed(value: float, places: int) -> str:
    """Return a value with a number of decimals; a negative number rounds before the point."""
    return signed(f"{round(value, places) + 0.0:.{min(max(places, 0), 15)}f}")  # a zero has no sign


def signed(text: str) -> str:
    """Return the text of a number with a true minus sign."""
    return text.replace("-", "−")
