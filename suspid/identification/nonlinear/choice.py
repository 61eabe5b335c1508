"""Choice of the structure that explains a record: its nonlinear forces and number of modes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from suspid.identification.noise import WhiteNoise
from suspid.identification.nonlinear.beginnings import FIRST, begun, stops_soon
from suspid.identification.nonlinear.descent import fitted
from suspid.identification.nonlinear.driven import DrivenFit
from suspid.identification.nonlinear.feedback import Bent, Record, added
from suspid.identification.nonlinear.forces import ForceKind
from suspid.identification.nonlinear.motion import Structures, steps_of
from suspid.identification.nonlinear.own import next_poles, repeated
from suspid.identification.nonlinear.rubbing import NOT_RULED_OUT, by_equations
from suspid.identification.nonlinear.standing import explains, leaves_more, stands, worths_of
from suspid.identification.nonlinear.starts import beside_single, starts_of, strongest
from suspid.identification.nonlinear.structure import StructureFit
from suspid.units import ComplexArray

# One more mode beside forces must lower the residual of a channel by this factor, unless it leaves only noise: a force
# that is not quite the true one leaves a residual that further poles follow. Lower: distortions become modes. Higher:
# weak modes are lost.
REDUCTION = 2.5
# Steps of the motion up to which structures are fitted, with friction, with friction where no force was found, and
# channels: more take too long.
LONGEST_FITTED, LONGEST_RUBBED, LONGEST_BLIND, MOST_MASSES = 4000, 3000, 1500, 3
# Loss per sample by which a structure may still be above what it must reach, after the first steps.
WITHIN_REACH = 0.5
# Where no force was found, a kind of force is fitted only if the loss expected of it is at most this much above the
# present one, per sample: a fit rarely gains more, and each takes seconds.
PROMISED_REACH = 1.0
# Kinds of force among those found that are tried, and those that are tried in any case. More cost time.
KINDS_TRIED, COMMON = 2, (ForceKind.FRICTION, ForceKind.BENT_DAMPER, ForceKind.CUBIC)


# Steps that lead nowhere may overflow; what is not finite is refused.
@np.errstate(over="ignore", invalid="ignore")
def chosen(
    record: Record, plain: DrivenFit, bent: Bent | None, *, most: int, highest: float, followed: bool, rubs: bool
) -> StructureFit | None:
    """Return the structure of least BIC near a linear fit or one with forces.

    None if its BIC is not below the highest, or if a mode of it does not stand. A motion that linear modes have not
    ``followed`` has one with friction from the equations of motion, if that leaves only noise. Where nothing ``rubs``
    and no force was found, none has friction.

    Forces of one kind act at every channel and between every two; those that are not worth their gains are left out.
    Modes are added, up to ``most``, as long as each explains most of the residual.
    """
    # Of a single mode that explains the record best, other forces than friction follow its motion as it was measured.
    if bent is not None and bent.count == 1 and bent.bic <= highest and not _sticks(bent, record.noise):
        return None
    strong = strongest(record, plain)
    rubbed = LONGEST_RUBBED if bent is not None else LONGEST_BLIND
    rubs = rubs or bent is not None
    rub = by_equations(record, strong, most=most, highest=highest, longest=rubbed, followed=followed) if rubs else []
    best = rub[0] if rub else None
    if not followed and (best is None or not explains(best, highest)):
        return None
    for start in starts_of(record, strong, bent) if followed else ():
        if _too_long(start.drive.theta, record.values.shape[1]):
            continue
        for order, kind in _kinds(record, start, bent, highest):
            longest = rubbed if kind is ForceKind.FRICTION else LONGEST_FITTED
            if kind is ForceKind.FRICTION and not rubs:
                continue
            if steps_of(start.drive.theta, record.values.shape[1], kind) > longest:
                continue
            if best is None or not explains(best, highest):
                fit = begun(record, start, order, kind, highest=highest)
                within = fit.bic < highest + WITHIN_REACH * fit.residual.size
                # First steps tell little of friction that stops masses soon.
                soon = kind is ForceKind.FRICTION and stops_soon(record, start)
                fit = fitted(fit) if within or soon else fit
                best = fit if best is None or fit.bic < best.bic else best
    if best is not None and followed:
        best = _beside_another(record, strong, best, highest=highest)
    # Where no force was found before, more than a few steps must not be needed.
    if best is None or (bent is None and best.bic > highest + WITHIN_REACH * best.residual.size):
        return None
    best = _with_modes(fitted(best), most)
    if best is None or not best.forces or best.bic >= highest:
        return None
    return replace(best, others=tuple(other for other in rub[1:] if other.bic < best.bic + NOT_RULED_OUT))


def out_of_reach(record: Record) -> bool:
    """Return whether the motion of the strongest pole of the linear fit takes more steps than structures are fitted to.

    Every structure contains it.
    """
    turning = np.flatnonzero((record.theta.imag > 0) & (record.theta.real < 0))
    if not turning.size:
        return False
    rates, count = 2 * record.theta.real[turning], record.values.shape[1]
    # Within the record: what hardly fades lasts no longer than that.
    energy = np.sum(np.abs(record.amplitudes[turning]) ** 2, axis=1) * np.expm1(rates * count) / rates
    return _too_long(record.theta[turning[[int(np.argmax(energy))]]], count)


def _too_long(theta: ComplexArray, count: int) -> bool:
    """Return whether even the motion without friction takes more steps than structures are fitted to."""
    return steps_of(theta, count, ForceKind.CUBIC) > LONGEST_FITTED


def _beside_another(record: Record, strong: DrivenFit, best: StructureFit, *, highest: float) -> StructureFit:
    """Return a structure, or a better one with another mode where a single one with friction does not explain a record.

    Friction hides another mode from a linear fit, which has parts and multiples of the strong one instead.
    """
    count = record.values.shape[1]
    if len(best.theta) > 1 or len(strong.drive.theta) > 1 or best.structures.kind is not ForceKind.FRICTION:
        return best
    others = np.array(next_poles(best.residual, best.variance, record.noise), complex)
    for start in beside_single(record, strong, others):
        if explains(best, highest):
            break
        if steps_of(start.drive.theta, count, ForceKind.FRICTION) <= LONGEST_BLIND:
            fit = fitted(begun(record, start, best.order, ForceKind.FRICTION, highest=highest))
            best = fit if fit.bic < best.bic else best
    return best


def _with_modes(fit: StructureFit, most: int) -> StructureFit | None:
    """Return the fit without forces that are not worth their gains, and with more modes as long as each is worth it.

    None if a mode does not stand; one that was added takes none of the others with it.
    Forces that one mode cannot tell apart are told apart beside the next. Friction is not kept for that: its motion
    takes many times longer.
    """
    waits = len(fit.theta) == 1 and fit.structures.kind is not ForceKind.FRICTION
    fits = [fit if waits else _needed(fit)]
    while leaves_more(fits[-1], fit.record.noise) and len(fits[-1].theta) < most:
        more = _with_mode(fits[-1])
        if more is None:
            break
        fits.append(_needed(more))
    if waits and len(fits) == 1:
        fits = [_needed(fit)]
    return next((each for each in reversed(fits) if np.all(stands(each))), None)


def _sticks(bent: Bent, noise: WhiteNoise) -> bool:
    """Return whether a fit with forces has friction among them, or leaves more than noise."""
    return any(force.kind is ForceKind.FRICTION for force in bent.forces) or leaves_more(bent.fit, noise)


def _with_mode(fit: StructureFit) -> StructureFit | None:
    """Return the fit with one more mode that explains most of the residual; None if there is none."""
    record = fit.record
    found = list[StructureFit]()
    count, kind = record.values.shape[1], fit.structures.kind
    for theta in next_poles(fit.residual, fit.variance, record.noise):
        if steps_of(np.append(fit.theta, theta), count, kind) > LONGEST_FITTED:
            continue
        trial = fitted(_joined(fit, theta), steps=FIRST)
        found += [fitted(trial)] if trial.bic < fit.bic and not _repeats(trial) else []
    best = min((each for each in found if not _repeats(each)), key=lambda each: each.bic, default=None)
    if best is None:
        return None
    enough = not leaves_more(best, record.noise) or np.max(np.sqrt(fit.variance / best.variance)) > REDUCTION
    return best if enough else None


def _repeats(fit: StructureFit) -> bool:
    """Return whether the last mode of a fit is a part or a multiple of another."""
    weights = fit.amplitudes / np.sqrt(fit.variance)
    return repeated(complex(fit.theta[-1]), weights[-1], fit.theta[:-1], weights[:-1], weak=0.0)


def _joined(fit: StructureFit, theta: complex) -> StructureFit:
    """Return a start with one more mode, on which no force acts yet."""
    powers, of = np.exp(theta * np.arange(fit.residual.shape[1])), fit.structures
    columns = np.column_stack([powers.real, -powers.imag])
    parts = np.linalg.lstsq(columns, fit.residual.T, rcond=None)[0]
    shape = (parts[0] + 1j * parts[1]) * theta**-fit.order
    gains = np.zeros((1, 1, len(fit.forces)), complex)
    return fit.with_structures(
        replace(
            of,
            theta=np.append(of.theta, [[theta]], axis=1),
            shapes=np.append(of.shapes, shape[None, None], axis=1),
            gains=np.append(of.gains, gains, axis=1),
        )
    )


def _kinds(record: Record, plain: DrivenFit, bent: Bent | None, highest: float) -> list[tuple[int, ForceKind]]:
    """Return the orders of the channels and kinds of force worth trying: those found, or those that promise most.

    Where none is found and what they promise is far above the highest BIC, none but friction that stops masses soon.
    """
    if bent is not None:
        worths = dict.fromkeys((force.kind for force in bent.forces), 0.0)
        for force, worth in zip(bent.forces, bent.fit.worths, strict=True):
            worths[force.kind] += float(worth)
        found = sorted(worths, key=lambda kind: -worths[kind])[:KINDS_TRIED]
        # Where the forces are not quite the true ones, a wrong order or kind may have explained more.
        tried = [(order, kind) for kind in found for order in sorted({0, bent.order})]
        return list(dict.fromkeys([*tried, *((0, kind) for kind in COMMON)]))
    if not len(record.theta):
        record = replace(record, theta=plain.drive.theta, amplitudes=plain.amplitudes)
    none = Bent(fit=plain, forces=(), order=0)
    trials = [
        trial
        for order in range(3)
        for motions in [record.motions(order)]
        for kind in COMMON
        if (trial := added(record, replace(none, order=order), kind, motions)) is not None
    ]
    most = min(plain.bic, highest + PROMISED_REACH * record.values.size)
    best = sorted((trial for trial in trials if trial.fit.promised < most), key=lambda trial: trial.fit.promised)
    kinds = list(dict.fromkeys(trial.forces[0].kind for trial in best))[:KINDS_TRIED]
    # Friction that stops masses soon promises little beside the poles of a linear fit, or nothing.
    if stops_soon(record, plain):
        kinds = list(dict.fromkeys([*kinds, ForceKind.FRICTION]))
    orders = {0, best[0].order} if best else {0}
    return [(order, kind) for kind in kinds for order in sorted(orders)]


def _needed(fit: StructureFit) -> StructureFit:
    """Return the fit without forces that are not worth their gains."""
    while len(fit.forces) > 1:
        fewer = fitted(_without(fit, int(np.argmin(worths_of(fit)))))
        if fewer.bic > fit.bic:
            break
        fit = fewer
    return fit


def _without(fit: StructureFit, index: int) -> StructureFit:
    """Return a start without one of the forces."""
    of = fit.structures
    fewer = Structures(
        theta=of.theta,
        shapes=of.shapes,
        gains=np.delete(of.gains, index, axis=2),
        forces=of.forces[:index] + of.forces[index + 1 :],
        scales=np.delete(of.scales, index),
    )
    return fit.with_structures(fewer)
