"""Colours of the pictures, for light paper and for a dark screen."""

from __future__ import annotations

from dataclasses import dataclass

# Okabe and Ito's colours, distinct for readers of any colour vision; yellow is left out, as it fades on paper.
BLUE, VERMILION, GREEN, PURPLE = "#0072B2", "#D55E00", "#009E73", "#CC79A7"
ORANGE, SKY = "#E69F00", "#56B4E9"
BLACK, WHITE = "#000000", "#FFFFFF"
GREY, PALE, SHADE, PALE_BLUE, PALE_GREEN = "#777777", "#B4B4B4", "#E6E6E6", "#A6CEE3", "#CFE6D9"
# Colours of the channels, in their order; they repeat after the eighth.
COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK, GREY)


@dataclass(frozen=True, kw_only=True, slots=True)
class Tone:
    """One colour of the pictures: its name in the page's style sheet, on light paper, and on a dark screen."""

    name: str
    light: str
    dark: str


# Every colour that a picture may have: the page gives each its dark counterpart. A test finds colours without one.
TONES = (
    Tone(name="blue", light=BLUE, dark="#56B4E9"),
    Tone(name="vermilion", light=VERMILION, dark="#FF9147"),
    Tone(name="green", light=GREEN, dark="#3CCF9F"),
    Tone(name="purple", light=PURPLE, dark="#E59FC6"),
    Tone(name="orange", light=ORANGE, dark="#F0B72F"),
    Tone(name="sky", light=SKY, dark="#9FD6FF"),
    Tone(name="black", light=BLACK, dark="#E6E9EC"),
    Tone(name="white", light=WHITE, dark="#15191E"),
    Tone(name="grey", light=GREY, dark="#9AA4AE"),
    Tone(name="pale", light=PALE, dark="#6B747D"),
    Tone(name="shade", light=SHADE, dark="#2B333B"),
    Tone(name="pale-blue", light=PALE_BLUE, dark="#24557A"),
    Tone(name="pale-green", light=PALE_GREEN, dark="#1D4634"),
)
