"""How many modes, and where: poles are added while the record pays for them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from suspid.identification.covariance import inverse_information
from suspid.identification.exponentials import Blocks, blocks_of, cross_sums, synthesize
from suspid.identification.likelihood import DecayFit, evaluate, maximize, reweighed
from suspid.identification.noise import LOUD, WhiteNoise, loss_growth, loudness, over_channels, power_beside
from suspid.identification.poles import Poles
from suspid.units import ComplexArray, RealArray
from suspid.values import frozen_real
from suspid.words import Reason, Remark

# The grid of decay rates: from one e-folding over the record to one per sample, by about this factor. Midway between
# two of them a pole still shows 89 % of its energy, and one that does not decay shows 92 % on the first.
DECAY_FACTOR = 4.0
# A decaying exponential counts as gone after so many e-foldings, and is as wide as the Fourier bins of so many.
GONE, WIDE = 9.0, 3.0
# While poles are still to come, the others need not be fitted better than to this share of their standard deviations,
# and not by more steps: a pole that is there comes near in fewer.
ROUGH, ROUGH_STEPS = 0.05, 20
# Grid points whose gain is computed exactly, beyond those beside poles already fitted.
LOCAL_MAXIMA = 48
# So many points beside each pole already fitted, from one end of its surroundings to the other.
BETWEEN = np.arange(13)
# They are looked at with decay rates down to that of the pole over the first figure, and up to its times the second.
NARROWER, WIDER = 8.0, 32.0
# Candidates refitted before giving up, and the share of the price below which none is.
TRIES = 3
MOST_CANDIDATES = 12
HOPELESS = 0.7
# Candidates worth so many times their price and so many linewidths apart are fitted together; they stay where each then
# gains its price the third figure's times.
SOUND, APART, STRONG = 3.0, 4.0, 10.0
MOST_POLES = 16
# Power beside a pole over that of white noise: the gain of a pole is divided by it from this value on.
COLOURS_BEGIN = 1.5
# Where the power beside a pole exceeds `noise.LOUD` the model is wrong by more than the noise: a pole must then explain
# this many times more than what is left beside it.
WORTHWHILE = 20.0
# Poles nearer to each other than so many decay rates (the geometric mean of theirs) are one mode, not quite linear;
# if they move alike in all channels (by this assurance criterion), so are poles as near as the third figure, unless
# their natural frequencies are further apart than by the fourth: what is not quite linear bends a frequency by less.
DISTINCT, ALIKE, DISTINCT_ALIKE, ANOTHER = 0.25, 0.9, 2.0, 1.35
# A pole that decays less than this over the record, known no better than this many standard deviations, is a tone.
TONE_DECAY, TONE_SURE = 0.25, 10.0

# A real pole is exchanged for a pair where that gains this much per parameter; it is a mode only if the pair gains no
# more than chance and so many of its standard deviations, and the pole itself so much that a pair would show.
PAIR_GAIN, PAIR_EXCLUDED, REAL_SURE = 3.5, 1.0, 150.0

# Poles below these exponents over the record creep: the first always, the second once all else is fitted. Exponentials
# of the last three together are an offset, a slope and a bend, to within some 1e-4 of a drift.
STILL, CREEPING, BENT = 0.3, 3.0, frozen_real([0.0, -0.3, 0.3])

# A pole that falls by more than this in one sample is gone before it can be seen to swing.
BRIEF = 0.5


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Candidate:
    """A pole worth trying: exponent per sample, and what it would gain in twice the log likelihood."""

    theta: complex
    real: bool
    gain: float


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Selection:
    """The poles that the record pays for.

    Parameters
    ----------
    fit : DecayFit
        All poles, modes and nuisances alike.
    reasons : tuple of Reason or None
        Why each free pole (pairs, then reals) is no mode; None for a mode.
    gains : ndarray (pole,)
        What each is worth in twice the log likelihood, by leaving it out.
    loudness : ndarray (pole,)
        Power of the residual near each pole over that of the noise; 1 where they agree.
    residual : ndarray (channel, sample)
        What the fit leaves.
    rejected : tuple of (Candidate, Remark)
        Poles that were tried and not kept, and why.
    """

    fit: DecayFit
    reasons: tuple[Reason | None, ...]
    gains: RealArray
    loudness: RealArray
    residual: RealArray
    rejected: tuple[tuple[Candidate, Remark], ...]

    @property
    def modes(self) -> NDArray[np.intp]:
        """Which of the free poles are modes, (mode,)."""
        return np.flatnonzero([reason is None for reason in self.reasons])


def price(channels: int, samples: int, *, real: bool = False) -> float:
    """Return what a pole must gain in twice the log likelihood: BIC's ``log(samples)`` for each of its parameters."""
    return (1 if real else 2) * (1 + channels) * float(np.log(samples))


