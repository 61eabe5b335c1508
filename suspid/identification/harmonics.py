"""Name poles at multiples, sums and differences of strong modes: motion that is not quite linear."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from suspid.identification.likelihood import DecayFit
from suspid.identification.selection import Selection
from suspid.levels import SURE
from suspid.model import ModalSet
from suspid.words import Reason

# A harmonic has at most this share of the amplitude of its mode, and is at most the seventh: beyond that one lies near
# every frequency, unless that is known so well that chance hits one as rarely as the third number says, beside another
# harmonic.
WEAK, HIGHEST, BY_CHANCE = 0.2, 7, 0.05
# Up to the first share it is a harmonic too, of at most the second number's order, where its frequency is known so well
# that another mode lies as near to the multiple as rarely as the third number says: sensors that bend make such. A
# larger share would turn back what they show.
HALF_AS_LARGE, LOW_ORDER, AS_RARELY = 0.5, 3, 0.02
# A frequency is known to be a multiple of another if its standard deviation is below this share of it: a higher one
# takes weak modes for harmonics by chance.
PRECISE = 0.01
# What moves as the square of a swing is in step with it, to within this angle [rad], where it is the most of its
# channel. Then it is enough if its frequency, and its rate, are known to these shares, and twice those of the swing to
# the last two beyond chance. A structure that is let go is in step as well: one in some hundred has a mode there.
IN_STEP, KNOWN_IN_STEP, RATE_IN_STEP, OF_ARC = 0.3, 0.005, 0.3, (0.001, 0.1)
# Where one is, a real pole is the middle of it if its rate is known to this share.
MIDDLE_KNOWN = 0.5
# A real pole is the middle of a swing that moves with its size if the standard deviation of its rate is below this
# share of it: a higher one takes other real poles for it by chance.
PRECISE_RATE = 0.2


def without_harmonics(selection: Selection, modes: ModalSet) -> Selection:
    """Return the poles of a record, of which those at multiples of a stronger mode are no modes but stay in the fit.

    A bilinear damper or a sensor that bends adds motion at twice the frequency of a mode, and moves the middle of its
    swings. Both decay as another mode would, at once to twice the rate. An energy, the square of a motion, is nothing
    but these two, whatever its size.
    """
    order = selection.modes_by_wn
    if len(order) < 2 or modes.covariance is None:
        return selection
    strengths = selection.fit.strengths[order]
    reasons = list(selection.reasons)
    for k, number in enumerate(order.tolist()):
        others = [j for j in range(len(order)) if j != k and reasons[order[j]] is None]
        if any(
            _is_square(modes, j, k)
            or _in_step(selection.fit, modes, order, j, k)
            or (strengths[k] < WEAK**2 * strengths[j] and _is_multiple(modes, j, k))
            or (strengths[k] < HALF_AS_LARGE**2 * strengths[j] and _is_near_multiple(modes, j, k))
            for j in others
        ):
            reasons[number] = Reason.HARMONIC
    if Reason.HARMONIC in reasons:
        # Without a harmonic, far multiples, sums and differences of many modes lie near others by chance.
        for k, number in enumerate(order.tolist()):
            left = [j for j in range(len(order)) if j != k and reasons[order[j]] is None]
            stronger = [j for j in left if strengths[k] < WEAK**2 * strengths[j]]
            if reasons[number] is not None:
                continue
            if any(_is_multiple(modes, j, k, far=True) for j in stronger) or any(_is_middle(modes, j, k) for j in left):
                reasons[number] = Reason.HARMONIC
            elif any(_is_combination(modes, one, other, k) for one, other in itertools.permutations(stronger, 2)):
                reasons[number] = Reason.COMBINATION
    return replace(selection, reasons=tuple(reasons)) if tuple(reasons) != selection.reasons else selection


def multiple_of(modes: ModalSet, pole: complex) -> tuple[int, int]:
    """Return the number of the mode, from 1, of which a pole is nearest to a multiple, and the multiple.

    A real pole is 0 times a mode.
    """
    if not pole.imag:
        rates = np.where(modes.poles.imag > 0, np.abs(modes.poles.real) + 1e-300, 1e300)
        return int(np.argmin(np.abs(np.log(rates / abs(pole))))) + 1, 0
    ratios = np.abs(pole.imag) / np.maximum(np.abs(modes.poles.imag), 1e-300)
    multiples = np.round(ratios)
    strays = np.where((multiples > 1) & (multiples <= HIGHEST), np.abs(ratios / np.maximum(multiples, 1) - 1), np.inf)
    if np.min(strays) > SURE * PRECISE:
        strays = np.where(multiples > HIGHEST, np.abs(ratios - multiples), strays)
    mode = int(np.argmin(strays))
    return mode + 1, int(multiples[mode])


def combination_of(modes: ModalSet, pole: complex) -> tuple[int, int, str]:
    """Return the numbers of the modes, from 1, whose "sum" or "difference" a pole is nearest to, and which of both."""
    wd = np.abs(modes.poles.imag)
    pairs = [(i, j, word) for i, j in itertools.combinations(range(len(wd)), 2) for word in ("sum", "difference")]
    strays = [abs(pole.imag - (wd[i] + wd[j] if word == "sum" else abs(wd[i] - wd[j]))) for i, j, word in pairs]
    one, other, word = pairs[int(np.argmin(strays))]
    return one + 1, other + 1, word


def _is_combination(modes: ModalSet, one: int, other: int, third: int) -> bool:
    """Return whether a third mode turns at the sum of two, or the second less the first, and decays as such a motion.

    A bilinear damper makes motion that decays as one of both, a spring that bends as their product.
    """
    wd, rates = modes.poles.imag, -modes.poles.real
    if not (wd[one] > 0 and wd[other] > 0):
        return False
    for sign in (1.0, -1.0):
        off = _combined_std(modes, {third: 1.0, other: -1.0, one: -sign}, 1)
        stray = wd[third] - wd[other] - sign * wd[one]
        if not (off < PRECISE * wd[third] and abs(stray) < SURE * off):
            continue
        slow = SURE * _combined_std(modes, {third: 1.0}, 0)
        if min(rates[one], rates[other]) - slow <= rates[third] <= rates[one] + rates[other] + slow:
            return True
    return False


def _is_square(modes: ModalSet, one: int, other: int) -> bool:
    """Return whether the other mode is in the square of one: twice its pole, or twice its rate without turning."""
    first, second = complex(modes.poles[one]), complex(modes.poles[other])
    if not first.imag > 0:
        return False
    turning, rate = _std(modes, one, other, 1, 2), _std(modes, one, other, 0, 2)
    # An undamped mode is at twice the frequency of another by chance.
    if not rate < PRECISE * -second.real or abs(second.real - 2 * first.real) > SURE * rate:
        return False
    return not second.imag or (turning < PRECISE * second.imag and abs(second.imag - 2 * first.imag) < SURE * turning)


def _in_step(fit: DecayFit, modes: ModalSet, order: NDArray[np.intp], one: int, other: int) -> bool:
    """Return whether the other mode is twice the pole of one, as far as is known, in step with its square elsewhere.

    A pendulum moves up and down twice in a cycle, and the pull along its rod does: cameras and accelerometers see that.
    """
    first, second = complex(modes.poles[one]), complex(modes.poles[other])
    if not (first.imag > 0 and second.imag > 0):
        return False
    turning, rate = _std(modes, one, other, 1, 2), _std(modes, one, other, 0, 2)
    if not (turning < KNOWN_IN_STEP * second.imag and rate < RATE_IN_STEP * -second.real):
        return False
    # Large swings move along an arc, not along a parabola.
    near = abs(second.imag - 2 * first.imag) < SURE * turning + OF_ARC[0] * second.imag
    if not near or abs(second.real - 2 * first.real) > SURE * rate + OF_ARC[1] * -second.real:
        return False
    sizes = fit.amplitudes[order[[one, other]]] / np.sqrt(fit.squares + 1e-300)
    most = np.argmax(np.abs(sizes), axis=1)
    turned = np.angle(sizes[1, most[1]] * np.conj(sizes[0, most[0]]) ** 2)
    return bool(most[0] != most[1] and abs(np.sin(turned)) < np.sin(IN_STEP))


def _is_middle(modes: ModalSet, one: int, other: int) -> bool:
    """Return whether the other mode is the middle of the square of one: real, at twice its rate as far as is known."""
    first, second = complex(modes.poles[one]), complex(modes.poles[other])
    rate = _std(modes, one, other, 0, 2)
    near = abs(second.real - 2 * first.real) < SURE * rate + OF_ARC[1] * -second.real
    return first.imag > 0 and second.imag == 0 and rate < MIDDLE_KNOWN * -second.real and near


def _std(modes: ModalSet, one: int, other: int, part: int, factor: int) -> float:
    """Return the standard deviation of the other mode's part, 0 real or 1 imaginary, less a multiple of that of one."""
    return _combined_std(modes, {one: -factor, other: 1.0}, part)


