"""Power spectra of a record, of its fit and of the residual."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.arguments import explained
from suspid.errors import InputError
from suspid.identification import Identification
from suspid.levels import EXACT
from suspid.reporting.axes import (
    IN_VIEW,
    checked_grid,
    entitle,
    frequency_ticks,
    key_above,
    label_below,
    position,
    shown,
    thinned,
)
from suspid.reporting.channel_units import channel_unit
from suspid.reporting.colours import Colour
from suspid.results import check_kind
from suspid.signals import as_signal
from suspid.units import Hertz, RealArray
from suspid.words import count

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from suspid.greybox import Estimate
    from suspid.model import ModalSet

# Stretches that are averaged at least.
STRETCHES = 8

# Lowest density in view, over the median of the residual: single values of a periodogram fall far below it.
BELOW_NOISE = 0.01

# Lowest frequency in view, below the lowest mode, and highest, above a line of the residual: both next to the axis.
BELOW_MODES, BESIDE_LINE = 20.0, 1.2

# Chance of white noise to widen the view by its highest value.
CHANCE = 1e-3

# Letters of a unit up to which a label has room for it.
SHORT_UNIT = 10


@explained
def plot_spectra(
    found: Estimate | Identification,
    *,
    axes: Sequence[Axes] | NDArray[np.object_],
    record: int = 0,
    channels: Sequence[str] | None = None,
    units: Sequence[str] | None = None,
) -> None:
    """Draw the power spectral density of each channel of a record, of its fit and of the residual.

    The densities of an estimate are Welch's, of Hann windows over an eighth of the record or more of them. That of a
    decay that was identified is the periodogram of the whole, because a window would take its beginning away.

    Parameters
    ----------
    found : Estimate or Identification
        What was found.
    axes : (channel,) of matplotlib.axes.Axes
        Where to draw.
    record : int
        Which of the records of an estimate, from 0 on.
    channels : sequence of str, optional
        The channels to draw. Default: all.
    units : sequence of str, optional
        Their units. Default: those that the car of an estimate gives them; of an identification not known.

    Raises
    ------
    InputError
        If the numbers of Axes and channels differ, or there is no such channel or record.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from suspid import add_noise, estimate, free_decay, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> response = free_decay(car, np.arange(0, 3, 0.005), initial_state={"v_tire": 1.0})
    >>> noisy = add_noise(response, snr_db=30.0, rng=np.random.default_rng(1))
    >>> axes = Figure().subplots(2)
    >>> plot_spectra(estimate(noisy, car, fixed=["tire.damping"]), axes=axes)
    >>> axes[1].get_xlabel()
    'frequency [Hz]'
    """
    check_kind(found, {"Estimate": "estimate", "Identification": "identify"})
    decay = isinstance(found, Identification)
    if not isinstance(found, Identification) and not 0 <= record < len(found.residual):
        raise InputError(f"{record=}: {no_such_record(found)}")
    left = as_signal(found.residual if isinstance(found, Identification) else found.residual[record])
    fitted = as_signal(found.fitted if isinstance(found, Identification) else found.fitted[record])
    names = left.channels if channels is None else channels
    drawn = checked_grid(axes, (len(names),))
    for ax, name, unit in zip(drawn, names, units or [""] * len(names), strict=True):
        k = position(name, left.channels)
        fit, residual = fitted.values[k], left.values[k]
        band = None if isinstance(found, Identification) else found.band_hz
        draw_spectra(ax, fit + residual, fit, residual, 1 / left.step, decay=decay, modes=found.modes, band=band)
        known = unit if isinstance(found, Identification) or unit else channel_unit(found.suspension, name)
        ax.set_ylabel(density_label(shown(known) if len(known) <= SHORT_UNIT else ""))
        entitle(ax, shown(name))
    label_below(drawn, "frequency [Hz]")
    key_above(drawn[0])


def in_view(frequency: RealArray, residual: RealArray, modes: RealArray) -> tuple[float, float]:
    """Return the ends of the frequencies [Hz] that hold modes, or lines of a residual that its noise does not make.

    Examples
    --------
    >>> hertz, noise = np.arange(1, 1001) / 10, np.random.default_rng(1).exponential(size=1000)
    >>> in_view(hertz, noise, np.array([1.5, 12.0]))
    (0.1, 30.0)
    >>> in_view(hertz, np.where(hertz == 50.0, 1e3, noise), np.array([1.5, 12.0]))
    (0.1, 60.0)
    >>> in_view(hertz, noise, np.array([]))
    (0.1, 100.0)
    """
    first, last = float(frequency[0]), float(frequency[-1])
    if not len(modes):
        return first, last
    # Single values of white noise are exponential; the highest of n is as likely above this.
    mean = float(np.median(residual)) / np.log(2)
    lines = frequency[residual > mean * np.log(residual.size / CHANCE)]
    low, high = float(np.min(modes)) / BELOW_MODES, IN_VIEW * float(np.max(modes))
    if lines.size:
        low, high = min(low, float(lines[0])), max(high, BESIDE_LINE * float(lines[-1]))
    return max(first, low), min(last, high)


def density_label(unit: str) -> str:
    """Return the label of an axis of spectral density of a channel in a unit; an empty one is not known."""
    return f"PSD [({unit})²/Hz]" if "/" in unit else f"PSD [{unit or 'unit'}²/Hz]"


def no_such_record(found: Estimate) -> str:
    """Return how many records an estimate holds, and why it may hold none."""
    return f"the estimate contains {count(len(found.residual), 'record')}; one that was read from JSON contains none"


def draw_spectra(
    ax: Axes,
    record: RealArray,
    fit: RealArray,
    residual: RealArray,
    rate: float,
    *,
    modes: ModalSet,
    decay: bool = False,
    band: tuple[Hertz, Hertz] | None = None,
) -> None:
    """Draw the densities of one channel on logarithmic axes; those of a decay without a window.

    The frequencies in view are those of the modes and of what stands out of the residual: above them there is noise.
    Where a band alone was fitted it is that band: beyond it the fit is the record.
    """
    from scipy.signal import welch

    length = record.size if decay else max(min(record.size, 64), record.size // STRETCHES)
    window = "boxcar" if decay else "hann"
    drawn = (
        (record, Colour.PALE, "record", 2.4),
        (fit, Colour.BLUE, "fit", 1.0),
        (residual, Colour.VERMILION, "residual", 0.9),
    )
    frequency, densities = welch(np.array([values for values, *_ in drawn]), fs=rate, nperseg=length, window=window)
    frequency, densities = frequency[1:], densities[:, 1:]
    low, high = in_view(frequency, densities[-1], modes.wn / (2 * np.pi)) if band is None else band
    low = max(low, float(frequency[0]))
    # Neighbours of the view stay, so that lines reach its ends.
    kept = slice(max(np.searchsorted(frequency, low) - 1, 0), np.searchsorted(frequency, high, side="right") + 1)
    for (_, colour, label, width), density in zip(drawn, densities, strict=True):
        x, y = thinned(ax, frequency[kept], np.maximum(density[kept], 1e-300))
        ax.loglog(x, y, color=colour, linewidth=width, label=label)
    ax.set_xlim(low, high)
    frequency_ticks(ax.xaxis, high / low)
    top, noise = float(np.max(densities)), float(np.median(densities[-1]))
    if top > 0:
        ax.set_ylim(bottom=max(ax.get_ylim()[0], EXACT * top, BELOW_NOISE * noise))