def select(
    values: RealArray,
    *,
    noise: WhiteNoise,
    modes: int | None = None,
    band: tuple[float, float] = (0.0, np.pi),
) -> Selection:
    """Return the poles of a record, found one after another from its own residual.

    The next pole is that of largest gain over a grid of frequency and decay rate, orthogonal to what
    is fitted already; then all poles are refitted together. A pole stays if it gains more than its
    price, times how loud the residual is near it.

    Parameters
    ----------
    values : ndarray (channel, sample)
        The record, without its mean.
    noise : WhiteNoise
        The noise model, with the least variance of each channel.
    modes : int, optional
        Take the strongest so many of those found for modes.
    band : (float, float)
        Angular frequencies per sample between which a pole can be a mode.
    """
    blocks = blocks_of(values)
    noise = noise.rounded(blocks.energy, blocks.count)
    state = _State(values=values, blocks=blocks, noise=noise, band=band)
    nothing = evaluate(blocks, Poles(pairs=np.zeros(0, complex), reals=np.zeros(0), nuisances=np.zeros(1)), noise)
    assert nothing is not None
    held = _Held(state=state, fit=nothing)
    rejected: list[tuple[Candidate, Remark]] = []
    seen: _Points | None = None
    while held.poles.free < 2 * MOST_POLES and np.any(held.variance > noise.least):
        # What the strongest poles hid may stand out where one looked before; if not, look everywhere.
        found = [] if seen is None else _ranked(held.fit, held.variance, seen)
        again = bool(found) and found[0].gain > STRONG * state.price(real=False)
        if not again:
            seen = _searched(held.fit, held.residual, held.variance)
            found = _ranked(held.fit, held.variance, seen)
        better = _extended(state, held, found, rejected)
        if better is None:
            break
        held, seen = _straightened(state, better, STILL, rejected), None if again else seen
    held = state.polished(held)
    straight = _straightened(state, _single(state, held), CREEPING, rejected)
    held = _unbent(state, held if straight is held else state.polished(straight))
    held, gains = _thinned(state, held, rejected)
    once = _single(state, state.polished(held))
    held, extra = _paired(state, once)
    if len(extra) or len(gains) != len(state.prices(held.poles)):
        gains, _ = state.worths(held)
    # Sums of squares from the residual itself: by subtraction they carry the rounding of the whole energy.
    fit = reweighed(held.fit, noise, held.squares)
    reasons = list(state.reasons(fit))
    # By chance a pair gains a chi-square of as many degrees of freedom as it has parameters more.
    freedom = 1 + blocks.channels
    excluded = freedom + PAIR_EXCLUDED * np.sqrt(2 * freedom)
    for index, more in enumerate(extra, start=len(fit.poles.pairs)):
        if reasons[index] is None and (more > excluded or gains[index] < REAL_SURE):
            reasons[index] = Reason.REAL_OR_PAIR
    kept = [index for index in np.argsort(-gains) if reasons[index] is None]
    for index in kept[modes:] if modes is not None else []:
        reasons[index] = Reason.BEYOND
    return Selection(
        fit=fit,
        reasons=tuple(reasons),
        gains=gains,
        loudness=held.loudness,
        residual=held.residual,
        rejected=tuple(rejected),
    )


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class _State:
    values: RealArray
    blocks: Blocks
    noise: WhiteNoise
    band: tuple[float, float]

    def fitted(self, start: Poles | DecayFit, *, rough: bool = False) -> _Held | None:
        # Sums of squares by subtraction carry the rounding of the whole energy.
        noise = self.noise.rounded(self.blocks.energy, self.blocks.count, of_energies=True)
        if rough:
            fit = maximize(self.blocks, start, noise, steps=ROUGH_STEPS, negligible=ROUGH**2)
        else:
            fit = maximize(self.blocks, start, noise)
        return None if fit is None else _Held(state=self, fit=fit)

    def polished(self, held: _Held) -> _Held:
        """Return the fit at its best: itself, if it is there already."""
        better = self.fitted(held.fit)
        return held if better is None or better.fit is held.fit else better

    def worths(self, held: _Held, *, refit: bool = True) -> tuple[RealArray, RealArray]:
        """Return what leaving each pole out costs: in twice the log likelihood, and in energy over noise variance.

        At fixed poles the sum of squares grows by ``a^H (G^-1)^-1 a`` with a the amplitudes left out and G^-1
        their block of the inverse Gram matrix. Where that is not much, the others are fitted anew.
        """
        fit, count, pairs = held.fit, self.blocks.count, len(held.poles.pairs)
        inverse = np.linalg.inv(fit.gram)
        # Of conjugate exponents the blocks are [[a, b], [b*, a]], and so are their inverses.
        first = np.arange(pairs)
        a, b = inverse[first, first].real, inverse[first, first + pairs]
        squared, crossed = np.abs(fit.amplitudes[:pairs]) ** 2, fit.amplitudes[:pairs] ** 2
        of_pairs = 2 * (a[:, None] * squared - (b[:, None] * crossed.conj()).real) / (a**2 - np.abs(b) ** 2)[:, None]
        real = np.arange(2 * pairs, 2 * pairs + len(held.poles.reals))
        of_reals = np.abs(fit.amplitudes[real]) ** 2 / inverse[real, real].real[:, None]
        more = np.concatenate([of_pairs, of_reals]) / (count * held.variance)
        energies = count * more.sum(axis=1)
        gains = loss_growth(np.maximum(more, 0.0).T, count)
        if refit:
            for index in np.flatnonzero(gains < 3 * self.prices(held.poles)):
                refitted = self.fitted(held.poles.without(int(index)), rough=True)
                gains[index] = gains[index] if refitted is None else refitted.loss - held.loss
        return gains, energies

    def price(self, *, real: bool) -> float:
        return price(self.blocks.channels, self.blocks.channels * self.blocks.count, real=real)

    def prices(self, poles: Poles) -> RealArray:
        """Return the price of every free pole, (pole,)."""
        return np.array([self.price(real=False)] * len(poles.pairs) + [self.price(real=True)] * len(poles.reals))

    def reasons(self, fit: DecayFit) -> tuple[Reason | None, ...]:
        spread = np.sqrt(np.diag(inverse_information(fit.information)))
        pairs = len(fit.poles.pairs)
        return tuple(self.reason(theta, spread[2 * i], real=False) for i, theta in enumerate(fit.poles.pairs)) + tuple(
            self.reason(complex(theta), spread[2 * pairs + i], real=True) for i, theta in enumerate(fit.poles.reals)
        )

    def reason(self, theta: complex, spread: float, *, real: bool) -> Reason | None:
        count, decay = self.blocks.count, -theta.real
        if decay < -3 * spread:
            return Reason.GROWING
        if decay > BRIEF:
            return Reason.A_FEW_SAMPLES
        if real:
            return Reason.DRIFT if decay * count < 3 else None
        if abs(theta.imag) * count < 2 * np.pi:
            return Reason.UNDER_A_CYCLE
        if decay * count < (1.0 if decay < 3 * spread else TONE_DECAY if decay < TONE_SURE * spread else 0.0):
            return Reason.TONE
        if not self.band[0] <= abs(theta) <= self.band[1] or theta.imag > 0.98 * np.pi:
            return Reason.OUTSIDE_THE_BAND
        return None


