"""Several decays of one structure, identified one by one and jointly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from suspid.errors import IdentificationError, InputError, RecordError
from suspid.identification.exponentials import Blocks, blocks_of
from suspid.identification.halves import FEWEST_SAMPLES
from suspid.identification.identify import Identification, identify
from suspid.identification.likelihood import DecayFit, Poles, evaluate, maximize
from suspid.identification.noise import WhiteNoise, degrees_of_freedom, noise_of
from suspid.identification.selection import Selection, select
from suspid.identification.shared import Shared, shared_covariance
from suspid.model import ModalSet
from suspid.signals import Stretch, as_signal, cut
from suspid.units import RadianPerSecond, RealArray, Second
from suspid.values import frozen_real, text_table

if TYPE_CHECKING:
    import control

# Poles are sought in the repeats at least this long, relative to the median, side by side over their common length.
LONG_ENOUGH = 0.5
MOST_STEPS, NEGLIGIBLE = 40, 1e-7
# Repeats disagree where chance alone would leave them as far apart less often than this.
DISAGREE = 0.01


@dataclass(frozen=True, kw_only=True, slots=True)
class Agreement:
    """How well the repeats agree on one mode.

    Parameters
    ----------
    chi_square : float
        Sum over the repeats of the squared distance of their poles from the mean weighted by their information, in
        the metric of their own covariances [1].
    freedom : int
        Degrees of freedom: two less than two for each repeat that holds the mode.
    probability : float
        Of a chi-square as large by chance [1]; NaN if fewer than two repeats hold the mode.
    widening : float
        Factor by which the variances of the mode were widened for it [1]: chi-square over degrees of freedom where
        the probability is below 1 %, else 1.
    """

    chi_square: float
    freedom: int
    probability: float
    widening: float


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Repeats:
    """What `identify_repeats` found.

    Parameters
    ----------
    spans : tuple of (float, float)
        First and last time of each decay [s].
    each : tuple of Identification
        Each decay by itself.
    modes : ModalSet
        The modes of all decays jointly, with the joint covariance of poles and shapes.
    consistency : tuple of Agreement
        For each mode, whether the repeats agree on it.
    loudness : ndarray (mode,)
        Power of the residual near each mode over that of the noise, see `Identification.loudness`.
    noise_std : ndarray (repeat, channel)
        Standard deviation of the noise in each repeat and channel, in the unit of the channel.
    """

    spans: tuple[tuple[Second, Second], ...]
    each: tuple[Identification, ...]
    modes: ModalSet
    consistency: tuple[Agreement, ...]
    loudness: RealArray
    noise_std: RealArray

    def __str__(self) -> str:
        if not len(self.modes):
            return f"no mode: nothing decays like one in all of {len(self.spans)} repeats"
        columns = {
            "mode": [str(i + 1) for i in range(len(self.modes))],
            "repeats apart: chi-square": [f"{a.chi_square:.1f}" for a in self.consistency],
            "degrees of freedom": [str(a.freedom) for a in self.consistency],
            "by chance": [f"{a.probability:.2g}" for a in self.consistency],
            "residual beside / noise": [f"{value:.3g}" for value in self.loudness],
        }
        singles = {
            "decay": [f"{start:.6g} … {stop:.6g} s" for start, stop in self.spans],
            "f [Hz]": [", ".join(f"{wn / (2 * np.pi):.4g}" for wn in found.modes.wn) for found in self.each],
            "zeta [1]": [", ".join(f"{zeta:.3g}" for zeta in found.modes.zeta) for found in self.each],
        }
        parts = [f"{self.modes}", text_table(columns)]
        apart = [str(i + 1) for i, a in enumerate(self.consistency) if a.widening > 1]
        if apart:
            parts.append(
                f"The repeats disagree on mode {', '.join(apart)} by more than their noise: frequency or damping "
                f"depends on the amplitude, or something changed between them; the intervals are widened for it."
            )
        if np.any(self.loudness > 1):
            parts.append("Where the residual is louder than white noise the intervals are widened for it.")
        return "\n\n".join([*parts, text_table(singles)])


def identify_repeats(
    response: control.TimeResponseData,
    decays: Sequence[Stretch | tuple[Second, Second]],
    *,
    modes: int | None = None,
    band: tuple[RadianPerSecond, RadianPerSecond] | None = None,
) -> Repeats:
    """Return the modes that several decays share.

    The poles are common to all decays; amplitudes and an offset are free in each decay and channel, and so is the
    level of the noise. Which poles there are is found over the length that the decays have in common (those shorter
    than half the median stay out of that); then the joint likelihood of all decays, each over its whole length, is
    maximised. The shapes of the decays are combined by generalised least squares with the covariance of their
    amplitudes, so that one shape per mode remains.

    Parameters
    ----------
    response : control.TimeResponseData
        The recording.
    decays : sequence of Decay or (float, float)
        The stretches of free decay, or their first and last times [s].
    modes : int, optional
        How many modes: the strongest. Default: all that the decays support.
    band : (float, float), optional
        Angular frequencies between which to look [rad/s].

    Returns
    -------
    Repeats
        Each decay by itself, all jointly, and whether they agree.

    Raises
    ------
    IdentificationError
        If fewer modes than asked for stand out; ``.found`` holds those found.
    RecordError, InputError
        If a stretch, the record or a setting cannot be used.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import free_decay, quarter_car
    >>> from suspid.signals import as_response
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> decay = free_decay(car, np.arange(400) / 100, initial_state={"v_tire": 1.0}).y
    >>> noise = 1e-5 * np.random.default_rng(1).standard_normal((2, 800))
    >>> record = as_response(np.arange(800) / 100, np.hstack([decay, 0.5 * decay]) + noise, ["chassis", "tire"])
    >>> found = identify_repeats(record, [(0, 3.99), (4, 7.99)])
    >>> (found.modes.wn / (2 * np.pi)).round(2)
    array([ 1.08, 11.68])
    """
    spans = tuple((d.start, d.stop) if not isinstance(d, tuple) else (float(d[0]), float(d[1])) for d in decays)
    if not spans:
        raise InputError("no decay is given; give at least one, as from find_decays, or (start, stop) in seconds")
    if modes is not None and modes < 1:
        raise InputError(f"{modes=}: ask for at least one mode, or leave it out to find out")
    each = tuple(_identified(response, start, stop, band) for start, stop in spans)
    signals = [as_signal(found.response, least=FEWEST_SAMPLES) for found in each]
    step, channels = signals[0].step, signals[0].channels
    values = [s.values - s.values.mean(axis=1, keepdims=True) for s in signals]
    noises = [noise_of(s.values) for s in signals]
    low, high = band or (0.0, np.pi / step)
    lengths = np.array([v.shape[1] for v in values])
    stacked = np.flatnonzero(lengths >= LONG_ENOUGH * np.median(lengths))
    common = int(np.min(lengths[stacked]))
    beside = np.vstack([signals[r].values[:, :common] for r in stacked])
    selection = select(
        beside - beside.mean(axis=1, keepdims=True),
        noise=WhiteNoise(least=np.concatenate([noises[r].least for r in stacked])),
        modes=modes,
        band=(low * step, high * step),
    )
    blocks = [blocks_of(v) for v in values]
    noises = [noise.rounded(b.energy, b.count, of_energies=True) for noise, b in zip(noises, blocks, strict=True)]
    fits = _jointly(blocks, _scaled(selection.fit.poles, common, lengths), noises)
    pairs, reals = _wanted(selection)
    if not len(pairs) + len(reals):
        found, agreement, loudness = _none(channels), (), np.zeros(0)
    else:
        kept = np.concatenate([pairs, len(selection.fit.poles.pairs) + reals])
        agreements = [_agreement(blocks, fits, noises, int(index)) for index in kept]
        loud = selection.loudness[kept]
        shared = shared_covariance(
            fits, blocks, pairs, reals, np.maximum(loud, [agreement.widening for agreement in agreements])
        )
        found = _modes(shared, step, channels)
        order = np.argsort(np.abs(shared.exponents), kind="stable")
        agreement, loudness = tuple(agreements[k] for k in order), loud[order]
    if modes is not None and len(found) < modes:
        raise IdentificationError(
            f"{modes} modes were asked for, {len(found)} could be found in {len(spans)} repeats",
            found=found if len(found) else None,
        )
    return Repeats(
        spans=spans,
        each=each,
        modes=found,
        consistency=agreement,
        loudness=frozen_real(loudness),
        noise_std=frozen_real([np.sqrt(fit.squares / _free(fit, b)) for fit, b in zip(fits, blocks, strict=True)]),
    )


def _identified(
    response: control.TimeResponseData,
    start: Second,
    stop: Second,
    band: tuple[RadianPerSecond, RadianPerSecond] | None,
) -> Identification:
    try:
        return identify(cut(response, start=start, stop=stop), band=band)
    except RecordError as error:
        raise RecordError(f"the decay {start:g} … {stop:g} s cannot be used: {error}") from error
    except IdentificationError as error:
        raise IdentificationError(f"the decay {start:g} … {stop:g} s: {error}", found=error.found) from error


def _wanted(selection: Selection) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    kept = np.flatnonzero([reason is None for reason in selection.reasons])
    count = len(selection.fit.poles.pairs)
    return kept[kept < count], kept[kept >= count] - count


def _none(channels: tuple[str, ...]) -> ModalSet:
    return ModalSet(poles=np.zeros(0, complex), shapes=np.zeros((len(channels), 0), complex), channels=channels)


def _modes(shared: Shared, step: Second, channels: tuple[str, ...]) -> ModalSet:
    per_second = np.ones(len(shared.covariance))
    per_second[: 2 * len(shared.exponents)] = 1 / step
    return ModalSet(
        poles=shared.exponents / step,
        shapes=shared.shapes,
        channels=channels,
        covariance=shared.covariance * np.outer(per_second, per_second),
    )


def _free(fit: DecayFit, blocks: Blocks) -> float:
    return degrees_of_freedom(blocks.count, amplitudes=len(fit.poles), poles=fit.poles.free, channels=blocks.channels)


def _scaled(poles: Poles, common: int, lengths: NDArray[np.intp]) -> list[Poles]:
    """Return the poles for each repeat: a drift is as slow as the repeat is long."""
    return [
        Poles(pairs=poles.pairs, reals=poles.reals, nuisances=poles.nuisances * (common / length)) for length in lengths
    ]


def _jointly(blocks: list[Blocks], start: list[Poles], noises: list[WhiteNoise]) -> list[DecayFit]:
    """Return the fits of all repeats with the poles of greatest joint likelihood, by Gauss-Newton steps."""

    def at(poles: list[Poles]) -> tuple[list[DecayFit], float] | None:
        fits = [evaluate(b, p, noise) for b, p, noise in zip(blocks, poles, noises, strict=True)]
        known = [fit for fit in fits if fit is not None]
        if len(known) < len(fits):
            return None
        loss = sum(noise.loss(fit.squares, b.count) for fit, b, noise in zip(known, blocks, noises, strict=True))
        return known, loss

    found = at(start)
    if found is None:
        raise IdentificationError("the repeats are too short to tell their poles apart; leave the shortest out")
    fits, loss = found
    for _ in range(MOST_STEPS if fits[0].poles.free else 0):
        information = np.sum([fit.information for fit in fits], axis=0)
        gradient = np.sum([fit.gradient for fit in fits], axis=0)
        scale = 1 / np.sqrt(np.maximum(information.diagonal(), 1e-300))
        step = scale * np.linalg.lstsq(information * np.outer(scale, scale), scale * gradient, rcond=1e-12)[0]
        if float(step @ gradient) < NEGLIGIBLE:
            break
        for halving in range(12):
            trial = at([fit.poles.moved(step * 0.5**halving) for fit in fits])
            if trial is not None and trial[1] <= loss + 1e-13 * sum(b.count for b in blocks):
                break
        else:
            break
        fits, loss = trial
    return fits


def _agreement(blocks: list[Blocks], fits: list[DecayFit], noises: list[WhiteNoise], index: int) -> Agreement:
    """Return how well the repeats agree on a pole, each fitted alone with the same number of poles."""
    from scipy.special import chdtrc

    pairs = len(fits[0].poles.pairs)
    rows = [2 * index, 2 * index + 1] if index < pairs else [pairs + index]
    found, informations = [], []
    for block, joint, noise in zip(blocks, fits, noises, strict=True):
        own = maximize(block, joint, noise, steps=20)
        if own is None:
            continue
        try:
            covariance = np.linalg.inv(own.information)[np.ix_(rows, rows)] * (block.count / _free(own, block))
            information = np.linalg.inv(covariance)
        except np.linalg.LinAlgError:
            continue
        before, after = (
            fit.poles.pairs[index] if index < pairs else fit.poles.reals[index - pairs] for fit in (joint, own)
        )
        decay = abs(complex(before).real)
        # A repeat that does not know the decay rate to a third, or leads elsewhere, does not hold the mode.
        if abs(after - before) < decay and np.all(
            (covariance.diagonal() > 0) & (covariance.diagonal() < (decay / 3) ** 2)
        ):
            found.append(np.array([complex(after).real, complex(after).imag])[: len(rows)])
            informations.append(information)
    if len(found) < 2:
        return Agreement(chi_square=0.0, freedom=0, probability=float("nan"), widening=1.0)
    mean = np.linalg.solve(
        np.sum(informations, axis=0), np.sum([i @ p for i, p in zip(informations, found, strict=True)], axis=0)
    )
    chi_square = float(sum((p - mean) @ i @ (p - mean) for i, p in zip(informations, found, strict=True)))
    freedom = len(rows) * (len(found) - 1)
    probability = float(chdtrc(freedom, chi_square))
    return Agreement(
        chi_square=chi_square,
        freedom=freedom,
        probability=probability,
        widening=chi_square / freedom if probability < DISAGREE else 1.0,
    )
