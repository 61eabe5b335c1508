"""Levels that all packages share: significance, probability of intervals, accuracy of numbers, ends of descents."""

from __future__ import annotations

from collections.abc import Callable, Collection

from suspid.errors import InputError
from suspid.units import Ratio
from suspid.wording import Argument

# Probability of intervals where no other is asked for.
LEVEL = 0.95
# Standard deviations of the interval that holds 95 % of a normal variable.
NORMAL_95 = 1.959963984540054
# Median of |z| for standard normal z.
NORMAL_MEDIAN = 0.6744897501960817
# Rise of chi-square up to which two values of one unknown are equally likely: 95 % of one degree of freedom.
CHI_SQUARE_95 = NORMAL_95**2
# Probability below which chance is no explanation: one false alarm in a thousand. A smaller one lets weak misfits pass.
UNLIKELY = 1e-3
# A record or half of one with fewer samples is not fitted.
FEWEST_SAMPLES = 32
# Relative. Numbers in double precision that should be equal agree to this: one eigenvalue problem solved in two ways, a
# file written with all digits. What is smaller beside the largest is rounding; a tighter limit fails on it.
EXACT = 1e-9
# The same for numbers that were stored in single precision, or written with seven digits.
SEVEN_DIGITS = 1e-6
# Share of the largest below which a number counts as zero where all were computed in one step.
ROUNDING = 1e-12
# Standard deviations from which on a difference is no chance: 0.1 % of a normal variable on one side.
SURE = 3.0
# The same where many cases are tried, each of which could be chance.
CERTAIN = 5.0
# Pieces of a record whose scatter tells that of the whole: twenty know it to a sixth. Samples of one may be correlated.
PIECES_OF_RECORD = 20
# Bounds of parameters that are looked at together, the nearest ones: a full car has four mounts; each doubles the time.
MOST_BOUNDS = 8
# Relative difference of two sampling rates up to which they are equal: the crystals of loggers are no better, and poles
# are shifted by as much. A smaller one has records of one logger resampled.
EQUAL_RATE = 1e-5
# Gain of chi-square, or of twice the log likelihood, that ends a descent: a hundredth of a standard deviation.
NEGLIGIBLE_GAIN = 1e-4


def likely(chi_square: float, freedom: float) -> bool:
    """Return whether a chi-square is not improbably large; without degrees of freedom nothing is.

    Examples
    --------
    >>> likely(20.0, 1), likely(20.0, 9), likely(-1.0, 1)
    (False, True, True)
    """
    from scipy.special import chdtrc

    return freedom <= 0 or bool(chdtrc(freedom, max(chi_square, 0.0)) >= UNLIKELY)


# Largest probability of an interval that is computed, seven standard deviations; its rest to one is still no rounding.
MOST_LEVEL = 1 - 1e-12


def check_level(level: Ratio) -> None:
    """Refuse what is no probability of an interval.

    Examples
    --------
    >>> check_level(95)
    Traceback (most recent call last):
    suspid.errors.InputError: level=95 must lie between 0 and 1, such as 0.95
    """
    if isinstance(level, str | bool) or not 0 < level < 1:
        raise InputError(Argument("level", repr(level)), f" must lie between 0 and 1, such as {LEVEL}")
    if level > MOST_LEVEL:
        raise InputError(Argument("level", repr(level)), " is 1 to rounding; such an interval is unbounded")


def normal_reach(level: Ratio) -> float:
    """Return half the width of the interval that holds a normal variable with probability ``level`` [sd].

    Examples
    --------
    >>> abs(normal_reach(0.95) - NORMAL_95) < 1e-12
    True
    """
    from scipy.special import ndtri

    return float(ndtri((1 + level) / 2))


def beyond_chance(outside: Callable[[Ratio], Collection[str]], count: int, level: Ratio = LEVEL) -> frozenset[str]:
    """Return which of several parameters are apart from what is expected, by the procedure of Holm.

    Were all of ``count`` as expected, one of them would be named with a probability of ``1 - level`` at most, however
    many there are (S. Holm, Scand. J. Statist. 6 (1979) 65-70).

    Parameters
    ----------
    outside : callable
        Returns the names of those whose intervals of a probability leave out what is expected.
    count : int
        How many are tested.
    level : float
        Probability that none is named where all are as expected [1].

    Examples
    --------
    >>> apart = {"a": 3.0, "b": 2.3, "c": 2.0, "d": 0.1}  # standard deviations
    >>> sorted(beyond_chance(lambda p: [name for name, z in apart.items() if z > normal_reach(p)], 4))
    ['a']
    """
    named: frozenset[str] = frozenset()
    while len(named) < count:
        more = frozenset(outside(min(1 - (1 - level) / (count - len(named)), MOST_LEVEL)))
        if more == named:
            break
        named = more
    return named
