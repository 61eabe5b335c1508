"""Inner products of damped exponentials with each other and with a record, without an exp per sample.

With ``z = exp(theta)`` and k the number of the sample, every inner product that a fit needs is a sum
over k of ``(k / n)^j exp(phi k)``: in closed form between two exponentials, and with the record as
two small matrix products, since ``z^(a B + b) = z^(a B) z^b``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import comb, factorial

import numpy as np
from numpy.typing import NDArray

from suspid.units import ComplexArray, RealArray
from suspid.values import frozen_complex, frozen_real

# Below this |n phi| the closed forms lose digits, and a power series of this many terms is used: 2^26 / 26! is
# rounding.
SERIES_REACH = 2.0
SERIES_TERMS = 26
# E-foldings after which an exponential adds less to an inner product than its rounding: exp(-40) = 4e-18. In records of
# fewer blocks than the second number, looking for those that have gone takes as long as it saves.
GONE, MANY_BLOCKS = 40.0, 256
ROOT_2 = float(np.sqrt(2.0))


def power_sums(phi: ComplexArray, count: int, *, order: int = 2) -> ComplexArray:
    """Return ``sum_k (k / n)^j exp(phi k)`` over k = 0 … n - 1, (j, …), for j up to an order of 2 to 4.

    Exponents are per sample. Geometric series and its derivatives: with ``u = exp(phi)`` and ``E = exp(n phi)``,
    ``S0 = (E - 1) / (u - 1)``, ``S1 = (n E - u S0) / (u - 1)``,
    ``S2 = (n^2 E - u (2 S1 + S0)) / (u - 1)``, each over n^j; near ``phi = 0`` a power series.

    Examples
    --------
    >>> import numpy as np
    >>> zeroth, first, second = power_sums(np.array([0j]), 5)
    >>> zeroth.real, first.real
    (array([5.]), array([2.]))
    """
    near = np.abs(phi) < SERIES_REACH / count
    safe = np.where(near, -1.0, phi)
    below = 1 / np.expm1(safe)
    last = np.exp(safe * count)
    sums = np.empty((order + 1, *phi.shape), complex)
    # (E - 1) / (u - 1) in units of n: u / (u - 1) = 1 + 1 / (u - 1).
    sums[0] = (last - 1) * below
    ended, ratio = last * below, (1 + below) / count
    sums[1] = ended - sums[0] * ratio
    sums[2] = ended - (2 * sums[1] + sums[0] / count) * ratio
    for j in range(3, order + 1):
        earlier = sum(comb(j, m) * sums[m] / count ** (j - 1 - m) for m in range(j))
        sums[j] = ended - earlier * ratio
    if near.any():
        x, moments = phi[near] * count, _power_means(count)[:, : order + 1]
        if x.any():
            powers = np.ones((len(x), SERIES_TERMS), complex)
            powers[:, 1:] = x[:, None]
            sums[:, near] = (np.multiply.accumulate(powers, axis=1) @ moments).T
        else:
            # A constant against itself.
            sums[:, near] = moments[0][:, None]
    return sums


def gram_sums(pairs: ComplexArray, reals: RealArray, count: int) -> RealArray:
    """Return ``sum_k (k / n)^j f_i(k) f_l(k)``, (j, i, l), for j = 0, 1, 2, in a real basis of the exponentials.

    The basis is that of `real_powers`: real and imaginary parts of the pairs (those of the upper half plane) times the
    square root of 2, then the real exponentials. Each sum of products of exponentials is computed once.

    Examples
    --------
    >>> import numpy as np
    >>> gram, _, _ = gram_sums(np.array([2j]), np.zeros(1), 3)
    >>> cosines = np.sqrt(2) * np.cos(2.0 * np.arange(3))
    >>> bool(np.isclose(gram[0, 0], cosines @ cosines)), bool(np.isclose(gram[0, 2], cosines.sum()))
    (True, True)
    """
    size, of_pairs = 2 * len(pairs) + len(reals), len(pairs) * (len(pairs) + 1) // 2
    left, right, place = _products_of_parts(len(pairs), len(reals))
    theta = np.concatenate([pairs, pairs.conj(), reals])
    sums = power_sums(theta[left] + theta[right], count)
    # Products of a pair's conjugate and a pair, of two pairs, of a pair and a real exponential, of two of those.
    same, crossed = sums[:, :of_pairs], sums[:, of_pairs : 2 * of_pairs]
    mixed = ROOT_2 * sums[:, 2 * of_pairs : 2 * of_pairs + len(pairs) * len(reals)]
    more, less = (same + crossed).view(float), (same - crossed).conj().view(float)
    rest = sums[:, 2 * of_pairs + mixed.shape[1] :].view(float)
    return np.concatenate([more, less, mixed.view(float), rest], axis=1).take(place, axis=1).reshape(3, size, size)


@lru_cache(maxsize=256)
def _products_of_parts(pairs: int, reals: int) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
    """Return the exponents whose sums `gram_sums` needs, and where each product of the basis stands among its parts.

    The exponents are pairs, their conjugates and real ones. Parts are the real and imaginary part of each, in turns.
    """
    one, other = np.triu_indices(pairs)
    pair, real = np.divmod(np.arange(pairs * reals), max(reals, 1))
    first, second = np.triu_indices(reals)
    left = np.concatenate([pairs + one, one, pair, 2 * pairs + first])
    right = np.concatenate([other, other, 2 * pairs + real, 2 * pairs + second])
    place = np.zeros((2 * pairs + reals, 2 * pairs + reals), np.intp)
    more = 2 * np.arange(len(one))
    less, mixed = more + 2 * len(one), 4 * len(one) + 2 * np.arange(len(pair))
    rest = 4 * len(one) + 2 * len(pair) + 2 * np.arange(len(first))
    for i, k, at in (
        (one, other, more),
        (pairs + one, pairs + other, less),
        (one, pairs + other, more + 1),
        (pairs + one, other, less + 1),
        (pair, 2 * pairs + real, mixed),
        (pairs + pair, 2 * pairs + real, mixed + 1),
        (2 * pairs + first, 2 * pairs + second, rest),
    ):
        place[i, k] = place[k, i] = at
    return left, right, place.ravel()


@lru_cache(maxsize=256)
def turn_of(pairs: int, size: int) -> ComplexArray:
    """Return the unitary matrix that turns amplitudes of the real basis to those of a number of exponentials.

    Examples
    --------
    >>> turn_of(1, 2).round(2)
    array([[0.71+0.j  , 0.  -0.71j],
           [0.71+0.j  , 0.  +0.71j]])
    """
    half, one = 1 / ROOT_2, np.arange(pairs)
    turn = np.eye(size, dtype=complex)
    turn[one, one] = turn[pairs + one, one] = half
    turn[one, pairs + one], turn[pairs + one, pairs + one] = -1j * half, 1j * half
    return frozen_complex(turn)


def cross_sums(left: ComplexArray, right: ComplexArray, count: int) -> ComplexArray:
    """Return ``sum_k exp((left_i + right_j) k)``, (left, right), by outer products of few exponentials.

    Near ``left + right = 0`` it is left to `power_sums`; elsewhere about 4 / (n |left + right|) units of
    rounding are lost, which does not matter for the choice of candidates.
    """
    phi = left[:, None] + right
    ratio = np.exp(left)[:, None] * np.exp(right) - 1
    near = np.abs(phi) * count < SERIES_REACH
    sums = (np.exp(count * left)[:, None] * np.exp(count * right) - 1) / np.where(near, 1.0, ratio)
    if near.any():
        sums[near] = power_sums(phi[near], count)[0]
    return np.asarray(sums)


@lru_cache(maxsize=64)
def _power_means(count: int) -> ComplexArray:
    """Return ``sum_k (k / n)^(m + j) / m!``, (m, j), for every m of the series and j = 0 … 4."""
    power = np.arange(SERIES_TERMS + 4, dtype=float)
    if count > 4096:
        # Euler-Maclaurin: the integral and corrections at the ends. The next correction is below rounding here.
        sums = count / (power + 1) - 0.5 + np.where(power > 1, power, 0.0) / (12 * count)
        sums[0] = count
    else:
        sums = np.array([np.sum((np.arange(count) / count) ** m) for m in power])
    factorials = np.array([factorial(m) for m in range(SERIES_TERMS)], float)
    return frozen_complex(np.stack([sums[j : j + SERIES_TERMS] for j in range(5)], axis=1) / factorials[:, None])


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Blocks:
    """A record cut into blocks, ready for inner products with exponentials."""

    count: int  # number of samples n
    folded: RealArray  # (channel, block, sample): the record; zeros after its last sample
    energy: RealArray  # (channel,): sum of squares of each channel
    sums: ComplexArray  # (j, 1, channel): `project` on a constant, which is part of every fit

    @property
    def channels(self) -> int:
        """Number of channels."""
        return len(self.energy)

    def project(self, theta: ComplexArray) -> ComplexArray:
        """Return ``sum_k (k / n)^j y_k conj(exp(theta k))``, (j, exponent, channel), for j = 0 and 1."""
        if len(theta) == 1 and not theta[0]:
            return self.sums
        return _moments(self.folded, theta, self.count, 2)


def blocks_of(values: RealArray) -> Blocks:
    """Return a record (channel, sample) cut into blocks of about the square root of its length."""
    channels, count = values.shape
    size = max(8, int(np.sqrt(count)))
    folded = np.zeros((channels, -(-count // size) * size))
    folded[:, :count] = values
    sums = np.stack([values.sum(axis=1), values @ (np.arange(count) / count)])[:, None]
    return Blocks(
        count=count,
        folded=folded.reshape(channels, -1, size),
        energy=inner_products(values, values),
        sums=sums.astype(complex),
    )


def inner_products(one: RealArray, other: RealArray) -> RealArray:
    """Return the sum over samples of the products of two records, (channel,); `numpy.einsum` takes three times as long.

    Examples
    --------
    >>> inner_products(np.array([[1.0, 2.0], [3.0, 4.0]]), np.ones((2, 2)))
    array([3., 7.])
    """
    return np.asarray((one[:, None] @ other[:, :, None])[:, 0, 0])


def project(values: RealArray, theta: ComplexArray, *, orders: int = 1) -> ComplexArray:
    """Return ``sum_k (k / n)^j y_k conj(exp(theta k))``, (j, exponent, channel), of a record that is used once."""
    channels, count = values.shape
    size = max(1, int(np.sqrt(count)))
    whole = count // size * size
    # Blocks of the record as it lies there: a copy of a long one takes longer than its products.
    sums = _moments(values[:, :whole].reshape(channels, -1, size), theta, count, orders)
    k = np.arange(whole, count)
    rest = values[:, whole:] * (k / count) ** np.arange(orders)[:, None, None]
    return np.asarray(sums + np.exp(np.multiply.outer(theta.conj(), k)) @ rest.swapaxes(1, 2))


def _moments(folded: RealArray, theta: ComplexArray, count: int, orders: int) -> ComplexArray:
    """Return the inner products of rows cut into blocks with exponentials times powers of ``k / n``.

    From rows (row, block, sample) to (j, exponent, row), for j below a number of orders. In long records, exponentials
    that have gone are multiplied with the first half of the blocks, the first quarter, and so on.
    """
    blocks, size = folded.shape[1:]
    if blocks < MANY_BLOCKS:
        return _block_moments(folded, theta, count, orders)
    needed = GONE / size / np.maximum(-theta.real, GONE / size / blocks)
    halvings = np.log2(blocks / np.maximum(needed, 1.0)).astype(int)
    sums = np.empty((orders, len(theta), len(folded)), complex)
    for n in set(halvings.tolist()):
        sums[:, halvings == n] = _block_moments(folded[:, : -(-blocks >> n)], theta[halvings == n], count, orders)
    return sums


def _block_moments(folded: RealArray, theta: ComplexArray, count: int, orders: int) -> ComplexArray:
    """Return `_moments` from all blocks.

    With k counted from the block and the block from the first, ``k^j`` is a binomial of both: each sample is read once.
    """
    rows, blocks, size = folded.shape
    within, among = _ramps(size, blocks, count, orders)
    inner, outer = _powers(theta.conj(), size, blocks)
    inner = (within * inner[:, None]).reshape(size, -1)
    # Real times complex as one real product: numpy would first make the record complex.
    partial = (folded @ inner.view(float)).view(complex).reshape(rows, blocks, orders, -1)
    weights = (outer.T[:, None, None] * among).reshape(-1, orders, orders * blocks)
    sums = weights @ partial.transpose(3, 2, 1, 0).reshape(-1, orders * blocks, rows)
    return np.asarray(sums.swapaxes(0, 1))


@lru_cache(maxsize=64)
def _ramps(size: int, blocks: int, count: int, orders: int) -> tuple[RealArray, RealArray]:
    """Return powers of ``k / n`` for k within a block, (sample, power, 1), and what they are multiplied by in each.

    The latter are the binomial terms of each power of ``k / n`` over those within, (power, power within, block).
    """
    within = (np.arange(size)[:, None, None] / count) ** np.arange(orders)[:, None]
    first = np.arange(blocks) * size / count
    among = np.zeros((orders, orders, blocks))
    for j, m in np.ndindex(orders, orders):
        if m <= j:
            among[j, m] = comb(j, m) * first ** (j - m)
    return frozen_real(within), frozen_real(among)


def _powers(theta: ComplexArray, size: int, blocks: int) -> tuple[ComplexArray, ComplexArray]:
    """Return ``exp(theta b)``, (sample, exponent), and ``exp(theta B a)``, (block, exponent)."""
    powers = _successive(np.exp(np.concatenate([theta, size * theta])), max(size, blocks))
    return powers[:size, : len(theta)], powers[:blocks, len(theta) :]


def _successive(ratio: ComplexArray, count: int) -> ComplexArray:
    """Return the powers 0 … count - 1 of numbers, (power, number), by doubling: one rounding more each time."""
    powers = np.empty((count, len(ratio)), complex)
    powers[0] = 1.0
    done, last = 1, ratio
    while done < count:
        more = min(done, count - done)
        np.multiply(powers[:more], last, out=powers[done : done + more])
        done, last = done + more, last * last
    return powers


def real_powers(theta: ComplexArray, pairs: int, count: int) -> RealArray:
    """Return a real basis of the space of exponentials, (sample, number); `turn_of` is the matrix that turns to it.

    The exponents are pairs, their conjugates and real ones; the basis is real and imaginary parts of the pairs times
    the square root of 2, then the others. Amplitudes (exponent, channel) are the matrix times those of the basis.

    Examples
    --------
    >>> theta = np.array([-0.1 + 0.5j, -0.1 - 0.5j, -0.2])
    >>> basis = real_powers(theta, 1, 6)
    >>> bool(np.allclose(np.exp(np.outer(np.arange(6), theta)), basis @ turn_of(1, 3).conj().T))
    True
    """
    size = max(8, int(np.sqrt(count)))
    alone = np.concatenate([theta[:pairs], theta[2 * pairs :]])
    inner, outer = _powers(alone, size, -(-count // size))
    powers = (outer[:, None] * inner).reshape(-1, len(alone))[:count]
    upper = ROOT_2 * powers[:, :pairs]
    return np.concatenate([upper.real, upper.imag, powers[:, pairs:].real], axis=1)


def synthesize(theta: ComplexArray, amplitudes: ComplexArray, count: int) -> RealArray:
    """Return ``Re sum_i amplitudes[i] exp(theta_i k)``, (channel, sample), from amplitudes (exponent, channel)."""
    size = max(8, int(np.sqrt(count)))
    inner, outer = _powers(theta, size, -(-count // size))
    out = np.empty((amplitudes.shape[1], len(outer) * size))
    # Real and imaginary parts as one real product: half the work, no complex intermediate.
    right = np.concatenate([inner.real.T, -inner.imag.T])
    for channel, amplitude in enumerate(amplitudes.T):
        left = outer * amplitude
        out[channel] = (np.concatenate([left.real, left.imag], axis=1) @ right).ravel()
    return out[:, :count]
