"""Identify a decay by maximum likelihood, with forces that are not linear where they explain it better."""

from __future__ import annotations

from dataclasses import replace
from enum import Enum
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from suspid.errors import IdentificationError
from suspid.identification.changing import with_changing
from suspid.identification.classification import SAMPLES_EACH
from suspid.identification.combs import without_comb, without_overtones
from suspid.identification.considered import Considered, beside_bent, considered_of
from suspid.identification.covariance import joint_covariance
from suspid.identification.dominant import dominant
from suspid.identification.exponentials import inner_products
from suspid.identification.halves import disagreement
from suspid.identification.harmonics import without_harmonics
from suspid.identification.identification import Identification
from suspid.identification.noise import WhiteNoise, noise_of, shared_noise
from suspid.identification.nonlinear import (
    AmplitudeDependence,
    Bent,
    find_forces,
    modes_of_bent,
    unlike_linear,
)
from suspid.identification.ongoing import without_lines
from suspid.identification.pulses import without_beginning, without_pulse
from suspid.identification.selection import Selection, select
from suspid.identification.steps import FourSteps
from suspid.identification.traces import traces
from suspid.levels import FEWEST_SAMPLES, NORMAL_95
from suspid.model import ModalSet
from suspid.samples import as_samples
from suspid.signals import Signal
from suspid.units import RadianPerSecond, RealArray, Second
from suspid.values import frozen_real
from suspid.words import Reason, Remark

if TYPE_CHECKING:
    import control


# A mode whose damping may be zero is determined if its frequency is known to this share: a line of a spectrum is. A
# larger share takes the noise of short records for modes.
VAGUE = 0.05
# The frequency of any mode is open if its interval is wider than this share of it to either side.
LEFT_OPEN = 0.5
# Forces are told by what differs between large and small motion, the halves of a decay, each of which a fit must see.
# In fewer samples some of the many forces that may act fit any motion, unless the noise is below this share of it.
LEAST_FOR_FORCES, LITTLE_NOISE = 2 * FEWEST_SAMPLES, 0.05
# A mode under forces that is not determined, but has this share of the largest amplitude, is plain to see: the forces
# are not the true ones then.
PLAIN_SIZE = 0.1


class Forces(Enum):
    """What is done about friction and other forces where the linear fit gives reason to look for them."""

    SOUGHT = "sought"
    IGNORED = "ignored"
    REFUSED = "refused"


def by_likelihood(
    response: control.TimeResponseData,
    signal: Signal,
    centred: RealArray,
    steps: FourSteps,
    band: tuple[RadianPerSecond, RadianPerSecond] | None,
    *,
    forces: Forces,
) -> Identification:
    """Return the modes of the fit that is most likely; friction and other forces are treated as asked for."""
    low, high = band or (0.0, np.pi / signal.step)
    noise = noise_of(signal.values)
    limits = (low * signal.step, high * signal.step)
    selection = select(centred, noise=noise, modes=steps.count, band=limits)
    bent = None
    if forces is not Forces.IGNORED and _tells(centred, selection) and _fades(centred) and unlike_linear(selection):
        if forces is Forces.REFUSED:
            raise IdentificationError("the motion may not be linear: a search for friction and other forces is needed")
        bent = find_forces(centred, noise=noise, selection=selection, modes=steps.count)
        if bent is not None and bent.count < (steps.count or 0) <= len(selection.modes):
            bent = None
    described = None if bent is None else _described(bent, signal, steps.count)
    if bent is not None and described is not None:
        modes, loudness, dependence, growing = described
        _check_count(modes, steps.count)
        left, freedom, found = bent.residual, bent.freedom, bent.forces
        considered = (*growing, *beside_bent(selection, modes, signal.step))
    else:
        if steps.count is None:
            selection = with_changing(selection, centred, noise, limits)
            selection = without_pulse(
                without_beginning(without_overtones(without_comb(without_lines(selection)))), centred
            )
            if not len(selection.modes):
                selection = dominant(centred, noise=noise, band=limits, selection=selection) or selection
        modes, loudness = _modes_of(selection, centred, noise, step=signal.step, channels=signal.channels)
        # Whether a frequency may be zero is asked of the fit itself, not of what a further pole would say.
        alone = replace(selection, widening=np.zeros_like(selection.widening))
        own = modes
        if np.any(selection.widening > 1):
            own, _ = _modes_of(alone, centred, noise, step=signal.step, channels=signal.channels)
        fewer = selection if steps.count is not None else _fewer(selection, own, modes)
        if fewer is not selection:
            selection = fewer
            modes, loudness = _modes_of(selection, centred, noise, step=signal.step, channels=signal.channels)
        _check_count(modes, steps.count)
        left, freedom, found = selection.residual, selection.fit.freedom, ()
        considered, dependence = considered_of(selection, modes, signal.step), ()
    return Identification(
        response=response,
        method="likelihood",
        modes=modes,
        fitted=as_samples(signal.timepts, signal.values - left, signal.channels, title="Fitted decay", copied=False),
        residual=as_samples(signal.timepts, left, signal.channels, title="Residual", copied=False),
        noise_std=frozen_real(np.sqrt(inner_products(left, left) / freedom)),
        loudness=loudness,
        considered=considered,
        steps=steps,
        amplitude_dependence=dependence,
        forces=found,
    )


