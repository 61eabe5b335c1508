"""What a run of a fleet left: its folder, its counts and its tables."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from suspid.files import printable
from suspid.fleet.parts import read_table

if TYPE_CHECKING:
    import pyarrow as pa


@dataclass(frozen=True, kw_only=True, slots=True)
class FleetRun:
    """What a run left in its folder.

    Parameters
    ----------
    output : path
        The folder of the results.
    records : int
        How many records there are.
    failed : int
        How many of them have a row among the failures.
    kept : int
        How many were done by an earlier run that was interrupted.
    notes : tuple of str
        What the user should know of the run.
    """

    output: Path
    records: int
    failed: int
    kept: int = 0
    notes: tuple[str, ...] = ()

    @property
    def modes(self) -> pa.Table:
        """One row per record and mode."""
        return read_table(self.output, "modes")

    @property
    def springs(self) -> pa.Table:
        """One row per record and parameter of the car; none without a car."""
        return read_table(self.output, "springs")

    @property
    def failures(self) -> pa.Table:
        """One row per record that failed, with the step and the reason."""
        return read_table(self.output, "failures")

    def __str__(self) -> str:
        kept = f", {self.kept} of them by an earlier run" if self.kept else ""
        return "\n".join(
            [
                f"{printable(str(self.output))}: {self.records} records{kept}; {self.records - self.failed} without "
                f"failure, {self.failed} with",
                *self.notes,
            ]
        )
