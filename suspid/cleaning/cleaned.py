"""Cleaned: a record with the list of all that was found in the recording and repaired."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tabulate import tabulate

from suspid.cleaning.findings import Finding
from suspid.files import printable
from suspid.results import Result, columns_of
from suspid.samples import AsResponse, held
from suspid.signals import as_signal
from suspid.values import samples_in_words
from suspid.words import Cleaning, Remark, Verdict

if TYPE_CHECKING:
    import control


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Cleaned(Result):
    """A usable record, and the defects that were found and repaired.

    Parameters
    ----------
    record : control.TimeResponseData
        Finite samples on a uniform clock.
    units : tuple of str
        Units of the channels as the file states them.
    findings : tuple of Finding
        The defects; none for a clean recording, whose samples and stamps are unchanged to the last bit.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import RawChannel, Recording, clean
    >>> t = np.arange(300) / 100
    >>> seat = RawChannel(name="seat", unit="m", timepts=t, values=np.exp(-t) * np.sin(12 * t), rate=None)
    >>> cleaned = clean(Recording(title="bump", channels=(seat,)))
    >>> cleaned.units, cleaned.findings, cleaned.record.output_labels
    (('m',), (), ['seat'])
    """

    record: control.TimeResponseData = AsResponse("record")  # noqa: RUF009 - no default
    units: tuple[str, ...]
    findings: tuple[Finding, ...]

    @property
    def verdict(self) -> Verdict:
        """Whether the record can be used as it is: defects left alone call for care, repairs are notes.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import RawChannel, Recording, clean
        >>> t = np.arange(300) / 100
        >>> values = np.exp(-t) * np.sin(12 * t)
        >>> values[40] = -9999.0
        >>> seat = RawChannel(name="seat", unit="m", timepts=t, values=values, rate=None)
        >>> cleaned = clean(Recording(title="bump", channels=(seat,)))
        >>> cleaned.verdict.level.label, [check.level.label for check in cleaned.verdict.checks]
        ('sound', ['note', 'note'])
        """
        repaired = sum(finding.repaired for finding in self.findings)
        headline = Remark(Cleaning.UNCHANGED)
        if self.findings:
            headline = Remark(Cleaning.REPAIRED, {"repaired": repaired, "left": len(self.findings) - repaired})
        return Verdict(headline, tuple(finding.check for finding in self.findings))

    def _table(self) -> Mapping[str, Sequence[object]]:
        return {
            "kind": [str(finding.kind) for finding in self.findings],
            "start_s": [finding.start for finding in self.findings],
            "stop_s": [finding.stop for finding in self.findings],
            **columns_of(self.findings, ["channel", "samples", "repaired", "text"]),
        }

    def _brief(self) -> str:
        record = as_signal(held(self, "record"))
        return f"{self.verdict.headline}; {samples_in_words(record.timepts, record.channels)}"

    def __str__(self) -> str:
        if not self.findings:
            return str(self.verdict)
        columns = {
            "found": [str(finding.kind) for finding in self.findings],
            "channel": [printable(finding.channel) or "(time)" for finding in self.findings],
            "from [s]": [f"{finding.start:.6g}" for finding in self.findings],
            "to [s]": [f"{finding.stop:.6g}" for finding in self.findings],
            "samples": [str(finding.samples) for finding in self.findings],
            "repaired": ["yes" if finding.repaired else "no" for finding in self.findings],
            "what": [printable(finding.text) for finding in self.findings],
        }
        # Characters of a line in which a finding is explained.
        widths = [None, 24, *[None] * 4, 60]
        table = tabulate(columns, headers="keys", disable_numparse=True, maxcolwidths=widths)
        return f"{printable(str(self.verdict))}\n\n{table}"