def _described(
    bent: Bent, signal: Signal, count: int | None
) -> tuple[ModalSet, RealArray, tuple[AmplitudeDependence, ...], tuple[Considered, ...]] | None:
    """Return the modes under forces, how loud the residual is near each, their amplitudes, and the other poles.

    Without a number of modes, one that grows over most of its amplitudes is none, nor one that is not determined; None
    if no other is left, or if one of those is plain to see.
    """
    modes, loudness, dependence = modes_of_bent(bent, timepts=signal.timepts, channels=signal.channels)
    if count is not None:
        return modes, loudness, dependence, ()
    grows = np.array([np.median(each.zeta) < 0 for each in dependence], bool)
    # What each part of a decay damps has damping, however much it differs from part to part.
    damped = np.array([np.all(each.zeta > NORMAL_95 * each.zeta_std) for each in dependence], bool)
    open_ones = _undetermined(modes) | (_vague(modes) & ~damped)
    none = grows | open_ones
    if none.all() or np.any(_sizes(bent, modes, signal.step)[open_ones] > PLAIN_SIZE):
        return None
    reasons = [Reason.GROWING if each else Reason.UNKNOWN for each in grows[none]]
    others = [
        Considered(pole=complex(p), remark=Remark(r), removed=True)
        for p, r in zip(modes.poles[none], reasons, strict=True)
    ]
    kept = tuple(each for each, left_out in zip(dependence, none, strict=True) if not left_out)
    return modes[~none], frozen_real(loudness[~none]), kept, tuple(others)


def _sizes(bent: Bent, modes: ModalSet, step: Second) -> RealArray:
    """Return the first amplitude of each mode over the largest of all, in the channel where that is most, (mode,)."""
    fit = bent.fit if bent.structure is None else bent.structure
    sizes = np.abs(fit.amplitudes)
    shares = np.max(sizes / np.maximum(np.max(sizes, axis=0), 1e-300), axis=1)
    return np.array([shares[np.argmin(np.abs(fit.theta / step - pole))] for pole in modes.poles])


def _check_count(modes: ModalSet, count: int | None) -> None:
    """Refuse fewer modes than were asked for."""
    if count is not None and len(modes) < count:
        where = f", at {', '.join(f'{wn:.4g}' for wn in modes.wn)} rad/s" if len(modes) else ""
        raise IdentificationError(
            f"{count} modes were requested, {len(modes)} could be found{where}; no other pole of that fit is a "
            f"mode: request fewer, or leave their number open",
            found=modes if len(modes) else None,
        )


