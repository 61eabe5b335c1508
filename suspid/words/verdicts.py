"""Verdicts: a level, and the checks that it rests on."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from suspid.words.remarks import Remark


class Level(IntEnum):
    """How far a result can be trusted, and what one check says of that; the least of all checks decides.

    Examples
    --------
    >>> min(Level.SOUND, Level.CARE).label
    'care'
    >>> Level.SOUND > Level.DOUBTFUL
    True
    """

    NONE = 0
    DOUBTFUL = 1
    CARE = 2
    NOTE = 3
    SOUND = 4

    @property
    def label(self) -> str:
        """The level in lower case, as JSON and tables have it.

        Examples
        --------
        >>> from suspid import Level
        >>> Level.CARE.label
        'care'
        """
        return self.name.lower()


# What each level means, as a sentence.
MEANING = {
    Level.NONE: "There is no result.",
    Level.DOUBTFUL: "Do not use it without further evidence.",
    Level.CARE: "Read the doubts before use.",
    Level.NOTE: "Every check that could be made was passed.",
    Level.SOUND: "Every check that could be made was passed.",
}


def label_in_words(label: str) -> str:
    """Return the label of a level as a table for readers has it.

    Examples
    --------
    >>> label_in_words("none"), label_in_words("care")
    ('no result', 'care')
    """
    return "no result" if label == Level.NONE.label else label


@dataclass(frozen=True, slots=True)
class Check:
    """One check of a result.

    Parameters
    ----------
    remark : Remark
        What was checked, with its numbers.
    level : Level
        What it says: SOUND speaks for the result, NOTE is neutral, CARE and DOUBTFUL speak against it, NONE means that
        there is no result.

    Examples
    --------
    >>> from suspid import Level, grip, quarter_car
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=650)
    >>> check = grip(car).verdict.checks[-1]
    >>> check.level is Level.NOTE, str(check.remark)
    (True, 'Taken as known, without any error in the intervals: all springs, dampers and masses.')
    """

    remark: Remark
    level: Level

    def __str__(self) -> str:
        return str(self.remark)


@dataclass(frozen=True, slots=True, repr=False)
class Verdict:
    """How far a result can be trusted.

    Parameters
    ----------
    headline : Remark
        What was found.
    checks : tuple of Check
        What speaks for it and against it.

    Examples
    --------
    >>> from suspid import grip, quarter_car
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=650)
    >>> verdict = grip(car).verdict
    >>> verdict.level.label, len(verdict.doubts)
    ('sound', 0)
    >>> print(verdict)
    Verdict: grip of tire: sound. Every check that could be made was passed.
    note: Taken as known, without any error in the intervals: all springs, dampers and masses.
    """

    headline: Remark
    checks: tuple[Check, ...] = ()

    @property
    def level(self) -> Level:
        """The least level of all checks; NOTE counts as SOUND.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, identify
        >>> t = np.arange(0, 4, 0.01)
        >>> found = identify(as_record(np.exp(-t) * np.cos(20 * t), timepts=t), modes=1)
        >>> found.verdict.level.label
        'sound'
        """
        least = min((check.level for check in self.checks), default=Level.SOUND)
        return Level.SOUND if least is Level.NOTE else least

    @property
    def meaning(self) -> str:
        """What the level means, as a sentence.

        Examples
        --------
        >>> from suspid import grip, quarter_car
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=650, tire_damping=60)
        >>> verdict = grip(car).verdict
        >>> verdict.meaning
        'Every check that could be made was passed.'
        """
        return MEANING[self.level]

    @property
    def support(self) -> tuple[Remark, ...]:
        """What speaks for the result.

        Examples
        --------
        >>> from suspid import grip, quarter_car
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=650, tire_damping=60)
        >>> verdict = grip(car).verdict
        >>> print(verdict.support[0])
        tire: the least phase, 35.9 deg, is above EGEA's limit of 35 deg.
        """
        return tuple(c.remark for c in self.checks if c.level is Level.SOUND)

    @property
    def doubts(self) -> tuple[Remark, ...]:
        """What speaks against it, the gravest first.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, identify
        >>> t = np.arange(0, 4, 0.01)
        >>> found = identify(as_record(np.exp(-t) * np.cos(20 * t), timepts=t), modes=1)
        >>> found.verdict.doubts
        ()
        """
        against = [c for c in self.checks if c.level < Level.NOTE]
        return tuple(c.remark for c in sorted(against, key=lambda c: c.level))

    @property
    def notes(self) -> tuple[Remark, ...]:
        """Notes: neither for nor against the result.

        Examples
        --------
        >>> from suspid import grip, quarter_car
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=650, tire_damping=60)
        >>> verdict = grip(car).verdict
        >>> print(verdict.notes[-1])
        Taken as known, without any error in the intervals: all springs, dampers and masses.
        """
        return tuple(c.remark for c in self.checks if c.level is Level.NOTE)

    def __repr__(self) -> str:
        doubts = f"; doubts: {', '.join(str(one.code) for one in self.doubts)}" if self.doubts else ""
        return f"<{type(self).__name__} {self.level.label}: {self.headline}{doubts}>"

    def __str__(self) -> str:
        said = "" if self.level is Level.NONE else f": {self.level.label}"
        lines = [f"Verdict: {self.headline}{said}. {self.meaning}"]
        return "\n".join([*lines, *(f"- {doubt}" for doubt in self.doubts), *(f"note: {n}" for n in self.notes)])

    def to_dict(self) -> dict[str, object]:
        """Return level, headline and checks, for JSON.

        Examples
        --------
        >>> from suspid import grip, quarter_car
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=650, tire_damping=60)
        >>> verdict = grip(car).verdict
        >>> sorted(verdict.to_dict())
        ['checks', 'headline', 'level']
        """
        checks = [{**check.remark.to_dict(), "level": check.level.label} for check in self.checks]
        return {"level": self.level.label, "headline": self.headline.to_dict(), "checks": checks}
