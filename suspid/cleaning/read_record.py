"""Read a file as a record on a uniform clock."""

from __future__ import annotations

import os
import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING

from suspid.arguments import explained
from suspid.cleaning.clean import clean
from suspid.errors import RecordWarning
from suspid.files import naming, printable
from suspid.io import read_recording
from suspid.units import Hertz
from suspid.words import DAMAGE

if TYPE_CHECKING:
    import control


@explained
def read_record(
    path: str | os.PathLike[str],
    *,
    channels: Sequence[str] | str | None = None,
    time: str | None = None,
    fs: Hertz | None = None,
    dbc: str | os.PathLike[str] | None = None,
) -> control.TimeResponseData:
    r"""Return the record in a file.

    `read_recording` reads its channels and `suspid.clean` repairs them. Each defect, repaired or not, is a
    `RecordWarning`.

    Text (``.csv``, ``.txt``, ``.tsv``, ``.dat``, ``.log``, ``.asc``): a sample a line, in UTF-8, UTF-16 or
    Windows-1252. Separator, decimal sign, header, units, and lines that are not samples are
    detected; without a header the columns are named ``column 1``, ``column 2`` …. MATLAB (``.mat``) and HDF5
    (``.h5``, ``.hdf5``): every real vector, and every column of a matrix, is a column, those of a structure by
    dotted names; a number named like ``Fs`` or ``dt`` is the rate. Further: Parquet (``.parquet``, ``.pq``),
    NumPy (``.npy``, ``.npz``), universal files (``.uff``, ``.unv``, ``.uf``, ``.58``), TDMS (``.tdms``), ASAM MDF
    (``.mf4``, ``.mdf``, ``.dat``), and WAV (``.wav``, ``.wave``); what some of them need is named where it is
    missing. A file of another name is read if its first bytes say what it is.

    Parameters
    ----------
    path : str or path
        The file; its suffix says what it is.
    channels : sequence of str, optional
        Columns to take. Default: all but time that are as long as time.
    time : str, optional
        The column of time. Default: the one named like a time (``t``, ``time [s]``, ``t_ms``, …).
        A unit in its name is used: the response is in seconds.
    fs : float, optional
        Sampling rate [Hz]. Without a time column, the record starts at 0. Otherwise it replaces the time stamps, and
        a warning says how far they disagree.
    dbc : str or path, optional
        Database that decodes the raw CAN frames of an MDF file.

    Returns
    -------
    control.TimeResponseData
        Outputs (channel, sample), in the units of the file, on a uniform clock.

    Raises
    ------
    RecordError
        If the file cannot be read in its format, a column is missing or contains text, time is not found, or a defect
        cannot be repaired safely. The message begins with the name of the file.

    Warns
    -----
    RecordWarning
        For each defect that was repaired or found, and each part that was left out.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "bump.csv")
    ...     _ = path.write_text("time [ms],seat,chassis\n0,0.0,1.0\n2,0.5,0.8\n4,0.4,0.6\n")
    ...     record = read_record(path, channels=["chassis"])
    >>> record.time
    array([0.   , 0.002, 0.004])
    >>> record.output_labels, record.y
    (['chassis'], array([[1. , 0.8, 0.6]]))
    """
    recording = read_recording(path, channels=channels, time=time, fs=fs, dbc=dbc)
    with naming(path):
        cleaned = clean(recording, channels=None if channels is None else recording.names, fs=fs)
    damaged = [f"{what} {why}" for what, why in recording.left_out if why.code in DAMAGE]
    found = [f"{finding.channel or 'time'}: {finding.kind}: {finding.text}" for finding in cleaned.findings]
    for text in (*damaged, *found):
        warnings.warn(f"{printable(str(path))}: {printable(text)}", RecordWarning, stacklevel=2)
    return cleaned.record
