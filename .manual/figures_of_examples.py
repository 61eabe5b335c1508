"""Finds the figures that an example draws without pyplot, for the gallery."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

_seen: set[int] = set()


def _get_sg_image_scraper() -> Callable[[Any, dict[str, Any], dict[str, Any]], str]:
    return scraped


def scraped(_block: Any, variables: dict[str, Any], gallery: dict[str, Any]) -> str:
    """Save the figures that are new among the names of an example; return where the page shows them."""
    held = variables["example_globals"].values()
    pages = [one.figure if hasattr(one, "figure") else one for one in held]
    drawn = [page for page in pages if isinstance(page, Figure) and page.axes and id(page) not in _seen]
    names = []
    for page in dict.fromkeys(drawn):
        _seen.add(id(page))
        name = next(variables["image_path_iterator"])
        page.savefig(name, dpi=110)
        names.append(name)
    return str(figure_rst(names, gallery["src_dir"]))
