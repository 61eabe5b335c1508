"""Colours of the pictures, for light paper and for a dark screen."""

from __future__ import annotations

from enum import StrEnum


class Colour(StrEnum):
    """A colour on light paper, as matplotlib takes it; ``dark`` is its counterpart on a dark screen.

    They are Okabe and Ito's, distinct for readers of any colour vision; yellow is left out, as it fades on paper. A
    picture may have no other: a test finds colours without a counterpart.

    Examples
    --------
    >>> Colour.PALE_BLUE == "#A6CEE3", Colour.PALE_BLUE.css
    (True, 'pale-blue')
    """

    dark: str

    def __new__(cls, light: str, dark: str) -> Colour:
        """Make a member whose value is the colour on light paper."""
        member = str.__new__(cls, light)
        member._value_ = light
        member.dark = dark
        return member

    BLUE = "#0072B2", "#56B4E9"
    VERMILION = "#D55E00", "#FF9147"
    GREEN = "#009E73", "#3CCF9F"
    PURPLE = "#CC79A7", "#E59FC6"
    ORANGE = "#E69F00", "#F0B72F"
    SKY = "#56B4E9", "#9FD6FF"
    BLACK = "#000000", "#E6E9EC"
    WHITE = "#FFFFFF", "#15191E"
    GREY = "#777777", "#9AA4AE"
    PALE = "#B4B4B4", "#6B747D"
    SHADE = "#E6E6E6", "#2B333B"
    PALE_BLUE = "#A6CEE3", "#24557A"
    PALE_GREEN = "#CFE6D9", "#1D4634"

    @property
    def css(self) -> str:
        """Name of the colour in the style sheet of a page."""
        return self.name.lower().replace("_", "-")


# Colours of the channels, in their order; they repeat after the eighth.
CHANNEL_COLOURS = (
    Colour.BLUE,
    Colour.VERMILION,
    Colour.GREEN,
    Colour.PURPLE,
    Colour.ORANGE,
    Colour.SKY,
    Colour.BLACK,
    Colour.GREY,
)
