"""Types of numbers on the command line, each with its unit."""

from __future__ import annotations

import math

import click


class Finite(click.ParamType[float]):
    """A finite number, in the unit that ``name`` says."""

    required = "finite"

    def __init__(self, unit: str) -> None:
        self.name = unit

    @property
    def wanted(self) -> str:
        """What to write in place of what is no number."""
        return (
            "write a share of one, such as 0.3"
            if self.name == "share"
            else f"write it in {self.name}, without the unit"
        )

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
            self.fail(f"{value} {self.name} must be {self.required}.", param, ctx)
        return number


class Positive(Finite):
    """A finite number above zero, in the unit that ``name`` says."""

    required = "positive and finite"

    def allowed(self, number: float) -> bool:
        """Return whether the number may be given."""
        return number > 0 and math.isfinite(number)


class Probability(click.FloatRange):
    """A probability between 0 and 1."""

    name = "share"

    def __init__(self) -> None:
        super().__init__(0, 1, min_open=True, max_open=True)


class Whole(click.IntRange):
    """A whole number between bounds."""

    name = "n"
