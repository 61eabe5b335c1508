"""Signatures: what the first bytes of a file say it is, whatever its name."""

from __future__ import annotations

from pathlib import Path

HDF5 = b"\x89HDF\r\n\x1a\n"
# How much of a file is looked at, and where other bytes than the first may be the mark.
HEAD = 1024
# Suffix of the reader, what it is called, where its mark stands and the mark.
SIGNATURES = (
    (".mf4", "an MDF file", 0, b"MDF     "),
    (".parquet", "a Parquet file", 0, b"PAR1"),
    (".tdms", "a TDMS file", 0, b"TDSm"),
    (".wav", "a WAV file", 8, b"WAVE"),
    (".h5", "an HDF5 file", 0, HDF5),
    (".h5", "an HDF5 file", 512, HDF5),
    (".mat", "a MATLAB file", 0, b"MATLAB 5.0 MAT-file"),
    (".uff", "a universal file", 0, b"    -1"),
    ("", "a spreadsheet or an archive (export the sheet as CSV)", 0, b"PK\x03\x04"),
    ("", "an old spreadsheet (export the sheet as CSV)", 0, b"\xd0\xcf\x11\xe0"),
    ("", "compressed with gzip (unpack it)", 0, b"\x1f\x8b"),
    ("", "JSON (a record is a table)", 0, b"{"),
)


def signature(path: Path) -> tuple[str, str]:
    r"""Return the suffix under which a file would be read and what it looks like, both empty if that is not known.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = Path(folder, "bump.data").write_bytes(b"TDSm\x0e")
    ...     signature(Path(folder, "bump.data"))
    ('.tdms', 'a TDMS file')
    """
    try:
        if not path.is_file():
            return "", ""
        with path.open("rb") as stream:
            head = stream.read(HEAD)
    except (OSError, ValueError):
        return "", ""
    for suffix, name, position, mark in SIGNATURES:
        if head[position : position + len(mark)] == mark:
            return suffix, name
    text = head and not set(head) & set(b"\x00\x01\x02\x03\x04\x05\x06\x07\x08\x0e\x0f")
    return ("", "text (rows of numbers can be read as .csv)") if text else ("", "")