@dataclass(frozen=True, kw_only=True, eq=False)
class _Held:
    """A fit and what it leaves of the record, each computed when first asked for."""

    state: _State
    fit: DecayFit

    @property
    def poles(self) -> Poles:
        return self.fit.poles

    @cached_property
    def residual(self) -> RealArray:
        motion = synthesize(self.poles.exponents, self.fit.amplitudes, self.state.blocks.count)
        return np.asarray(self.state.values - motion, float)

    @cached_property
    def squares(self) -> RealArray:
        return np.asarray(np.einsum("ck,ck->c", self.residual, self.residual))

    @cached_property
    def variance(self) -> RealArray:
        """Mean square of the residual, at least the floor, (channel,)."""
        return self.state.noise.variance(self.squares, self.state.blocks.count)

    @cached_property
    def loss(self) -> float:
        return self.state.noise.loss(self.squares, self.state.blocks.count)

    @cached_property
    def splits(self) -> NDArray[np.bool_]:
        """Whether each pole is part of another: too near to it, or near and of the same shape in the channels."""
        every, fit = _every(self.poles), self.fit
        pairs = len(self.poles.pairs)
        rows = np.concatenate([np.arange(pairs), np.arange(2 * pairs, pairs + len(every))]).astype(int)
        shapes = fit.amplitudes[rows] / np.sqrt(fit.squares + 1e-300)
        shapes = shapes / (np.sqrt(np.sum(np.abs(shapes) ** 2, axis=1, keepdims=True)) + 1e-300)
        alike = np.abs(shapes @ shapes.conj().T) ** 2 > ALIKE
        wn = np.log(np.abs(every) + 1e-300)
        alike &= np.abs(wn[:, None] - wn) < np.log(ANOTHER)
        return np.asarray(np.any(_apart(every) < np.where(alike, DISTINCT_ALIKE, DISTINCT), axis=1))

    @property
    def loudness(self) -> RealArray:
        """Power of the residual near each pole over that of the noise; 1 where they agree."""
        return loudness(
            self.residual, self.variance, _every(self.poles), beside=self._power_beside, weights=self._weights
        )

    @cached_property
    def beside(self) -> RealArray:
        """Power of the residual beside each pole, weighted by the pole's own decay, over that of the noise."""
        ratio = over_channels(self._power_beside, self._weights)
        return np.where(ratio > COLOURS_BEGIN, ratio, 1.0)

    @cached_property
    def _power_beside(self) -> RealArray:
        return power_beside(self.residual, self.variance, _every(self.poles))

    @property
    def _weights(self) -> RealArray:
        pairs = len(self.poles.pairs)
        rows = np.concatenate([np.arange(pairs), np.arange(2 * pairs, 2 * pairs + len(self.poles.reals))])
        return np.asarray(np.abs(self.fit.amplitudes[rows]).T ** 2 / self.variance[:, None] + 1e-300)


