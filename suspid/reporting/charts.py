"""Charts as values: curves, shades and ticks in shares of a plot's width and height, whatever size it is shown at.

The page that shows a chart sets its text and stretches its curves, so that type and lines keep their size on a phone
and on paper, and take the colours of the page, light or dark. No name is written into a picture.
"""

from __future__ import annotations

import base64
import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from suspid.reporting.thinning import extremes
from suspid.units import RealArray

# Units of a path over the width and the height of a plot.
WIDTH, HEIGHT = 2000, 1000
# Pieces of a line of which the extremes are drawn: two to a pixel of half a page on a sharp screen.
PIECES = 500
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True, kw_only=True, slots=True)
class Tick:
    """A text at a place on an axis, as a share of its length from the left or from below."""

    at: float
    text: str


@dataclass(frozen=True, kw_only=True, slots=True)
class Curve:
    """A line or a filled shape, as an SVG path on `WIDTH` by `HEIGHT`, and the name of its looks."""

    path: str
    style: str


@dataclass(frozen=True, kw_only=True, slots=True)
class Band:
    """A shaded stretch of the horizontal axis, from and to in shares of it, perhaps with a text in a row from above."""

    start: float
    stop: float
    style: str
    text: str = ""
    row: int = 0


@dataclass(frozen=True, kw_only=True, slots=True)
class Image:
    """A picture that fills a plot, as data URIs for a light and for a dark page."""

    light: str
    dark: str


@dataclass(frozen=True, kw_only=True, slots=True)
class Chart:
    """A plot with its axes; see the module."""

    title: str
    described: str
    x_label: str
    y_label: str
    x_ticks: tuple[Tick, ...]
    y_ticks: tuple[Tick, ...]
    curves: tuple[Curve, ...] = ()
    bands: tuple[Band, ...] = ()
    image: Image | None = None
    right_label: str = ""
    right_ticks: tuple[Tick, ...] = ()
    marks: tuple[Tick, ...] = ()


