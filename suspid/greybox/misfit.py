"""Transfer error of a car that does not explain how channels follow the given motion, and the resulting uncertainty."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from suspid.greybox.leftover import Leftover, coherent_leftover
from suspid.greybox.whitened import Whitened
from suspid.levels import likely
from suspid.units import Ratio, RealArray
from suspid.words import Check, Level, Number, Remark
from suspid.words.greybox import EstimateCheck


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Misfit:
    """The part of the residual of all records that follows the given motion."""

    parts: tuple[Leftover, ...]  # by logger

    @property
    def chi_square(self) -> float:
        """Statistic of the test that nothing follows."""
        return sum(part.chi_square for part in self.parts)

    @property
    def freedom(self) -> int:
        """Its degrees of freedom."""
        return sum(part.freedom for part in self.parts)

    @property
    def likely(self) -> bool:
        """Whether the statistic is not improbably large."""
        return likely(self.chi_square, self.freedom)

    @property
    def inflation(self) -> Ratio:
        """Factor on all variances, 1 where the car explains the records.

        What a car lacks changes transfers in some directions. Its part along the parameters is not seen, as they follow
        it; it counts as large as the part that is left is in each of the directions that this shows in.
        """
        return 1.0 if self.likely else max(1.0, self.chi_square / sum(part.directions for part in self.parts))

    @property
    def check(self) -> Check:
        """What is said of it."""
        numbers: dict[str, Number] = {"chi_square": self.chi_square, "freedom": self.freedom}
        if self.likely:
            return Check(Remark(EstimateCheck.NOTHING_FOLLOWS, numbers), Level.SOUND)
        worst = max(self.parts, key=lambda part: part.chi_square / max(part.freedom, 1))
        numbers |= {"error": worst.error, "hertz": worst.hertz, "wider": self.inflation**0.5}
        return Check(Remark(EstimateCheck.FOLLOWS, numbers), Level.DOUBTFUL)


def misfit_of(every: Sequence[Whitened], hertz: Sequence[RealArray]) -> Misfit:
    """Return the residual of the records of all loggers, with the frequencies of their lines."""
    return Misfit(parts=tuple(coherent_leftover(w, lines) for w, lines in zip(every, hertz, strict=True)))
