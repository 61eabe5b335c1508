"""Facts of a record and of its results, as the page states them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.reporting.numerals import digits
from suspid.reporting.page_text import plain_line
from suspid.reporting.thinning import is_whole
from suspid.samples import held
from suspid.signals import as_signal
from suspid.words import MOST_LISTED, percent

if TYPE_CHECKING:
    from suspid.identification import Identification
    from suspid.model import ModalSet
    from suspid.reconstruction import Reconstruction


def record_facts(found: Identification) -> dict[str, str]:
    """Return channels, samples, rate and times of a record."""
    signal = as_signal(held(found, "response"))
    samples = signal.values.shape[1]
    return {
        "samples": f"{samples}",
        "rate": f"{1 / signal.step:.6g} Hz",
        "length": f"{signal.duration:.4g} s",
        "start": f"{signal.start:.6g} s".replace("-", "−"),
        "end": f"{signal.start + (samples - 1) * signal.step:.6g} s".replace("-", "−"),
        "channels": f"{len(signal.channels)} channel{'s' * (len(signal.channels) > 1)}",
    }


def mode_cards(modes: ModalSet) -> list[tuple[str, str]]:
    """Return frequency [Hz] and damping ratio [1] of the first modes, for a glance."""
    pairs = zip(modes.wn.tolist(), modes.zeta.tolist(), strict=True)
    cards = [(digits(wn / (2 * np.pi), 4), digits(zeta, 3)) for wn, zeta in pairs]
    return cards[:MOST_LISTED]


def view_of(found: Identification) -> dict[str, str | bool]:
    """Return what there is to know of the transform that is shown."""
    search, view, signal = found.bandwidth_search, found.steps.signal, as_signal(found.response)
    if is_whole(found):
        shown = ""
    elif view.duration < signal.duration - view.step:
        shown = f"Of {signal.duration:.4g} s it shows the first {view.duration:.4g} s, at {1 / view.step:.4g} Hz."
    else:
        shown = f"It is computed at {1 / view.step:.4g} Hz, of the record at {1 / signal.step:.4g} Hz."
    return {
        "bandwidth": f"{found.scalogram.wavelet.bandwidth:.3g}",
        "searched": search is not None,
        "at_end": search is not None and search.at_end and len(search.candidates) > 1,
        "shown": shown,
    }


def chi_square_text(found: Reconstruction) -> str:
    """Return how well a reconstruction explains the modes."""
    if found.chi_square is None:
        return "The modes have no uncertainty: the fit is not tested."
    value = f"{found.chi_square if found.chi_square > 1e-6 else 0:.3g}"
    said = f"Chi-square {value} at {found.freedom} degree{'s' * (found.freedom != 1)} of freedom: "
    if not found.freedom:
        return said + "as many unknowns as equations, so the fit cannot be tested."
    if found.explains:
        return said + "with the springs and dampers found, the car explains the modes within their uncertainty."
    return (
        said + "this car, with its masses, does not explain the modes with any springs and dampers; the intervals "
        "are widened, and are a guess."
    )


def twin_texts(found: Reconstruction) -> list[tuple[str, str]]:
    """Return how far each twin is from the data, and what tells it apart."""
    far = [
        f"largest pole error {percent(distance)}"
        if found.chi_square is None
        else f"chi-square {distance if distance > 1e-6 else 0:.3g}"
        for distance in found.distances
    ]
    return list(zip(far, (plain_line(text) for text in found.told_apart), strict=True))


def in_bytes(size: int) -> str:
    """Return the size of a file."""
    for unit, step in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if size >= step:
            return f"{size / step:.3g} {unit} ({size} bytes)"
    return f"{size} bytes"
