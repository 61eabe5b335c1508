"""Which pictures a report has."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from suspid.errors import SuspidError
from suspid.model import ModalSet
from suspid.reporting.axes import without_legend
from suspid.reporting.plot_amplitude import draw_amplitudes
from suspid.reporting.plot_entropy import plot_entropy
from suspid.reporting.plot_fit import plot_fit
from suspid.reporting.plot_identification import ABREAST, MOST_RIDGES
from suspid.reporting.plot_recording import plot_recording
from suspid.reporting.plot_scalogram import plot_scalogram
from suspid.reporting.plot_shapes import plot_shapes
from suspid.reporting.plot_skeletons import plot_skeletons
from suspid.reporting.plot_spectra import plot_spectra
from suspid.reporting.plot_stabilization import plot_stabilization
from suspid.reporting.shape_groups import shape_groups
from suspid.reporting.svg import page_style, svg_of
from suspid.reporting.thinning import first_cycles
from suspid.samples import held
from suspid.signals import as_signal
from suspid.units import Second
from suspid.wavelets import Ridge
from suspid.words import MOST_LISTED

if TYPE_CHECKING:
    import control
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from suspid.cleaning import Cleaned
    from suspid.decays import Decay
    from suspid.identification import Identification, Repeats
    from suspid.wavelets import BandwidthSearch

# Width of a picture that stands beside others, and of one across the whole page [inch of 96 pixels]: the first fits a
# phone, the second a screen and paper.
NARROW, WIDE = 4.2, 9.0
# Channels that the page shows at most; the JSON has all.
MOST_CHANNELS = 24


@dataclass(frozen=True, kw_only=True, slots=True)
class Picture:
    """A picture as SVG: for a phone or beside others, and across the whole page if that is drawn as well."""

    narrow: str
    wide: str = ""


@dataclass(frozen=True, kw_only=True, slots=True)
class Pictures:
    """All pictures of a report, in the order in which the page shows them."""

    scalogram: Picture
    entropy: Picture | None
    fits: tuple[tuple[Picture, ...], ...]
    stabilization: Picture | None
    spectra: tuple[Picture, ...]
    shapes: tuple[Picture, ...]
    skeletons: tuple[Picture, ...]
    amplitudes: Picture | None
    joint_amplitudes: Picture | None
    overviews: tuple[Picture, ...]


def pictures_of(
    found: Identification,
    *,
    cleaned: Cleaned | None,
    decays: Sequence[Decay],
    units: Sequence[str],
    used: int | None,
    repeats: Repeats | None = None,
) -> Pictures:
    """Draw all pictures of a report."""
    with page_style():
        return Pictures(
            scalogram=_scalogram(found),
            entropy=_entropy(found),
            fits=tuple(_fits(found, units)),
            stabilization=_stabilization(found),
            spectra=tuple(_spectra(found, units)),
            shapes=tuple(shape_pictures(found.modes, units)),
            skeletons=tuple(_skeleton(ridge, k) for k, ridge in enumerate(found.ridges[:MOST_RIDGES], 1)),
            amplitudes=_amplitudes(found),
            joint_amplitudes=None if repeats is None else _joint_amplitudes(repeats),
            overviews=tuple(_overviews(found, cleaned, decays, used)),
        )


def picture(
    draw: Callable[[Figure], None], *, name: str, described: str, height: float, wide_height: float | None = None
) -> Picture:
    """Return a picture that a function draws on an empty figure.

    Parameters
    ----------
    draw : callable
        It is called with a figure, and with a second one of the width of the page if there is a ``wide_height``.
    name : str
        A name that no other picture of the page has.
    described : str
        What the picture shows, for readers who do not see it. No text from a file.
    height, wide_height : float
        Heights of the narrow and of the wide figure [inch].

    Returns
    -------
    Picture
        The picture.
    """
    from matplotlib.figure import Figure

    sizes = {"narrow": (NARROW, height)} | ({} if wide_height is None else {"wide": (WIDE, wide_height)})
    drawn = {}
    for kind, size in sizes.items():
        figure = Figure(figsize=size, layout="constrained")
        draw(figure)
        drawn[kind] = svg_of(figure, name=f"{name}-{kind}", described=described)
    return Picture(narrow=drawn["narrow"], wide=drawn.get("wide", ""))


def _plain(ax: Axes) -> Axes:
    """Return Axes without what the page says in its own words: legend and title."""
    ax.set_title("", loc="left")
    return without_legend(ax)


def _scalogram(found: Identification) -> Picture:
    described = f"Scalogram of all channels with {len(found.ridges)} ridges"
    draw = partial(_draw_scalogram, found)
    return picture(draw, name="scalogram", described=described, height=3.2, wide_height=3.9)


def _draw_scalogram(found: Identification, figure: Figure) -> None:
    ax = figure.subplots()
    _plain(plot_scalogram(found.scalogram, ax=ax, ridges=found.ridges, modes=found.modes, colorbar=False))


def _entropy(found: Identification) -> Picture | None:
    search = found.bandwidth_search
    # Two bandwidths make no curve.
    if search is None or len(search.candidates) < 3:
        return None
    draw = partial(_draw_entropy, search)
    return picture(draw, name="entropy", described="Wavelet entropy against bandwidth", height=1.9)


def _draw_entropy(search: BandwidthSearch, figure: Figure) -> None:
    plot_entropy(search, ax=figure.subplots())


def _fits(found: Identification, units: Sequence[str]) -> Iterator[tuple[Picture, ...]]:
    """Draw the record of each channel: the whole, and its beginning where that holds the first cycles of a mode."""
    signal, span = as_signal(held(found, "response")), first_cycles(found)
    spans = [None] if span is None else [None, span]
    for k, (name, unit) in enumerate(zip(signal.channels[:MOST_CHANNELS], units, strict=False)):
        described = f"Record, fit and residual of channel {k + 1}"
        yield tuple(
            picture(
                partial(_draw_fit, found, name, unit, between),
                name=f"fit-{k}-{i}",
                described=f"{described}, beginning enlarged" if between else described,
                height=1.75,
            )
            for i, between in enumerate(spans)
        )


def _draw_fit(
    found: Identification, name: str, unit: str, between: tuple[Second, Second] | None, figure: Figure
) -> None:
    ax = figure.subplots()
    plot_fit(found, axes=[ax], channels=[name], span=between, units=[unit])
    _plain(ax).set_title("whole record" if between is None else "beginning, enlarged", loc="left")


def _stabilization(found: Identification) -> Picture | None:
    """Draw the poles of every order, where the record is long enough for them."""
    described = "Poles of every model order over frequency, marked where they are stable"
    try:
        return picture(partial(_draw_stabilization, found), name="stabilization", described=described, height=2.8,
                       wide_height=3.2)  # fmt: skip
    except SuspidError:
        return None


def _draw_stabilization(found: Identification, figure: Figure) -> None:
    _plain(plot_stabilization(found, figure.subplots()))


def _spectra(found: Identification, units: Sequence[str]) -> Iterator[Picture]:
    """Draw the spectra of each channel, of its fit and of the residual."""
    signal = as_signal(found.response)
    for k, (name, unit) in enumerate(list(zip(signal.channels, units, strict=False))[:MOST_LISTED]):
        described = f"Spectra of channel {k + 1}, of its fit and of the residual"
        yield picture(partial(_draw_spectra, found, name, unit), name=f"spectra-{k}", described=described, height=1.75)


def _draw_spectra(found: Identification, name: str, unit: str, figure: Figure) -> None:
    ax = figure.subplots()
    plot_spectra(found, axes=[ax], channels=[name], units=[unit])
    _plain(ax).set_title("spectrum", loc="left")


def shape_pictures(modes: ModalSet, units: Sequence[str] | None = None) -> Iterator[Picture]:
    """Draw the shapes of all modes, some abreast; nothing where there are none or one channel."""
    if modes.shapes is None or len(modes.channels) < 2:
        return
    for first in range(0, len(modes), ABREAST):
        block = slice(first, first + ABREAST)
        some = ModalSet(poles=modes.poles[block], shapes=modes.shapes[:, block], channels=modes.channels)
        described = f"Shapes of modes {first + 1} to {first + len(some)}"
        height = 0.6 + 0.22 * len(modes.channels)
        yield picture(partial(_draw_shapes, some, units), name=f"shapes-{first}", described=described, height=height)


def _draw_shapes(modes: ModalSet, units: Sequence[str] | None, figure: Figure) -> None:
    ax = plot_shapes(modes, ax=figure.subplots(), units=units)
    without_legend(ax)
    groups = shape_groups(modes, units)
    if len(groups) < 2 and not groups[0].brought:
        ax.set_title("", loc="left")  # the page explains shapes of one quantity itself


def _skeleton(ridge: Ridge, number: int) -> Picture:
    described = f"Modulus and phase along ridge {number} with the fitted lines"
    return picture(partial(_draw_skeleton, ridge), name=f"skeleton-{number}", described=described, height=3.1)


def _draw_skeleton(ridge: Ridge, figure: Figure) -> None:
    axes = np.asarray(figure.subplots(2, 1, sharex=True, squeeze=False, height_ratios=[3, 2]), dtype=object)
    plot_skeletons([ridge], axes=axes)
    without_legend(axes[0, 0])
    figure.align_ylabels(list(axes[:, 0]))


def _amplitudes(found: Identification) -> Picture | None:
    if not found.amplitude_dependence:
        return None
    described = "Frequency and damping of each mode against its amplitude"
    return picture(partial(draw_amplitudes, found), name="amplitudes", described=described, height=3.1)


def _joint_amplitudes(repeats: Repeats) -> Picture | None:
    if not any(each is not None for each in repeats.amplitude_dependence):
        return None
    described = "Frequency and damping of each joint mode against its amplitude, by decay"
    return picture(partial(draw_amplitudes, repeats), name="joint-amplitudes", described=described, height=3.1)


def _overviews(
    found: Identification, cleaned: Cleaned | None, decays: Sequence[Decay], used: int | None
) -> Iterator[Picture]:
    """Draw the first channels of the whole recording with its decays."""
    if cleaned is None or not decays:
        return
    units = dict(zip(as_signal(held(cleaned, "record")).channels, cleaned.units, strict=True))
    shown = [name for name in as_signal(held(found, "response")).channels if name in units][:3]
    for k, name in enumerate(shown):
        draw = partial(_draw_overview, held(cleaned, "record"), name, units[name], decays, used)
        described = f"The recording with {len(decays)} decays"
        yield picture(draw, name=f"recording-{k}", described=described, height=1.9, wide_height=2.0)


def _draw_overview(
    record: control.TimeResponseData,
    name: str,
    unit: str,
    decays: Sequence[Decay],
    used: int | None,
    figure: Figure,
) -> None:
    stretches = [(decay.start, decay.stop) for decay in decays]
    plot_recording(record, ax=figure.subplots(), channel=name, stretches=stretches, used=used, unit=unit)
