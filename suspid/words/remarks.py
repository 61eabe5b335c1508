"""Codes with their words, and remarks: a code with its numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, TypeAlias

from suspid.files import printable
from suspid.values import FrozenItems
from suspid.wording import Wording

Number: TypeAlias = float | int | str | bool | tuple[float, ...] | tuple[int, ...] | tuple[str, ...] | Wording | None
# Things of a kind that one sentence names, and that a list or a picture shows: what fits a screen. The JSON has all.
MOST_NAMED, MOST_LISTED = 3, 6

Words: TypeAlias = str | Callable[[Mapping[str, Number]], str]


def sentence(words: Callable[[Mapping[str, Any]], str]) -> Callable[[Mapping[str, Number]], str]:
    """Return a function of the numbers as it is; type checkers learn from here what it takes.

    Examples
    --------
    >>> sentence(lambda n: f"{n['poles']} poles")({"poles": 3})
    '3 poles'
    """
    return words


class Code(Enum):
    """Something that can be said about a result; each member is defined as ``NAME = "value", words``.

    The words are a template of `str.format_map`, or a function of the numbers where a template does not do. The value
    is what JSON and tables hold; it never changes once published.

    Examples
    --------
    >>> class Reason(Code):
    ...     TONE = "tone", "steady tone at {hertz:.4g} Hz"
    >>> Reason("tone") is Reason.TONE, Reason.TONE.words
    (True, 'steady tone at {hertz:.4g} Hz')
    """

    words: Words

    def __new__(cls, value: str, words: Words = "") -> Code:
        """Make a member whose value is the code alone."""
        member = object.__new__(cls)
        member._value_ = value
        member.words = words
        return member

    def __str__(self) -> str:
        return str(self.value)


@dataclass(frozen=True, slots=True)
class Remark:
    """One thing said about a result: a code with its numbers.

    Parameters
    ----------
    code : Code
        What is said.
    numbers : mapping
        Numbers and names that belong to it, in SI units. Names from files stand as they are; the sentence has their
        control characters escaped, and markup is left to whoever shows it.
    of : str
        What it is said of, where that is a part of the whole, such as one of several records; the sentence begins
        with it.

    Examples
    --------
    >>> class Reason(Code):
    ...     TONE = "tone", "steady tone at {hertz:.4g} Hz"
    >>> remark = Remark(Reason.TONE, {"hertz": 33.98712})
    >>> str(remark), remark.to_dict()["code"]
    ('steady tone at 33.99 Hz', 'tone')
    """

    code: Code
    numbers: Mapping[str, Number] = field(default_factory=dict, hash=False)
    of: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "numbers", FrozenItems(self.numbers))

    def __str__(self) -> str:
        words = self.code.words
        said = words.format_map(self.numbers) if isinstance(words, str) else words(self.numbers)
        said = f"{self.of}: {said}" if self.of else said
        return "\n".join(map(printable, said.split("\n"))) if not said.isprintable() else said

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle without the read-only view."""
        return Remark, (self.code, dict(self.numbers), self.of)

    def to_dict(self) -> dict[str, object]:
        """Return code, numbers and sentence, for JSON.

        Examples
        --------
        >>> from suspid import grip, quarter_car
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
        ...                   chassis_damping=650, tire_damping=60)
        >>> remark = grip(car).verdict.headline
        >>> remark.to_dict()
        {'code': 'grip', 'numbers': {'names': ['tire']}, 'text': 'grip of tire'}
        """
        return {
            "code": str(self.code),
            "numbers": {name: _plain(number) for name, number in self.numbers.items()},
            "text": str(self),
        }


def _plain(number: Number) -> object:
    """Return a number as JSON has it."""
    return list(number) if isinstance(number, tuple) else str(number) if isinstance(number, Wording) else number


def count(number: int, noun: str) -> str:
    """Return a number with its noun.

    Examples
    --------
    >>> count(1, "gap"), count(3, "gap")
    ('1 gap', '3 gaps')
    """
    return f"{number} {noun}{'s' * (number != 1)}"


def amount(value: float) -> str:
    """Return a number with two digits, or all digits before the point, without an exponent.

    Examples
    --------
    >>> amount(2.53), amount(183.4), amount(13500.0)
    ('2.5', '183', '13500')
    """
    return f"{value:.0f}" if abs(value) >= 10 else f"{value:.2g}"


def percent(share: float) -> str:
    """Return a share in per cent with two digits, or all digits before the point, without an exponent.

    Examples
    --------
    >>> percent(0.9999), percent(0.123), percent(0.00456)
    ('100 %', '12 %', '0.46 %')
    """
    return f"{amount(100 * share)} %"


def in_a_row(parts: Sequence[object]) -> str:
    """Return names in a row, the last one after an "and".

    Examples
    --------
    >>> in_a_row([1, 2, 3])
    '1, 2 and 3'
    """
    names = [str(part) for part in parts]
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
