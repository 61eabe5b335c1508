"""Read a file as a recording."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Sequence
from pathlib import Path

from suspid.arguments import explained
from suspid.errors import RecordError
from suspid.files import check_exists, naming
from suspid.io.formats import PLAIN_TEXT, appearance, format_of, is_document, is_guess, marked_format, reader_of
from suspid.io.timing import as_recording
from suspid.recordings import Recording
from suspid.units import Hertz
from suspid.wording import WayOut


@explained
def read_recording(
    path: str | os.PathLike[str],
    *,
    channels: Sequence[str] | str | None = None,
    time: str | None = None,
    fs: Hertz | None = None,
    dbc: str | os.PathLike[str] | None = None,
) -> Recording:
    r"""Return the channels of a file as they are stored; nothing is repaired.

    Parameters
    ----------
    path : str or path
        The file; its suffix states the format.
    channels : sequence of str, optional
        Columns to take, by their names or by these without the unit. Default: all but time that have a clock
        or are as long as time.
    time : str, optional
        The column of time. Default: the time base of the channel, or the column named like a time (``t``,
        ``time [s]``, ``t_ms``, …). A unit in its name, or stated by the file, is used. ``"none"``: times in the file
        are ignored, and a rate in the file or ``fs`` is used.
    fs : float, optional
        Sampling rate [Hz] of the channels; they start at 0 where the file states no time.
    dbc : str or path, optional
        Database that decodes the raw CAN frames of an MDF file.

    Raises
    ------
    RecordError
        If the file cannot be read in its format, a column is missing or holds text, or neither time nor rate is
        known. The message begins with the name of the file.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "bump.csv")
    ...     _ = path.write_text("time [ms],seat [mm]\n0,0.0\n2,nan\n5,0.4\n")
    ...     recording = read_recording(path)
    >>> recording["seat [mm]"].unit, recording["seat [mm]"].timepts, recording["seat [mm]"].values
    ('mm', array([0.   , 0.002, 0.005]), array([0. , nan, 0.4]))
    """
    path = Path(path)
    with naming(path):
        try:
            check_exists(path, error=RecordError)
            table = reader_of(path, dbc)(path)
            wanted = [channels] if isinstance(channels, str) else channels
            return as_recording(table, channels=wanted, time=time, fs=fs, title=path.stem, size=path.stat().st_size)
        except RecordError as error:
            if _is_toml(path):
                raise RecordError(
                    "is a description, as of a car or of limits, and not a record; ",
                    WayOut(
                        "read_car reads a car",
                        "car",
                        "name the record, and this file with {option}",
                        "`suspid modes` shows the modes of a car",
                    ),
                ) from None
            raise RecordError(*error.args, _hint(path)) from None


def _is_toml(path: Path) -> bool:
    """Return whether a file is TOML by name and content."""
    if path.suffix.lower() != ".toml":
        return False
    try:
        tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return True


def _hint(path: Path) -> str:
    """Return what a file that could not be read may be, where its name says nothing, or something else."""
    if not os.path.isfile(path):
        return ""
    marked = marked_format(path)
    if marked is not None and format_of(path) is not marked:
        return f"; it looks like {marked.name}: name it {marked.suffixes[0]}"
    kind, seen = format_of(path), appearance(path)
    if seen and (kind is PLAIN_TEXT or is_document(path)):
        return f"; it looks like {seen}"
    # A universal file is text.
    if seen is None and kind is not PLAIN_TEXT and kind.module != "uff":
        return "; it looks like text: name it .csv"
    if not is_guess(path):
        return ""
    return f"; it was read as text, since records of type {path.suffix!r} are not known"