def _combined_std(modes: ModalSet, factors: Mapping[int, float], part: int) -> float:
    """Return the standard deviation of a weighted sum of parts, 0 real or 1 imaginary, of modes by their numbers."""
    covariance = modes.covariance
    assert covariance is not None
    row = np.zeros(len(covariance))
    for mode, factor in factors.items():
        row[2 * mode + part] = factor
    return float(np.sqrt(row @ covariance @ row))


def _is_near_multiple(modes: ModalSet, one: int, other: int) -> bool:
    """Return whether the other mode is so near to a low multiple of one that chance is no explanation."""
    first, second = modes.poles[one].imag, modes.poles[other].imag
    multiple = round(second / first) if first > 0 else 1
    if not 2 <= multiple <= LOW_ORDER or 2 * SURE * _std(modes, one, other, 1, multiple) > AS_RARELY * first:
        return False
    return _is_multiple(modes, one, other)


def _is_multiple(modes: ModalSet, one: int, other: int, *, far: bool = False) -> bool:
    """Return whether the other mode turns at a multiple of one and decays between once and that multiple as fast.

    Multiples beyond `HIGHEST` count with ``far``.
    """
    first, second = complex(modes.poles[one]), complex(modes.poles[other])
    multiple = round(second.imag / first.imag) if first.imag > 0 else 1
    if multiple == 1 or (multiple > HIGHEST and not far):
        return False
    off = _std(modes, one, other, 1, multiple)
    if multiple > HIGHEST and 2 * SURE * off > BY_CHANCE * first.imag:
        return False
    if multiple:
        known = off < PRECISE * second.imag and abs(second.imag - multiple * first.imag) < SURE * off
    else:
        known = second.imag == 0 and _std(modes, one, other, 0, 1) < PRECISE_RATE * -second.real
    if not known:
        return False
    fastest = max(multiple, 2)
    slow, fast = -first.real - SURE * _std(modes, one, other, 0, 1), -fastest * first.real
    return slow <= -second.real <= fast + SURE * _std(modes, one, other, 0, fastest)