def _tells(centred: RealArray, selection: Selection) -> bool:
    """Return whether a record (channel, sample) has enough samples to tell forces from noise."""
    if centred.shape[1] >= LEAST_FOR_FORCES:
        return True
    # A fit with as many unknowns as samples leaves nothing of any motion.
    noise = selection.fit.squares / max(selection.fit.freedom, 1e-300)
    return bool(np.all(noise < LITTLE_NOISE**2 * np.mean(centred**2, axis=1)))


def _fades(values: RealArray) -> bool:
    """Return whether the last third of a record moves less than the first, each about its own mean."""
    third = values.shape[1] // 3
    first, last, whole = (
        inner_products(part, part) / part.shape[1] - part.mean(axis=1) ** 2
        for part in (values[:, :third], values[:, -third:], values)
    )
    # A larger ratio spends more time on noise, with a smaller one slow decays stay linear.
    return bool(np.sum(last / whole) < 0.9 * np.sum(first / whole))


def _modes_of(
    selection: Selection, values: RealArray, noise: WhiteNoise, *, step: Second, channels: tuple[str, ...]
) -> tuple[ModalSet, RealArray]:
    """Return the modes of one decay and how loud the residual is near each, (mode,).

    The variances of a mode are widened by its loudness, and by noise that the channels share; or by the square of the
    disagreement of the two halves of the decay where that is more and the residual shows that it is no chance. Where a
    mode may be two, its interval and those beside it hold what the fit with both says.
    """
    fit, kept = selection.fit, selection.modes
    loudness = selection.loudness[kept]
    widening = loudness * shared_noise(selection.residual, np.sqrt(noise.least))
    noise_std = np.sqrt(fit.squares / fit.count)
    for k in np.flatnonzero(((loudness > 1) | selection.bends[kept]) & (kept < len(fit.poles.pairs))):
        widening[k] = np.nanmax([widening[k], disagreement(values, fit.poles, int(kept[k]), noise_std) ** 2])
    widening = np.maximum(widening, selection.widening[kept])
    joint = joint_covariance([fit], kept, widening)
    order = np.argsort(np.abs(joint.exponents), kind="stable")
    return joint.modes(step=step, channels=channels), frozen_real(loudness[order])


def _fewer(selection: Selection, own: ModalSet, modes: ModalSet) -> Selection:
    """Return the poles, of which multiples of a stronger mode, traces, and those not determined are no modes."""
    fewer = without_harmonics(selection, own)
    few = selection.fit.count < SAMPLES_EACH * (1 + 2 * len(selection.fit.poles.every))
    # What a further pole would say counts where there may be nearly as many poles as samples.
    unknown, trace = _undetermined(own) | _vague(modes if few else own), traces(selection, modes)
    if not np.any(unknown | trace):
        return fewer
    order = selection.modes_by_wn
    reasons = list(fewer.reasons)
    for k in order[trace].tolist():
        reasons[k] = reasons[k] or Reason.TRACE
    for k in order[unknown].tolist():
        reasons[k] = Reason.UNKNOWN
    return replace(fewer, reasons=tuple(reasons))


def _undetermined(modes: ModalSet) -> NDArray[np.bool_]:
    """Return which modes have a frequency that the record leaves open, (mode,)."""
    if modes.wn_std is None:
        return np.zeros(len(modes), bool)
    return np.asarray((modes.poles.imag > 0) & (NORMAL_95 * modes.wn_std > LEFT_OPEN * modes.wn))


def _vague(modes: ModalSet) -> NDArray[np.bool_]:
    """Return which modes may have no damping, at a frequency that is hardly known, (mode,)."""
    if modes.wn_std is None or modes.zeta_std is None:
        return np.zeros(len(modes), bool)
    rough = NORMAL_95 * modes.wn_std > VAGUE * modes.wn
    return np.asarray((modes.poles.imag > 0) & rough & (np.abs(modes.zeta) < NORMAL_95 * modes.zeta_std))
