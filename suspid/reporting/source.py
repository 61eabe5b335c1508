"""Origin of a record."""

from __future__ import annotations

import hashlib
import os
import platform
from dataclasses import dataclass
from pathlib import Path

from suspid.arguments import explained
from suspid.errors import InputError
from suspid.files import printable, read_text

# Packages whose versions a report names.
PACKAGES = ("suspid", "numpy", "scipy", "control", "PyWavelets", "cvxpy")


@dataclass(frozen=True, kw_only=True, slots=True)
class Source:
    """Origin of a record, and the command that made the report.

    Parameters
    ----------
    file : str
        Name of the file.
    sha256 : str
        Its SHA-256, in hexadecimal.
    size : int
        Its size [byte].
    command : str
        The command that made the report.
    created : str
        Date and time of the report, as the reader should see it; ISO 8601 is best.
    text : str
        Its text, where the report shows it: the description of a car, or limits.

    Examples
    --------
    >>> source = Source(file="bump.csv", sha256="0" * 64, size=1200, command="suspid report bump.csv",
    ...                 created="2026-05-31")
    >>> source.file
    'bump.csv'
    """

    file: str
    sha256: str
    size: int
    command: str
    created: str
    text: str = ""


@explained
def source_of(path: str | os.PathLike[str], *, command: str = "", created: str = "", text: bool = False) -> Source:
    """Return a file as a source, with its hash, and with its text on request.

    Raises
    ------
    InputError
        If the file cannot be read.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "decay.csv")
    ...     _ = path.write_bytes(b"abc")
    ...     source = source_of(path, command="suspid report decay.csv", created="2026-01-01")
    >>> source.size, source.sha256[:16]
    (3, 'ba7816bf8f01cfea')
    """
    file = Path(path)
    try:
        with file.open("rb") as stream:
            digest = hashlib.file_digest(stream, "sha256").hexdigest()
            size = stream.tell()
    except (OSError, ValueError) as refusal:
        raise InputError(f"cannot be read: {printable(str(refusal))}").about(printable(str(path))) from None
    whole = read_text(file) if text else ""
    return Source(file=file.name, sha256=digest, size=size, command=command, created=created, text=whole)


def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that made the report."""
    from importlib.metadata import version

    return {"python": platform.python_version()} | {name: version(name) for name in PACKAGES}
