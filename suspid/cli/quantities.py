"""Types of numbers on the command line, each with its unit."""

from __future__ import annotations

import math
from itertools import pairwise

import click


class Finite(click.ParamType[float]):
    """A finite number, in the unit that ``name`` says."""

    required = "finite"

    def __init__(self, unit: str) -> None:
        self.name = unit

    @property
    def wanted(self) -> str:
        """What to write in place of what is no number."""
        return "write a ratio, such as 0.3" if self.name == "share" else f"write it in {self.name}, without the unit"

    def allowed(self, number: float) -> bool:
        """Return whether the number may be given."""
        return math.isfinite(number)

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the number, or refuse it as a usage error."""
        try:
            number = float(str(value))
        except ValueError:
            self.fail(f"{value!r} is not a number; {self.wanted}.", param, ctx)
        if not self.allowed(number):
            unit = "" if self.name == "share" else f" {self.name}"
            self.fail(f"{value}{unit} must be {self.required}.", param, ctx)
        return number


class Positive(Finite):
    """A finite number above zero, in the unit that ``name`` says."""

    required = "positive and finite"

    def allowed(self, number: float) -> bool:
        """Return whether the number may be given."""
        return number > 0 and math.isfinite(number)


# Probability of intervals up to which tables print it as it is; beyond, the tail of the normal law decides, which no
# record shows.
MOST_PRINTED = 0.999999


class Probability(click.FloatRange):
    """A probability above 0, below 1 by more than tables round."""

    name = "share"

    def __init__(self) -> None:
        super().__init__(0, MOST_PRINTED, min_open=True)

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the probability, or refuse it as a usage error."""
        try:
            number = float(str(value))
        except ValueError:
            number = math.nan
        if not 0 < number <= MOST_PRINTED:
            self.fail(f"{value} is not a probability between 0 and 1: 95 % is 0.95.", param, ctx)
        return number


class Profile(click.ParamType[tuple[tuple[float, float], ...]]):
    """A positive number over time: one for all times, or ``SECONDS:NUMBER,…`` with straight lines between."""

    def __init__(self, unit: str) -> None:
        self.name = unit

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[tuple[float, float], ...]:
        """Return times and numbers, or refuse them as a usage error."""
        if isinstance(value, tuple):
            return value
        number, points = Positive(self.name), []
        for part in str(value).split(","):
            time, colon, at = part.rpartition(":")
            points.append((Finite("s").convert(time, param, ctx) if colon else 0.0, number.convert(at, param, ctx)))
        if any(later[0] <= first[0] for first, later in pairwise(points)):
            self.fail(f"the times in '{value}' must ascend: SECONDS:NUMBER,SECONDS:NUMBER.", param, ctx)
        return tuple(points)


class Whole(click.IntRange):
    """A whole number between bounds."""

    name = "n"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """Return the number, or refuse it as a usage error."""
        low = -math.inf if self.min is None else self.min
        high = math.inf if self.max is None else self.max
        try:
            number = int(str(value))
        except ValueError:
            number = None
        if number is None or not low <= number <= high:
            ends = f"from {low} on" if self.max is None else f"from {low} to {high}"
            self.fail(f"{value} is not a whole number {ends}.", param, ctx)
        return number
