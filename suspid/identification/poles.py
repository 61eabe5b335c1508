"""Poles of damped exponentials, in units of the sampling step."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from suspid.levels import EXACT
from suspid.units import ComplexArray, RealArray
from suspid.values import frozen_complex

# A pole decays by at most this many e-foldings per sample: a faster one shows in a single sample.
FASTEST = 3.0
# A pole grows by at most this many e-foldings over the record: enough to recognise that it grows.
MOST_GROWTH = 3.0
# Least imaginary part of a pair, over the record and over its real part to the next power of two: with less it cannot
# be distinguished from two real poles.
AXIS_TURN, AXIS_RATIO = 1e-3, 1e-2
# Two real poles whose rates differ by less than this factor have met.
AS_ONE = 1.05


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Poles:
    """Exponents per sample, ``pole * step``."""

    pairs: ComplexArray  # (pair,): of complex pairs, the one in the upper half plane
    reals: RealArray  # (real,): of real poles
    nuisances: RealArray  # (nuisance,): of the offset and drift, held fixed

    @property
    def exponents(self) -> ComplexArray:
        """All exponents: pairs, their conjugates, reals, nuisances."""
        return np.concatenate([self.pairs, self.pairs.conj(), self.reals, self.nuisances])

    @property
    def free(self) -> int:
        """Number of real parameters."""
        return 2 * len(self.pairs) + len(self.reals)

    def __len__(self) -> int:
        return 2 * len(self.pairs) + len(self.reals) + len(self.nuisances)

    @property
    def every(self) -> ComplexArray:
        """The free poles: pairs (upper half plane), then reals."""
        return np.concatenate([self.pairs, self.reals])

    @property
    def rows(self) -> NDArray[np.intp]:
        """Where the free poles stand among `exponents`."""
        return np.concatenate([np.arange(len(self.pairs)), 2 * len(self.pairs) + np.arange(len(self.reals))])

    @property
    def chart(self) -> ComplexArray:
        """Derivatives of `exponents` by the real parameters, (exponent, parameter): Re, Im of each pair; each real."""
        return _chart(len(self.pairs), len(self.reals), len(self))

    @property
    def parameters(self) -> RealArray:
        """The real parameters: Re and Im of each pair; each real."""
        return np.concatenate([self.pairs.view(float), self.reals])

    @property
    def meet(self) -> bool:
        """Whether two real poles have become one: in search of a pair, they have no optimum."""
        rates = np.sort(-self.reals)
        return bool(np.any(rates[1:] < AS_ONE * rates[:-1]))

    def pinned(self, gradient: RealArray, count: int) -> NDArray[np.bool_] | None:
        """Return which real parameters are at a bound of `moved_within` and would leave it uphill, None for none."""
        pairs, highest, low = len(self.pairs), MOST_GROWTH / count, 2 * AXIS_TURN / count
        # Plain numbers: arrays of a few take ten times as long.
        if all(-FASTEST < rate < highest for rate in self.reals.tolist()) and all(
            -FASTEST < pole.real < highest and low < pole.imag < np.pi and 2 * AXIS_RATIO * abs(pole.real) < pole.imag
            for pole in self.pairs.tolist()
        ):
            return None
        rates = np.concatenate([self.pairs.real, self.reals])
        uphill = gradient > 0
        where = np.concatenate([np.arange(pairs) * 2, np.arange(2 * pairs, len(gradient))])
        out = np.zeros(len(gradient), bool)
        out[where] = np.where(uphill[where], rates >= highest, rates <= -FASTEST)
        lowest = (1 + EXACT) * _lowest(self.pairs.real, count)
        out[1 : 2 * pairs : 2] = np.where(
            uphill[1 : 2 * pairs : 2], self.pairs.imag >= np.pi, self.pairs.imag <= lowest
        )
        return out if out.any() else None

    def moved(self, step: RealArray) -> Poles:
        """Return the poles after a step in (Re, Im of each pair; each real)."""
        pairs, reals = len(self.pairs), len(self.reals)
        change = step[: 2 * pairs].reshape(pairs, 2)
        return Poles(
            pairs=self.pairs + change[:, 0] + 1j * change[:, 1],
            reals=self.reals + step[2 * pairs : 2 * pairs + reals],
            nuisances=self.nuisances,
        )

    def with_pair(self, theta: complex) -> Poles:
        """Return the poles with one more pair."""
        return Poles(pairs=np.append(self.pairs, theta), reals=self.reals, nuisances=self.nuisances)

    def with_two(self, which: int, two: ComplexArray) -> Poles:
        """Return the poles with two pairs, the last ones, in place of one."""
        pairs = np.append(np.delete(self.pairs, which), two.real + 1j * np.abs(two.imag))
        return Poles(pairs=pairs, reals=self.reals, nuisances=self.nuisances)

    def with_real(self, theta: float) -> Poles:
        """Return the poles with one more real pole."""
        return Poles(pairs=self.pairs, reals=np.append(self.reals, theta), nuisances=self.nuisances)

    def without(self, index: int) -> Poles:
        """Return the poles without one, counted over pairs then reals."""
        pairs = len(self.pairs)
        if index < pairs:
            return Poles(pairs=np.delete(self.pairs, index), reals=self.reals, nuisances=self.nuisances)
        return Poles(pairs=self.pairs, reals=np.delete(self.reals, index - pairs), nuisances=self.nuisances)

    def moved_within(self, step: RealArray, count: int) -> Poles:
        """Return the poles after a step shortened to the range of a quadratic model, and kept within bounds.

        Where an imaginary part changes by much of itself, its square moves along the tangent: two poles that meet
        depend on it smoothly.
        """
        pairs, highest = len(self.pairs), MOST_GROWTH / count
        reach = np.abs(np.concatenate([self.pairs.real.repeat(2), self.reals])) + 1.5 / count
        along, im, turns = np.abs(step), self.pairs.imag, slice(1, 2 * pairs, 2)
        far = along[turns] > 0.5 * im
        if far.any():
            along[turns][far] = np.abs(_turned(im, step[turns]) - im)[far]
        step = step / max(1.0, float((along / reach).max()))
        moved = self.parameters + step
        if far.any():
            moved[turns][far] = _turned(im, step[turns])[far]
        re = np.minimum(np.maximum(moved[: 2 * pairs : 2], -FASTEST), highest)
        im = np.minimum(np.maximum(moved[turns], _lowest(re, count)), np.pi)
        reals = np.minimum(np.maximum(moved[2 * pairs :], -FASTEST), highest)
        return Poles(pairs=re + 1j * im, reals=reals, nuisances=self.nuisances)


def _turned(imag: RealArray, step: RealArray) -> RealArray:
    """Return imaginary parts after a step, 0 where two poles would leave each other along the real axis."""
    return np.sqrt(np.maximum(imag * (imag + 2 * step), 0.0))


def _lowest(rates: RealArray, count: int) -> RealArray:
    """Return the least imaginary parts of pairs of given real parts, (pair,).

    They follow the real parts by factors of two: a pair that is held there has an optimum of its real part.
    """
    return np.maximum(AXIS_TURN / count, np.ldexp(AXIS_RATIO, np.frexp(rates)[1]))


@lru_cache(maxsize=256)
def _chart(pairs: int, reals: int, exponents: int) -> ComplexArray:
    """Return d(exponent) / d(real parameter), (exponent, parameter)."""
    chart = np.zeros((exponents, 2 * pairs + reals), complex)
    i = np.arange(pairs)
    chart[i, 2 * i], chart[i, 2 * i + 1] = 1, 1j
    chart[pairs + i, 2 * i], chart[pairs + i, 2 * i + 1] = 1, -1j
    j = np.arange(reals)
    chart[2 * pairs + j, 2 * pairs + j] = 1
    return frozen_complex(chart)