def _every(poles: Poles) -> ComplexArray:
    """Return the free poles: pairs, then reals."""
    return np.concatenate([poles.pairs, poles.reals])


def _apart(every: ComplexArray) -> RealArray:
    """Return how far poles are from each other, in geometric means of the two decay rates; inf from itself."""
    decay = every.real
    linewidth = np.sqrt(np.maximum(decay[:, None] * decay, 1e-24))
    apart = np.abs(every[:, None] - every) / linewidth
    np.fill_diagonal(apart, np.inf)
    return np.asarray(apart)


def _extended(
    state: _State, held: _Held, found: list[Candidate], rejected: list[tuple[Candidate, Remark]]
) -> _Held | None:
    """Return the fit with one more pole, or None if no candidate is worth its price."""
    together = _together(state, held, found)
    if together is not None:
        return together
    for candidate in found[:TRIES]:
        cost = state.price(real=candidate.real)
        if candidate.gain < HOPELESS * cost:
            break
        theta, poles = candidate.theta, held.poles
        trial = state.fitted(poles.with_real(theta.real) if candidate.real else poles.with_pair(theta), rough=True)
        if trial is None:
            continue
        gain = held.loss - trial.loss
        index = -1 if candidate.real else len(trial.poles.pairs) - 1
        if trial.splits[index]:
            near = float(_apart(_every(trial.poles))[index].min())
            rejected.append((candidate, Remark(Reason.SPLIT, {"linewidths": near})))
            continue
        if gain > cost:
            return trial
        rejected.append((candidate, Remark(Reason.TOO_WEAK, {"gain": gain, "needed": cost})))
    return None