@dataclass(frozen=True, kw_only=True, slots=True)
class Scale:
    """An axis from ``low`` to ``high``, perhaps logarithmic."""

    low: float
    high: float
    log: bool = False

    def share(self, values: RealArray | Sequence[float]) -> RealArray:
        """Return where values stand, as shares of the axis.

        Examples
        --------
        >>> Scale(low=1.0, high=100.0, log=True).share([1.0, 10.0])
        array([0. , 0.5])
        """
        low, high, at = self.low, self.high, np.asarray(values, float)
        if self.log:
            low, high, at = np.log(low), np.log(high), np.log(np.maximum(at, np.finfo(float).tiny))
        return np.asarray((at - low) / (high - low))

    def ticks(self, *, most: int = 6) -> tuple[Tick, ...]:
        """Return round values on the axis with their texts."""
        values = self.round_values(most)
        return tuple(
            Tick(at=float(at), text=_plain(value)) for at, value in zip(self.share(values), values, strict=True)
        )

    def round_values(self, most: int) -> list[float]:
        """Return at most so many round values: 1, 2, 5 of each decade, or evenly spaced."""
        if self.log and self.high / self.low > 8:
            low, high = int(np.floor(np.log10(self.low))), int(np.ceil(np.log10(self.high)))
            for digits in ((1, 2, 5), (1, 3), (1,)):
                values = [d * 10.0**e for e in range(low, high + 1) for d in digits]
                values = [v for v in values if self.low <= v <= self.high]
                if len(values) <= most:
                    return values
            return values[:: -(-len(values) // most)]
        span = self.high - self.low
        step = next(s for s in _steps(span / most) if span / s <= most)
        first = int(np.ceil(self.low / step - 1e-9))
        last = int(np.floor(self.high / step + 1e-9))
        return [round(k * step, 12 - int(np.floor(np.log10(step)))) for k in range(first, last + 1)]


def labelled(scale: Scale, unit: str, *, most: int = 5) -> tuple[str, tuple[Tick, ...]]:
    """Return ticks of few digits and the unit they are in, with a power of a thousand where that keeps them short.

    Examples
    --------
    >>> unit, ticks = labelled(Scale(low=0.0, high=4e-6), "m")
    >>> unit, [tick.text for tick in ticks]
    ('10⁻⁶ m', ['0', '1', '2', '3', '4'])
    """
    largest = max(abs(scale.low), abs(scale.high))
    power = 3 * int(np.floor(np.log10(largest) / 3)) if largest > 0 else 0
    power = 0 if -1 <= np.log10(max(largest, 1e-300)) < 4 else power
    values = scale.round_values(most)
    ticks = tuple(
        Tick(at=float(at), text=_plain(value / 10.0**power))
        for at, value in zip(scale.share(values), values, strict=True)
    )
    return (f"{power_of_ten(power)} {unit}".rstrip() if power else unit), ticks


def power_of_ten(exponent: int) -> str:
    """Return ten to that power, as it is written.

    Examples
    --------
    >>> power_of_ten(-3)
    '10⁻³'
    """
    return f"10{str(exponent).translate(SUPERSCRIPT)}"


def decades(scale: Scale, *, most: int = 5) -> tuple[Tick, ...]:
    """Return ticks at powers of ten; where there are fewer than two, at round values."""
    low, high = int(np.ceil(np.log10(scale.low))), int(np.floor(np.log10(scale.high)))
    if high - low < 1:
        return scale.ticks(most=most)
    exponents = range(low, high + 1, -(-(high - low + 1) // most))
    shares = scale.share([10.0**e for e in exponents])
    return tuple(Tick(at=float(at), text=power_of_ten(e)) for at, e in zip(shares, exponents, strict=True))


def line(x: RealArray, y: RealArray, across: Scale, up: Scale, style: str, *, pieces: int = PIECES) -> Curve:
    """Return a line through samples; of many, through the extremes of each piece. It breaks where one is NaN."""
    kept_x, kept_y = extremes(x, y, pieces=pieces)
    right, down = _places(kept_x, kept_y, across, up)
    return Curve(path="".join(_piece(right[run], down[run]) for run in _runs(np.isfinite(kept_y))), style=style)


def area(x: RealArray, y: RealArray, across: Scale, up: Scale, style: str) -> Curve:
    """Return the filled shape within a closed line."""
    return Curve(path=f"{_piece(*_places(x, y, across, up))}z", style=style)


def image(indices: NDArray[np.uint8], light: NDArray[np.uint8], dark: NDArray[np.uint8]) -> Image:
    """Return a picture (row from above, column) of colours by number, in two palettes (number, RGB)."""
    rows, columns = indices.shape
    raw = np.concatenate([np.zeros((rows, 1), np.uint8), indices], axis=1).tobytes()
    head = _chunk(b"IHDR", struct.pack(">IIBBBBB", columns, rows, 8, 3, 0, 0, 0))
    body = _chunk(b"IDAT", zlib.compress(raw, 9)) + _chunk(b"IEND", b"")
    both = [
        "data:image/png;base64,"
        + base64.b64encode(b"\x89PNG\r\n\x1a\n" + head + _chunk(b"PLTE", palette.tobytes()) + body).decode("ascii")
        for palette in (light, dark)
    ]
    return Image(light=both[0], dark=both[1])


def palette(anchors: Sequence[str], count: int) -> NDArray[np.uint8]:
    """Return colours evenly between anchors such as ``"#ffffff"``, (number, RGB).

    Examples
    --------
    >>> palette(["#000000", "#0000ff"], 3).tolist()
    [[0, 0, 0], [0, 0, 128], [0, 0, 255]]
    """
    fixed = np.array([[int(colour[i : i + 2], 16) for i in (1, 3, 5)] for colour in anchors], float)
    at = np.linspace(0, len(anchors) - 1, count)
    mixed = [np.interp(at, np.arange(len(anchors)), fixed[:, part]) for part in range(3)]
    return np.round(np.stack(mixed, axis=1)).astype(np.uint8)


def _chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def _steps(least: float) -> list[float]:
    decade = 10.0 ** np.floor(np.log10(least))
    return [float(s * decade) for s in (1, 2, 2.5, 5, 10, 20) if s * decade >= least * (1 - 1e-9)]


def _plain(value: float) -> str:
    return f"{value:.10g}".replace("-", "−")


def _places(x: RealArray, y: RealArray, across: Scale, up: Scale) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return units of the path; what lies far off the plot is drawn just off it."""
    right = np.clip(across.share(x), -1, 2) * WIDTH
    down = (1 - np.clip(np.nan_to_num(up.share(y)), -1, 2)) * HEIGHT
    return np.round(right).astype(np.intp), np.round(down).astype(np.intp)


def _runs(good: NDArray[np.bool_]) -> list[slice]:
    ends = np.flatnonzero(np.diff(np.concatenate([[False], good, [False]]).astype(int)))
    return [slice(int(start), int(stop)) for start, stop in pairwise(ends) if good[start]]


def _piece(right: NDArray[np.intp], down: NDArray[np.intp]) -> str:
    """Return a path of relative steps, those of no length left out."""
    steps = np.stack([np.diff(right), np.diff(down)], axis=1)
    steps = steps[np.any(steps != 0, axis=1)]
    if not len(steps):
        return f"M{right[0]} {down[0]}h1"
    return f"M{right[0]} {down[0]}l" + " ".join(f"{dx} {dy}" for dx, dy in steps.tolist())
