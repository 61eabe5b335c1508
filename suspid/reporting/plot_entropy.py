"""Wavelet entropy against bandwidth."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.arguments import explained
from suspid.reporting.colours import Colour
from suspid.results import check_kind

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from suspid.wavelets import BandwidthSearch


@explained
def plot_entropy(search: BandwidthSearch, *, ax: Axes) -> Axes:
    """Draw wavelet entropy against bandwidth with its minimum; warn if the minimum lies at an end of the range.

    Parameters
    ----------
    search : BandwidthSearch
        The curve.
    ax : matplotlib.axes.Axes
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        ``ax``.

    Examples
    --------
    >>> import numpy as np
    >>> from matplotlib.figure import Figure
    >>> from suspid import BandwidthSearch
    >>> search = BandwidthSearch(candidates=np.array([4.0, 8.0, 16.0]), entropy=np.array([5.0, 4.0, 4.5]))
    >>> plot_entropy(search, ax=Figure().subplots()).get_title(loc="left")
    'least entropy at N = 8'
    """
    check_kind(search, {"BandwidthSearch": "best_bandwidth"})
    order = np.argsort(search.candidates)
    tried, entropy = search.candidates[order], search.entropy[order]
    ax.plot(tried, entropy, color=Colour.BLUE, marker=".", markersize=4, linewidth=1.0)
    least = float(np.min(search.entropy))
    ax.plot(
        [search.best], [least], color=Colour.VERMILION, marker="o", markersize=8, fillstyle="none", linestyle="none"
    )
    ax.axvline(search.best, color=Colour.VERMILION, linewidth=0.8, linestyle="--")
    if tried[-1] > 100 * tried[0]:
        ax.set_xscale("log")
    ax.set(xlabel="bandwidth N [1]", ylabel="wavelet entropy [nat]")
    title = f"least entropy at N = {search.best:.4g}"
    if search.at_end:
        ax.set_title(f"{title},\nthe end of the range searched", loc="left", color=Colour.VERMILION)
    else:
        ax.set_title(title, loc="left")
    return ax