def _together(state: _State, held: _Held, found: list[Candidate]) -> _Held | None:
    """Return the fit with several strong pairs far apart, those that hold their own together; it saves searches."""
    cost = state.price(real=False)
    strong = [c for c in found if not c.real and c.gain > SOUND * cost]
    reach = [APART * (2 * abs(c.theta.real) + 2 * np.pi / state.blocks.count) for c in strong]
    taken = [
        c.theta
        for i, c in enumerate(strong)
        if all(abs(c.theta.imag - strong[j].theta.imag) > max(reach[i], reach[j]) for j in range(i))
    ]
    if len(taken) < 2:
        return None
    trial: _Held | None = held
    while trial is not None and taken:
        poles = held.poles
        for theta in taken:
            poles = poles.with_pair(theta)
        trial = state.fitted(poles, rough=True)
        if trial is None:
            return None
        gains, _ = state.worths(trial, refit=False)
        added = slice(len(held.poles.pairs), len(trial.poles.pairs))
        holds = (gains[added] > STRONG * cost) & ~trial.splits[added]
        if holds.all():
            return trial
        taken = [theta for theta, stays in zip(taken, holds, strict=True) if stays]
    return None


def _thinned(state: _State, held: _Held, rejected: list[tuple[Candidate, Remark]]) -> tuple[_Held, RealArray]:
    """Return the fit without poles that are not worth their price beside the others, and what each pole is worth."""
    while True:
        if not held.poles.free:
            return held, np.zeros(0)
        gains, energy = state.worths(held)
        prices, beside = state.prices(held.poles), held.beside
        loud = np.where(beside > LOUD, beside, 1.0)
        # Beside a residual that is not noise, energy counts, not likelihood; noise of a colour has its power there.
        worth = np.where(loud > 1, np.minimum(energy / (WORTHWHILE * loud), gains), gains / beside) / prices
        # Poles far apart when they were added may have come together since: of two the lesser goes.
        index = int(np.argmin(np.where(held.splits, 0.0, worth) + 1e-9 * worth / np.max(worth)))
        worth[held.splits] = 0.0
        shorter = state.fitted(held.poles.without(index), rough=True) if worth[index] < 1 else None
        if shorter is None:
            return held, gains
        reason = Remark(Reason.SPLIT if held.splits[index] else Reason.NOT_NEEDED)
        if not held.splits[index] and gains[index] >= prices[index]:
            times = energy[index] / (prices[index] * loud[index])
            reason = Remark(Reason.NOT_SIGNIFICANT, {"times": float(times), "needed": WORTHWHILE})
        real = index >= len(held.poles.pairs)
        lost = Candidate(theta=complex(_every(held.poles)[index]), real=real, gain=float(gains[index]))
        rejected.append((lost, reason))
        held = shorter


