"""Messages that keep their arguments as data, so that each reader sees them in Python or as options."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

# What arguments are called in the text that is being written; those that are not in it have the names of Python.
_CALLED: ContextVar[Mapping[str, str] | None] = ContextVar("called", default=None)


def moment(seconds: float) -> str:
    """Return a time [s] to six digits and at least to the millisecond, so that it can be given as an option.

    Examples
    --------
    >>> moment(0.1234567), moment(726.9871), moment(604800.0625), moment(1.0)
    ('0.123457', '726.987', '604800.062', '1')
    """
    return f"{seconds:.6g}" if not 1e3 <= abs(seconds) < 1e12 else f"{seconds:.3f}".rstrip("0").rstrip(".")


def when(start: float, stop: float) -> str:
    """Return in words a stretch of time [s], which may be a moment.

    Examples
    --------
    >>> when(1.5, 2.0), when(1.0, 1.0)
    ('from 1.5 to 2 s', 'at 1 s')
    """
    return f"from {moment(start)} to {moment(stop)} s" if stop > start else f"at {moment(start)} s"


@dataclass(frozen=True, slots=True)
class Argument:
    """An argument of a function that a message speaks of, with what is given for it.

    Examples
    --------
    >>> str(Argument("fixed")), str(Argument("fixed", "…"))
    ('fixed', 'fixed=…')
    """

    name: str
    value: str | None = None

    def __str__(self) -> str:
        option = (_CALLED.get() or {}).get(self.name)
        name, between = (self.name, "=") if option is None else (option, " ")
        return name if self.value is None else f"{name}{between}{self.value}"


@dataclass(frozen=True, slots=True)
class Entry:
    """One entry of an argument that is a mapping: an item in Python, ``NAME=VALUE`` on the command line.

    Examples
    --------
    >>> print(Entry("scale", "seat", "0"))
    scale['seat']=0
    >>> with called({"scale": "--scale"}):
    ...     print(Entry("scale", "seat", "0"))
    --scale seat=0
    """

    name: str
    key: str
    value: str

    def __str__(self) -> str:
        option = (_CALLED.get() or {}).get(self.name)
        return f"{self.name}[{self.key!r}]={self.value}" if option is None else f"{option} {self.key}={self.value}"


@dataclass(frozen=True, slots=True)
class Listed:
    """An argument of a function with several values: a list in Python, commas on the command line.

    Examples
    --------
    >>> print(Listed("fixed", ("seat.damping", "tire")))
    fixed=['seat.damping', 'tire']
    >>> with called({"fixed": "--fixed"}):
    ...     print(Listed("fixed", ("seat.damping", "tire")))
    --fixed seat.damping,tire
    """

    name: str
    values: tuple[str, ...]

    def __str__(self) -> str:
        option = (_CALLED.get() or {}).get(self.name)
        return f"{self.name}={[*self.values]}" if option is None else f"{option} {','.join(self.values)}"


@dataclass(frozen=True, slots=True)
class AtCommandLine:
    """An option with an example, in brackets, where its likeness in Python is another text or none.

    Examples
    --------
    >>> print("name it by what it measures", AtCommandLine("rename", "a1=seat"), sep="")
    name it by what it measures
    >>> with called({"rename": "--rename"}):
    ...     print("name it by what it measures", AtCommandLine("rename", "a1=seat"), sep="")
    name it by what it measures (--rename a1=seat)
    """

    name: str
    value: str
    otherwise: str = ""

    def __str__(self) -> str:
        option = (_CALLED.get() or {}).get(self.name)
        return self.otherwise if option is None else f" ({option} {self.value})"


@dataclass(frozen=True, slots=True)
class WayOut:
    """What to do, in Python, or on the command line with an option, called ``{option}``, and without it.

    Examples
    --------
    >>> way = WayOut("use .linearised(…)", "linearise", "give {option} 0.1", "take the friction out of the file")
    >>> print(way)
    use .linearised(…)
    >>> with called({"linearise": "--linearise"}):
    ...     print(way)
    give --linearise 0.1
    >>> with called({}):
    ...     print(way)
    take the friction out of the file
    """

    in_python: str
    option: str
    with_option: str
    without: str

    def __str__(self) -> str:
        options = _CALLED.get()
        if options is None:
            return self.in_python
        return self.with_option.format(option=options[self.option]) if self.option in options else self.without


@dataclass(frozen=True, slots=True)
class Wording:
    """A message in parts: text, and the arguments that it speaks of.

    Examples
    --------
    >>> str(Wording(("fix one with ", Argument("fixed", "…"))))
    'fix one with fixed=…'
    """

    parts: tuple[object, ...]

    def __str__(self) -> str:
        return "".join(map(str, self.parts))


def names_in_use() -> Mapping[str, str] | None:
    """Return what arguments are called in the text that is being written; None where they are those of Python.

    Examples
    --------
    >>> with called({"fixed": "--fixed"}):
    ...     names_in_use()
    {'fixed': '--fixed'}
    """
    return _CALLED.get()


@contextmanager
def called(options: Mapping[str, str] | None) -> Iterator[None]:
    """Write arguments as options of a command in the texts that are made within it; as in Python if there are none.

    Examples
    --------
    >>> with called({"fixed": "--fixed"}):
    ...     print(Argument("fixed", "…"), "or", Argument("modes", "2"))
    --fixed … or modes=2
    """
    before = _CALLED.set(options)
    try:
        yield
    finally:
        _CALLED.reset(before)
