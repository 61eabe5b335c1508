"""Text of a page: names and sentences as HTML, cut and escaped."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from suspid.files import printable
from suspid.units import in_print

if TYPE_CHECKING:
    from markupsafe import Markup


# Letters of a name that the page shows; the JSON has all.
MOST_LETTERS = 40
# An option of the command line, which browsers would break after its hyphens.
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z0-9-]*")
# Words in Hebrew, Arabic and other scripts from right to left; a number behind them would be drawn before them.
LEFTWARD = re.compile(r"{0}(?:[\s_-]+{0})*".format(r"[\u0590-\u08ff\ufb1d-\ufdff\ufe70-\ufeff]+"))


def plain_line(text: object) -> str:
    """Return a text on one line, with nothing in it that a reader does not see; the template escapes it."""
    return printable(" ".join(str(text).split()))


def sentence_html(text: object) -> Markup:
    """Return a sentence of the library as `plain_line`: units as they are printed, options unbroken, names isolated."""
    from markupsafe import Markup, escape

    text = str(escape(in_print(plain_line(text))))
    return Markup(LEFTWARD.sub(r"<bdi>\g<0></bdi>", OPTION.sub(r'<span class="option">\g<0></span>', text)))


def plain_lines(text: str) -> str:
    """Return a text line by line, with nothing in it that a reader does not see; the template escapes it."""
    return "\n".join(printable(line.replace("\t", "    ")) for line in text.splitlines())


def full_sentence(text: str) -> str:
    """Return the text with a capital and a full stop."""
    text = plain_line(text)
    return text[:1].upper() + text[1:] + "." * (not text.endswith((".", "!", "?")))


def short_name(name: str) -> str:
    """Return a name for a figure; the table of channels has the whole."""
    shown = plain_line(name)
    return shown if len(shown) <= MOST_LETTERS else f"{shown[: MOST_LETTERS - 1]}…"
