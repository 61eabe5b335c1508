"""Findings: each defect of a recording, with its place, its size, and whether it was repaired."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from suspid.units import RealArray, Second
from suspid.wording import when
from suspid.words import Check, Code, Defect, Level, Number, Remark


@dataclass(frozen=True, kw_only=True, slots=True)
class Finding:
    """One defect of a recording.

    Parameters
    ----------
    remark : Remark
        What it is: a code with its numbers.
    channel : str
        The channel; empty for time and for the recording as a whole.
    start, stop : float
        First and last affected time [s].
    samples : int
        Number of samples.
    repaired : bool
        Whether the record differs from the file because of it.

    Examples
    --------
    >>> from suspid import RawChannel, Recording, clean
    >>> t = np.arange(300) / 100
    >>> values = np.exp(-t) * np.sin(12 * t)
    >>> values[40] = -9999.0
    >>> seat = RawChannel(name="seat", unit="m", timepts=t, values=values, rate=None)
    >>> found = clean(Recording(title="bump", channels=(seat,))).findings[0]
    >>> found.channel, found.start, found.repaired
    ('seat', 0.4, True)
    >>> found.text
    '1 sample equal to -9999, far from all others (-0.6767 to 0.8793); treated as missing'
    """

    remark: Remark
    channel: str
    start: Second
    stop: Second
    samples: int
    repaired: bool

    @property
    def kind(self) -> Code:
        """What it is, such as `Defect.CLIPPED`.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import RawChannel, Recording, clean
        >>> t = np.arange(300) / 100
        >>> values = np.exp(-t) * np.sin(12 * t)
        >>> values[40] = -9999.0
        >>> seat = RawChannel(name="seat", unit="m", timepts=t, values=values, rate=None)
        >>> found = clean(Recording(title="bump", channels=(seat,))).findings[0]
        >>> str(found.kind)
        'sentinel'
        """
        return self.remark.code

    @property
    def text(self) -> str:
        """What it is, how much, and what was done, as a sentence.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import RawChannel, Recording, clean
        >>> t = np.arange(300) / 100
        >>> values = np.exp(-t) * np.sin(12 * t)
        >>> values[40] = -9999.0
        >>> seat = RawChannel(name="seat", unit="m", timepts=t, values=values, rate=None)
        >>> found = clean(Recording(title="bump", channels=(seat,))).findings[0]
        >>> found.text
        '1 sample equal to -9999, far from all others (-0.6767 to 0.8793); treated as missing'
        """
        return str(self.remark)

    @property
    def check(self) -> Check:
        """The defect as part of a verdict: a note if repaired, else a reason for care.

        An offset is a note as well: identification allows for it. A rate that contradicts the stamps is no repair.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import RawChannel, Recording, clean
        >>> t = np.arange(300) / 100
        >>> values = np.exp(-t) * np.sin(12 * t)
        >>> values[40] = -9999.0
        >>> seat = RawChannel(name="seat", unit="m", timepts=t, values=values, rate=None)
        >>> found = clean(Recording(title="bump", channels=(seat,))).findings[0]
        >>> found.check.level.label
        'note'
        """
        place: dict[str, Number] = {
            "channel": self.channel,
            "start": self.start,
            "stop": self.stop,
            "samples": self.samples,
        }
        harmless = self.kind is not Defect.OVERRIDDEN_STAMPS and (self.repaired or self.kind is Defect.OFFSET)
        remark = Remark(self.kind, {**self.remark.numbers, **place})
        return Check(remark, Level.NOTE if harmless else Level.CARE)

    def with_numbers(self, numbers: dict[str, Number]) -> Finding:
        """Return the finding with further numbers in its remark.

        Examples
        --------
        >>> from suspid import Finding, Remark
        >>> from suspid.words import Defect
        >>> drift = Finding(remark=Remark(Defect.DRIFT, {"drift": 0.4}), channel="seat", start=0.0, stop=3.0,
        ...                 samples=300, repaired=False)
        >>> drift.with_numbers({"samples": 300}).remark.numbers
        {'drift': 0.4, 'samples': 300}
        """
        return replace(self, remark=Remark(self.kind, {**self.remark.numbers, **numbers}))

    def __str__(self) -> str:
        of = f", channel {self.channel!r}" if self.channel else ""
        where = f" {when(self.start, self.stop)}"
        return f"{self.kind}{of}{where}: {self.text}"


def found(
    kind: Defect,
    where: RealArray,
    samples: int,
    numbers: dict[str, Number] | None = None,
    *,
    channel: str = "",
    repaired: bool = True,
) -> Finding:
    """Return a finding at the times ``where`` [s], of time or of a channel; its remark also holds ``samples``."""
    plain: dict[str, Number] = {n: x.item() if isinstance(x, np.generic) else x for n, x in (numbers or {}).items()}
    return Finding(
        remark=Remark(kind, {"samples": samples, **plain}),
        channel=channel,
        start=float(np.min(where)),
        stop=float(np.max(where)),
        samples=samples,
        repaired=repaired,
    )