def _straightened(state: _State, held: _Held, reach: float, rejected: list[tuple[Candidate, Remark]]) -> _Held:
    """Return the fit with poles that creep along the whole record exchanged for a bent line, where that serves."""
    count, every = state.blocks.count, _every(held.poles)
    slow = np.flatnonzero(np.abs(every) * count < reach)
    if not slow.size or len(held.poles.nuisances) > 1:
        return held
    poles = held.poles
    for index in slow[::-1]:
        poles = poles.without(int(index))
    poles = Poles(pairs=poles.pairs, reals=poles.reals, nuisances=BENT / count)
    trial = state.fitted(poles, rough=True)
    if trial is None or trial.loss > held.loss + state.price(real=True):
        return held
    reason = Remark(Reason.BENT)
    lost = [Candidate(theta=complex(every[i]), real=bool(i >= len(held.poles.pairs)), gain=0.0) for i in slow]
    rejected.extend((candidate, reason) for candidate in lost)
    return trial


def _unbent(state: _State, held: _Held) -> _Held:
    """Return the fit with a plain offset where slope and bend are not worth their price."""
    if len(held.poles.nuisances) == 1:
        return held
    trial = state.fitted(Poles(pairs=held.poles.pairs, reals=held.poles.reals, nuisances=np.zeros(1)))
    return trial if trial is not None and trial.loss - held.loss < 2 * state.price(real=True) else held


def _single(state: _State, held: _Held) -> _Held:
    """Return the fit with pairs exchanged for one real pole where the record does not pay for the second."""
    index = 0
    while index < len(held.poles.pairs):
        theta = held.poles.pairs[index]
        if abs(theta.imag) < -theta.real:
            trial = state.fitted(held.poles.without(index).with_real(theta.real))
            saved = state.price(real=False) - state.price(real=True)
            if trial is not None and trial.loss - held.loss < saved:
                held, index = trial, 0
                continue
        index += 1
    return held


def _paired(state: _State, held: _Held) -> tuple[_Held, RealArray]:
    """Return the fit with real poles exchanged for pairs where those fit clearly better; what pairs would gain else."""
    enough = PAIR_GAIN * (1 + state.blocks.channels)
    index, extra = 0, list[float]()
    while index < len(held.poles.reals):
        theta = held.poles.reals[index]
        pair = held.poles.without(len(held.poles.pairs) + index).with_pair(theta + 0.7j * abs(theta))
        trial = state.fitted(pair)
        more = -np.inf if trial is None else held.loss - trial.loss
        if trial is not None and more > enough:
            held, index, extra = trial, 0, []
            continue
        extra.append(more)
        index += 1
    return held, np.array(extra)


def candidates(fit: DecayFit, residual: RealArray, variance: RealArray) -> list[Candidate]:
    """Return poles in order of what they gain beyond their price, no two within a linewidth of each other.

    Parameters
    ----------
    fit : DecayFit
        What is fitted already; gains are those orthogonal to it.
    residual : ndarray (channel, sample)
        What it leaves.
    variance : ndarray (channel,)
        Mean square of the residual.
    """
    return _ranked(fit, variance, _searched(fit, residual, variance))


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class _Points:
    """Exponents worth a look, (point,), the first few real; and inner products with the record, (channel, point)."""

    theta: ComplexArray
    inner: ComplexArray
    reals: int
    count: int


def _searched(fit: DecayFit, residual: RealArray, variance: RealArray) -> _Points:
    """Return where the residual of a fit is worth a look."""
    count, known = residual.shape[1], fit.poles.exponents
    noise = np.sqrt(variance)[:, None]
    # Where to look needs no more than single precision, of a residual in units of its own size.
    theta, inner = _worth_a_look((residual / noise).astype(np.float32), known[known.imag >= 0])
    explained = fit.amplitudes.T @ cross_sums(known.conj(), theta, count).conj()
    return _Points(theta=theta, inner=inner * noise + explained, reals=len(_layout(count)), count=count)


