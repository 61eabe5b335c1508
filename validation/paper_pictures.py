"""The content of the paper's Figures 5-16, drawn from the record of the tire."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from suspid import Identification, IdentificationError, cwt, identify, plot_entropy, plot_scalogram, plot_skeletons
from suspid.reporting.colours import Colour
from suspid.signals import as_signal
from suspid.wavelets import best_bandwidth
from validation.study import CANDIDATES, START, case_record
from validation.table2 import CASES, Case

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CHANNELS = ("tire",)
SEED = 0
# Range of the scalogram; all modes lie in it [rad/s].
SHOWN = (10.0, 160.0)
ROWS = 140
LONG_CANDIDATES = np.geomspace(1.0, 800.0, 40)
DOTS_PER_INCH = 90
PALE = "#BBBBBB"
# Colours per picture. Lines and one colour ramp need no more, and the files are a third of their size.
PALETTE = 128


def draw_all(folder: Path) -> list[Path]:
    """Draw every picture into a folder; return the files."""
    found = {case: _identified(case) for case in CASES}
    pictures = {"responses": draw_responses(), "entropy": draw_entropy(found)}
    pictures |= {case.slug: draw_case(case, identification) for case, identification in found.items()}
    return [save(figure, folder / f"paper_{name}.png") for name, figure in pictures.items()]


def draw_responses() -> Figure:
    """Draw the response, its noisy and its denoised versions: whole, and the first second."""
    figure = _figure(9.0, 9.0)
    grid = figure.subplots(len(CASES), 2, sharex="col", width_ratios=[3, 2])
    clean = as_signal(case_record(CASES[0], CHANNELS, seed=SEED))
    for case, (whole, start) in zip(CASES, grid, strict=True):
        signal = as_signal(case_record(case, CHANNELS, seed=SEED))
        for ax, until in ((whole, clean.duration), (start, 1.0)):
            kept = clean.timepts <= until
            time, case_mm, clean_mm = clean.timepts[kept], 1e3 * signal.values[0, kept], 1e3 * clean.values[0, kept]
            if case.snr_db is not None:
                ax.plot(time, case_mm, color=PALE, linewidth=2.0, label=case.name)
            ax.plot(time, clean_mm, color=Colour.BLUE, linewidth=0.8, label="original")
            if case.snr_db is not None:
                ax.plot(time, case_mm - clean_mm, color=Colour.VERMILION, linewidth=0.6, label="difference")
            ax.set_xlim(0.0, until)
        whole.set_title(case.name, loc="left")
        whole.set_ylabel("tire [mm]")
        whole.legend(loc="upper right", fontsize="small", ncols=3)
    figure.suptitle(f"Displacement of the tire after a unit impulse of velocity ({next(iter(START))} = 1 m/s)")
    for ax in grid[-1]:
        ax.set_xlabel("time [s]")
    return figure


def draw_entropy(found: dict[Case, Identification]) -> Figure:
    """Draw entropy against N for every case, and for the first one over a longer range."""
    figure = _figure(9.0, 5.6)
    grid = figure.subplots(2, 3).ravel()
    for ax, (case, identification) in zip(grid, found.items(), strict=False):
        assert identification.bandwidth_search is not None
        plot_entropy(identification.bandwidth_search, ax=ax)
        ax.set_title(f"{case.name}: N = {identification.bandwidth_search.best:g}", loc="left", fontsize="medium")
    rows = found[CASES[0]].scalogram.omega
    longer = best_bandwidth(case_record(CASES[0], CHANNELS, seed=SEED), omega=rows, candidates=LONG_CANDIDATES)
    plot_entropy(longer, ax=grid[-1])
    grid[-1].set_title(f"original, N to 800: N = {longer.best:.0f}", loc="left", fontsize="medium")
    return figure


def draw_case(case: Case, identification: Identification) -> Figure:
    """Draw the scalogram with its ridges, and below modulus and phase along each ridge with the fitted lines."""
    figure = _figure(9.0, 8.6)
    above, below = np.asarray(figure.subfigures(2, 1, height_ratios=[1, 1.25]), dtype=object)
    bandwidth = identification.scalogram.wavelet.bandwidth
    shown = cwt(identification.response, omega=np.geomspace(*SHOWN, ROWS), bandwidth=bandwidth)
    ax = above.subplots()
    plot_scalogram(shown, ax=ax, ridges=[r for r in identification.ridges if SHOWN[0] < r.omega < SHOWN[1]])
    ax.set_title(f"{case.name}: tire, N = {bandwidth:g}", loc="left")
    axes = below.subplots(2, len(identification.ridges), sharex="col", squeeze=False)
    plot_skeletons(identification.ridges, axes=axes)
    for top, ridge, wn, zeta in zip(
        axes[0], identification.ridges, identification.modes.wn, identification.modes.zeta, strict=True
    ):
        top.set_title(
            f"{wn:.3f} rad/s, {100 * zeta:.3f} %, N = {ridge.wavelet.bandwidth:g}", loc="left", fontsize="small"
        )
    return figure


def _identified(case: Case) -> Identification:
    """Return the identification by ridges with three modes, or as many as stand out."""
    record = case_record(case, CHANNELS, seed=SEED)
    for modes in (3, 2):
        try:
            return identify(record, modes=modes, method="ridge", candidates=CANDIDATES)
        except IdentificationError:
            continue
    return identify(record, modes=1, method="ridge", candidates=CANDIDATES)


def _figure(width: float, height: float) -> Figure:
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained", dpi=DOTS_PER_INCH)


def save(figure: Figure, path: Path) -> Path:
    """Write a picture; the same picture gives the same bytes."""
    from PIL import Image

    with BytesIO() as buffer:
        # Without the version of matplotlib the same picture gives the same file.
        figure.savefig(buffer, format="png", metadata={"Software": None})
        picture = (
            Image.open(buffer)
            .convert("RGB")
            .quantize(PALETTE, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
        )
    picture.save(path, optimize=True)
    return path
