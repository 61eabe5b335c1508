"""A page as PDF, printed by a browser that is installed."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from suspid.errors import InputError
from suspid.files import printable

# Browsers that print without a window, in the order in which they are looked for.
BROWSERS = (
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
    "microsoft-edge",
    "msedge",
)
# A page takes a few seconds; a browser that hangs is stopped after this time [s].
LONGEST = 120.0


def browser() -> str:
    """Return the path of a browser that prints.

    Raises
    ------
    InputError
        If there is none; the message names those that were looked for.
    """
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    if found is None:
        raise InputError(
            f"a PDF is printed by a browser, and none is on the path (looked for {', '.join(BROWSERS)}): install "
            f"Chromium, or write .html and print it from any browser"
        )
    return found


def write_pdf(page: str, path: str | os.PathLike[str]) -> None:
    """Print a page of `report` as PDF.

    Parameters
    ----------
    page : str
        The page, as HTML.
    path : path
        The file to write.

    Raises
    ------
    InputError
        If no browser is installed, or it does not print.

    Examples
    --------
    >>> write_pdf("<!doctype html><p>two modes", "report.pdf")  # doctest: +SKIP
    """
    program = browser()
    with tempfile.TemporaryDirectory(prefix="suspid-") as folder:
        html, pdf = Path(folder, "page.html"), Path(folder, "page.pdf")
        html.write_text(page, encoding="utf-8")
        # The sandbox of Chromium refuses to run as root; the page has no script and may not load anything.
        rooted = ["--no-sandbox"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []
        command = [
            program,
            "--headless",
            "--disable-gpu",
            "--no-first-run",
            "--no-pdf-header-footer",
            f"--user-data-dir={Path(folder, 'profile')}",
            *rooted,
            f"--print-to-pdf={pdf}",
            html.as_uri(),
        ]
        try:
            done = subprocess.run(command, capture_output=True, timeout=LONGEST, check=False)
        except (OSError, subprocess.TimeoutExpired) as refusal:
            raise InputError(
                f"{program} did not print the page: {printable(str(refusal))[:200]}; write .html"
            ) from None
        if not pdf.exists() or not pdf.read_bytes().startswith(b"%PDF"):
            said = printable(" ".join(done.stderr.decode("utf-8", "replace").split()[-30:]))
            raise InputError(f"{program} did not print the page ({said}); write .html, and print it by hand")
        Path(path).write_bytes(pdf.read_bytes())