def _ranked(fit: DecayFit, variance: RealArray, points: _Points) -> list[Candidate]:
    """Return what the points gain beside a fit, see `candidates`."""
    theta, count, reals, channels = points.theta, points.count, points.reals, len(variance)
    cross = cross_sums(fit.poles.exponents.conj(), theta, count)
    solved = np.linalg.inv(fit.gram) @ cross
    inner = points.inner - fit.amplitudes.T @ cross.conj()
    share = np.empty((channels, len(theta)))
    share[:, :reals] = _real_gain(theta[:reals], inner[:, :reals], cross[:, :reals], solved[:, :reals], count)
    share[:, reals:] = _pair_gain(
        fit.poles, theta[reals:], inner[:, reals:], cross[:, reals:], solved[:, reals:], count
    )
    share /= variance[:, None] * count
    gains = -loss_growth(-np.minimum(np.maximum(share, 0.0), 1 - 1e-12), count)
    samples = channels * count
    is_real = np.arange(len(theta)) < reals
    net = gains - np.where(is_real, price(channels, samples, real=True), price(channels, samples))
    reach = 2 * np.abs(theta.real) + 2 * np.pi / count
    distinct: list[Candidate] = []
    for _ in range(MOST_CANDIDATES):
        best = int(net.argmax())
        if net[best] == -np.inf or (net[best] < 0 and len(distinct) >= TRIES):
            break
        distinct.append(Candidate(theta=complex(theta[best]), real=best < reals, gain=float(gains[best])))
        near = np.abs(theta.imag - theta[best].imag) <= np.maximum(reach, reach[best])
        net[near & (is_real == is_real[best])] = -np.inf
    return distinct


@lru_cache(maxsize=64)
def _layout(count: int) -> tuple[tuple[float, int, int, float], ...]:
    """Return decay rate, samples in use, length of the transform and squared norm, for every plane."""
    from scipy.fft import next_fast_len

    layout = []
    for decay in np.geomspace(1.0 / count, 1.0, 1 + int(np.ceil(np.log(count) / np.log(DECAY_FACTOR)))).tolist():
        used = min(count, int(np.ceil(GONE / decay)))
        length = next_fast_len(used if decay * count > WIDE else 2 * used, real=True)
        layout.append((decay, used, length, float(np.expm1(-2 * decay * used) / np.expm1(-2 * decay))))
    return tuple(layout)


