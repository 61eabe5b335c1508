"""Figures as SVG for an HTML page: the page's fonts and colours, no identifiers in common, short paths."""

from __future__ import annotations

import io
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from suspid.reporting.colours import Colour

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Size of ordinary text [pt], at the size a picture is drawn: 10 px on a phone of 360 px, 15 px at the most.
TEXT = 9.0
# Dots per inch of the scalogram's colours: two for each pixel of a phone. More enlarge the file.
DOTS_PER_INCH = 120
# Steps of a path for each point (1/72 inch): finer than any screen shows.
STEPS_A_POINT = 10
LOCAL_REFERENCE = re.compile(r"^(?:url\()?#([\w-]+)\)?$")
VARIABLES = {colour.lower(): f"var(--{colour.css})" for colour in Colour}


@contextmanager
def page_style() -> Iterator[None]:
    """Draw with matplotlib's own settings, whatever those of the user are, and with those of the page."""
    import matplotlib

    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(
            {
                "svg.fonttype": "none",
                "svg.hashsalt": "suspid",
                "font.size": TEXT,
                "axes.titlesize": TEXT,
                "axes.labelsize": TEXT,
                "axes.linewidth": 0.6,
                "xtick.major.width": 0.6,
                "ytick.major.width": 0.6,
                "figure.constrained_layout.h_pad": 0.02,
                "figure.constrained_layout.w_pad": 0.02,
            }
        )
        yield


def svg_of(figure: Figure, *, name: str, described: str) -> str:
    """Return a figure as an SVG element that stands in an HTML page.

    Colours become variables of the page, so that they follow its light, dark and printed looks; texts take its font.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The figure; drawn within `page_style`.
    name : str
        A name that no other picture of the page has; identifiers begin with it.
    described : str
        What the picture shows, for readers who do not see it.

    Returns
    -------
    str
        The element.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> with page_style():
    ...     figure = Figure(figsize=(4, 3))
    ...     _ = figure.subplots().set_title("<b>")
    ...     element = svg_of(figure, name="title", described="A title")
    >>> element.startswith('<svg'), "&lt;b&gt;" in element
    (True, True)
    """
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    engine = figure.get_layout_engine()
    if engine is not None:
        # Here and not within `savefig`, which would draw the figure once more for it.
        engine.execute(figure)
        figure.set_layout_engine("none")
    with io.StringIO() as stream:
        nothing = dict.fromkeys(("Creator", "Date", "Format", "Type"))
        # `savefig` would draw the figure once more before it writes it.
        figure.set_dpi(DOTS_PER_INCH)
        for patch in (figure.patch, *(ax.patch for ax in figure.axes)):
            patch.set(facecolor="none", edgecolor="none")
        canvas: Any = FigureCanvasSVG(figure)  # its methods have no types
        canvas.print_svg(stream, metadata=nothing)
        # What is parsed is matplotlib's own output, in which it has escaped every text.
        root = ElementTree.fromstring(stream.getvalue())
    used = {m[1] for node in root.iter() for value in node.attrib.values() if (m := LOCAL_REFERENCE.match(value))}
    return ElementTree.tostring(_as_svg(root, name, described, used), encoding="unicode")


def _as_svg(root: ElementTree.Element, name: str, described: str, used: set[str]) -> ElementTree.Element:
    top = ElementTree.Element("svg", {"viewBox": root.attrib["viewBox"], "role": "img", "aria-label": described})
    top.extend(part for child in root for part in _copied(child, name, used))
    return top


def _copied(node: ElementTree.Element, name: str, used: set[str]) -> list[ElementTree.Element]:
    """Return a node as the page needs it; a group without attributes is replaced by what it contains."""
    tag = node.tag.rpartition("}")[2]
    if tag == "style":
        return []
    attributes = _attributes(node, name, used)
    inside = [part for child in node for part in _copied(child, name, used)]
    if tag in ("g", "defs") and not inside:
        return []
    if tag == "g" and not attributes:
        return inside
    new = ElementTree.Element(tag, attributes)
    new.text = node.text if tag == "text" or (node.text or "").strip() else None
    new.extend(inside)
    return [new]


def _attributes(node: ElementTree.Element, name: str, used: set[str]) -> dict[str, str]:
    attributes = {}
    for key, value in node.attrib.items():
        short = key.rpartition("}")[2]
        if short == "id" and value not in used:
            continue
        reference = LOCAL_REFERENCE.match(value)
        if short == "id":
            value = f"{name}-{value}"
        elif reference:
            value = value.replace("#", f"#{name}-", 1)
        elif short in VALUES:
            value = VALUES[short](value)
        if value:
            attributes[short] = value
    return attributes


def _style(value: str) -> str:
    """Return declarations with the page's colours and without a font."""
    parts = [part.partition(":") for part in value.split(";")]
    pairs = [(key.strip(), text.strip()) for key, _, text in parts]
    return ";".join(f"{key}:{VARIABLES.get(text, text)}" for key, text in pairs if key not in ("", "font-family"))


def _path(value: str) -> str:
    """Return a path of straight lines in relative steps of whole units; any other path as it is.

    Examples
    --------
    >>> _path("M 0 0 L 1.04 2.01 L 1.04 2.01 L 2 2 z")
    'M0 0l1 2 1 0z'
    """
    tokens = value.split()
    if set(filter(str.isalpha, tokens)) - {"M", "L", "z"}:
        return " ".join(tokens)
    out, at, last = [], (0, 0), ""
    index = 0
    while index < len(tokens):
        command = tokens[index]
        if command == "z":
            out.append("z")
            index, last = index + 1, command
            continue
        to = round(STEPS_A_POINT * float(tokens[index + 1])), round(STEPS_A_POINT * float(tokens[index + 2]))
        step = to[0] - at[0], to[1] - at[1]
        if command == "M":
            out.append(f"M{_short(to[0])} {_short(to[1])}")
        elif any(step) or last == "M":
            out.append(f"{' ' if last == 'L' else 'l'}{_short(step[0])} {_short(step[1])}")
        else:
            index += 3
            continue
        index, at, last = index + 3, to, command
    return "".join(out)


def _short(steps: int) -> str:
    """Return a number of steps in points, with no more characters than it needs."""
    text = f"{steps / STEPS_A_POINT:g}"
    return text.replace("0.", ".", 1) if text.startswith(("0.", "-0.")) else text


def _transform(value: str) -> str:
    """Return a transformation, none where it turns by nothing."""
    return "" if value.startswith("rotate(-0 ") else value


def _number(value: str) -> str:
    return f"{float(value):.6g}"


VALUES: dict[str, Callable[[str], str]] = {
    "style": _style,
    "d": _path,
    "transform": _transform,
    "x": _number,
    "y": _number,
}