def _worth_a_look(scaled: NDArray[np.float32], known: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Return exponents, (point,), and a residual's inner products with them, (channel, point).

    The first are real, one of each decay rate. The others are the largest of the local maxima along the
    frequencies at each decay rate, and points beside what is known already.
    """
    from scipy.fft import rfft

    count = scaled.shape[1]
    layout = _layout(count)
    decay, per_bin = np.array([p[0] for p in layout]), 2 * np.pi / np.array([p[2] for p in layout])
    reach = 4 * np.maximum(np.maximum(decay[:, None], -known.real), np.pi / count)
    low = np.maximum(np.ceil((known.imag - reach) / per_bin[:, None]), 1).astype(int)
    high = np.minimum((known.imag + reach) / per_bin[:, None], np.pi / per_bin[:, None] - 1).astype(int)
    fast = np.maximum(-known.real, 1 / count)
    alike = (known.imag == 0) | ((decay[:, None] >= fast / NARROWER) & (decay[:, None] <= fast * WIDER))
    between = low[..., None] + (high - low)[..., None] * BETWEEN // BETWEEN[-1]
    theta, heights = [-decay + 0j], [np.full(len(layout), np.inf)]
    inner: list[ComplexArray] = [np.empty((len(scaled), len(layout)), complex)]
    for k, (rate, used, length, norm) in enumerate(layout):
        spectrum = rfft(scaled[:, :used] * _decay(rate, used), n=length, axis=1)
        gain = (spectrum.real**2 + spectrum.imag**2).sum(axis=0)
        peaks = np.flatnonzero((gain[1:-1] >= gain[:-2]) & (gain[1:-1] >= gain[2:])) + 1
        if len(peaks) > LOCAL_MAXIMA:
            peaks = peaks[np.argpartition(gain[peaks], -LOCAL_MAXIMA)[-LOCAL_MAXIMA:]]
        beside = between[k][alike[k] & (high[k] >= low[k])].ravel()
        bins = np.concatenate([peaks, beside])
        inner[0][:, k] = spectrum[:, 0]
        inner.append(spectrum[:, bins])
        theta.append(-rate + 1j * per_bin[k] * bins)
        heights.append(np.concatenate([gain[peaks] / norm, np.full(len(beside), np.inf)]))
    height = np.concatenate(heights)
    ranked = np.sort(height[height < np.inf])[-LOCAL_MAXIMA:]
    keep = np.flatnonzero(height >= (ranked[0] if len(ranked) else 0.0))
    return np.concatenate(theta)[keep], np.concatenate(inner, axis=1)[:, keep]


def _decay(rate: float, count: int) -> NDArray[np.float32]:
    """Return ``exp(-rate k)``; kept from one pole to the next while the record is not long."""
    return _short_decay(rate, count) if count <= 2**16 else np.exp(-rate * np.arange(count)).astype(np.float32)


@lru_cache(maxsize=32)
def _short_decay(rate: float, count: int) -> NDArray[np.float32]:
    decay: NDArray[np.float32] = np.exp(-rate * np.arange(count)).astype(np.float32)
    return decay


def _pair_gain(
    poles: Poles, theta: ComplexArray, inner: ComplexArray, cross: ComplexArray, solved: ComplexArray, count: int
) -> RealArray:
    """Return the square of the residual's part along ``exp(theta k)`` and its conjugate, (channel, point)."""
    own, own_conjugate = _own(np.asarray(2 * theta.real, complex), count).real, _own(2 * theta.conj(), count)
    s0 = own - _product(cross, solved).real
    s1 = own_conjugate - _product(cross, solved[_twins(len(poles.pairs), len(poles))].conj())
    determinant = s0**2 - np.abs(s1) ** 2
    sound = (s0 > 1e-6 * own) & (determinant > 1e-6 * s0**2)
    gain = 2 * (s0 * (inner.real**2 + inner.imag**2) - (inner.conj() ** 2 * s1).real)
    return np.where(sound, gain / np.where(sound, determinant, 1.0), 0.0)


def _real_gain(
    theta: ComplexArray, inner: ComplexArray, cross: ComplexArray, solved: ComplexArray, count: int
) -> RealArray:
    """Return the square of the residual's part along ``exp(theta k)``, theta real, (channel, point)."""
    own = _own(2 * theta, count).real
    left = own - _product(cross, solved).real
    sound = left > 1e-6 * own
    return np.where(sound, inner.real**2 / np.where(sound, left, 1.0), 0.0)


def _own(phi: ComplexArray, count: int) -> ComplexArray:
    """Return ``sum_k exp(phi k)``, none of them near 0."""
    return np.asarray(np.expm1(count * phi) / np.expm1(phi))


def _product(left: ComplexArray, right: ComplexArray) -> ComplexArray:
    return np.asarray(np.einsum("ip,ip->p", left.conj(), right))


@lru_cache(maxsize=256)
def _twins(pairs: int, exponents: int) -> NDArray[np.intp]:
    """Return where the conjugate of each exponent stands: what is fitted comes in conjugate pairs."""
    return np.concatenate([np.arange(pairs) + pairs, np.arange(pairs), np.arange(2 * pairs, exponents)])
