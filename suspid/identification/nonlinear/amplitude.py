"""How natural frequency and damping ratio of a mode depend on its amplitude."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from suspid.identification.covariance import inverse_information
from suspid.identification.nonlinear.driven import DrivenFit
from suspid.identification.nonlinear.forces import means
from suspid.units import ComplexArray, RadianPerSecond, Ratio, RealArray, Second
from suspid.values import frozen_real

# Windows over the decay, at most, and their least length in cycles of the slowest mode: the force of one cycle decides.
WINDOWS, WINDOW_CYCLES = 12, 1.0
# Harmonics of each mode beside which the part of a force in step with another mode is found.
HARMONICS = (2, 3, 4, 5)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class AmplitudeDependence:
    """Natural frequency and damping ratio of a mode over the amplitudes that were met.

    Each is that of the linear system whose restoring and damping forces are nearest, in the mean square, to those of
    the structure within a window of the decay (equivalent linearisation).

    Parameters
    ----------
    spans : tuple of (float, float)
        Start and end of each window [s].
    channel : str
        The channel in whose unit the amplitude is: that of the largest motion.
    amplitude : ndarray (window,)
        Amplitude of the mode: root mean square of its envelope within the window, in the unit of the channel.
    wn : ndarray (window,)
        Natural frequency [rad/s].
    zeta : ndarray (window,)
        Damping ratio [1].
    wn_std, zeta_std : ndarray (window,)
        Their standard deviations.
    holds_at : float
        The amplitude at which the values of the table of modes hold: they are means over the record, weighted by the
        energy of the mode.
    """

    spans: tuple[tuple[Second, Second], ...]
    channel: str
    amplitude: RealArray
    wn: RealArray
    zeta: RealArray
    wn_std: RealArray
    zeta_std: RealArray
    holds_at: float

    @property
    def ends(self) -> tuple[tuple[RadianPerSecond, Ratio], tuple[RadianPerSecond, Ratio]]:
        """Natural frequency and damping ratio at the largest and at the smallest amplitude."""
        first, last = int(np.argmax(self.amplitude)), int(np.argmin(self.amplitude))
        return (float(self.wn[first]), float(self.zeta[first])), (float(self.wn[last]), float(self.zeta[last]))


def equivalent(fit: DrivenFit, window: slice = slice(None)) -> tuple[ComplexArray, ComplexArray]:
    """Return the poles of the equivalent linear system (pole,), and their derivatives by the gains (pole, force).

    Each force is replaced by the combination of the states nearest to it within the window.
    """
    drive = fit.drive
    theta, out, count = drive.theta, drive.theta.copy(), len(drive.theta)
    if not len(drive.forces):
        return out, np.zeros(drive.gains.shape, complex)
    states = fit.states[:, window]
    columns = means(np.concatenate([2 * states.real, -2 * states.imag])).T
    if count > 1 and len(columns) > 8 * (columns.shape[1] + 4 * count * len(HARMONICS)):
        # What one mode's harmonics are to another's frequency is no stiffness of that.
        turns = states / (np.abs(states) + 1e-300)
        beside = [turns**m * size for m in HARMONICS for size in (1.0, np.abs(states))]
        columns = np.column_stack([columns, *(means(np.concatenate([each.real, each.imag])).T for each in beside)])
    nearest = np.linalg.lstsq(columns, drive.forces[:, window].T, rcond=1e-6)[0]
    parts = nearest[:count] + 1j * nearest[count : 2 * count]
    # z' = theta z + gains (h z + conj(h z)): a real system in z and its conjugate.
    own, other = np.diag(theta) + drive.gains @ parts.T, drive.gains @ parts.T.conj()
    system = np.block([[own, other], [other.conj(), own.conj()]])
    values = np.linalg.eigvals(system)
    values = values[values.imag > 0]
    if len(values) == count:
        # Each pole goes to the nearest of what the diagonal says, strongest first.
        left = list(values)
        for k in np.argsort(np.abs(own.diagonal() - theta)):
            out[k] = left.pop(int(np.argmin(np.abs(np.array(left) - own[k, k]))))
    else:
        out = own.diagonal()
    return out, parts


def pole_slopes(fit: DrivenFit, pole: int, by_gain: ComplexArray) -> RealArray:
    """Return the derivatives of Re and Im of an equivalent pole by the parameters of a fit, (2, parameter)."""
    drive = fit.drive
    out = np.zeros((2, drive.free), dtype=float)
    out[0, 2 * pole], out[1, 2 * pole + 1] = 1.0, 1.0
    for i, (k, j) in enumerate(drive.gain_places):
        if k == pole:
            at, h = 2 * len(drive.theta) + 2 * i, complex(by_gain[j])
            out[:, at] = h.real, h.imag
            out[:, at + 1] = -h.imag, h.real
    return out


def covariance_of(fit: DrivenFit) -> RealArray:
    """Return the covariance of the parameters of a fit, (parameter, parameter)."""
    return inverse_information(fit.information * (fit.freedom / fit.residual.shape[1]))


def dependence(
    fit: DrivenFit, pole: int, *, holds: complex, widening: float, timepts: RealArray, channels: tuple[str, ...]
) -> AmplitudeDependence:
    """Return how a mode depends on its amplitude; ``holds`` is its equivalent pole over the whole record."""
    strongest = int(np.argmax(np.abs(fit.amplitudes[pole])))
    envelope = np.abs(fit.states[pole]) * float(np.abs(fit.amplitudes[pole, strongest]))
    covariance, step = covariance_of(fit) * widening, float(timepts[-1] - timepts[0]) / (len(timepts) - 1)
    rows = []
    windows = _windows(envelope, fit.drive.theta)
    for window in windows:
        poles, by_gain = equivalent(fit, window)
        theta = complex(poles[pole])
        spread = pole_slopes(fit, pole, by_gain[pole])
        spread = spread @ covariance @ spread.T
        of_wn = np.array([theta.real, theta.imag]) / abs(theta)
        of_zeta = np.array([-(theta.imag**2), theta.real * theta.imag]) / abs(theta) ** 3
        rows.append(
            (
                float(np.sqrt(np.mean(envelope[window] ** 2))),
                abs(theta) / step,
                -theta.real / abs(theta),
                float(np.sqrt(of_wn @ spread @ of_wn)) / step,
                float(np.sqrt(of_zeta @ spread @ of_zeta)),
            )
        )
    amplitude, wn, zeta, wn_std, zeta_std = np.array(rows).T
    ratio = -holds.real / abs(holds)
    mean = float(np.sqrt(np.mean(envelope**4) / np.mean(envelope**2)))
    # Where the damping ratio passes through its mean; else the mean amplitude, weighted in the same way.
    order = np.argsort(amplitude)
    passes = np.flatnonzero(np.diff(np.sign(zeta[order] - ratio)) != 0)
    if len(passes):
        i = int(passes[-1])
        low, high = order[i], order[i + 1]
        share = (ratio - zeta[low]) / (zeta[high] - zeta[low])
        mean = float(amplitude[low] + share * (amplitude[high] - amplitude[low]))
    return AmplitudeDependence(
        spans=tuple((float(timepts[w.start]), float(timepts[w.stop - 1])) for w in windows),
        channel=channels[strongest],
        amplitude=frozen_real(amplitude),
        wn=frozen_real(wn),
        zeta=frozen_real(zeta),
        wn_std=frozen_real(wn_std),
        zeta_std=frozen_real(zeta_std),
        holds_at=mean,
    )


def _windows(envelope: RealArray, theta: ComplexArray) -> list[slice]:
    """Return windows over which the envelope falls by equal ratios, none shorter than some cycles."""
    count = len(envelope)
    least = max(8, int(np.ceil(WINDOW_CYCLES * 2 * np.pi / float(np.min(np.abs(theta.imag))))))
    if count < 2 * least:
        return [slice(0, count)]
    fall = np.log(np.maximum(envelope, 1e-12 * envelope.max()))
    fallen = np.maximum.accumulate(fall[0] - fall)
    wanted = np.linspace(0.0, fallen[-1], min(WINDOWS, count // least) + 1)[1:-1]
    cuts = [0]
    for cut in np.searchsorted(fallen, wanted).tolist():
        if cut - cuts[-1] >= least and count - cut >= least:
            cuts.append(int(cut))
    return [slice(a, b) for a, b in zip(cuts, [*cuts[1:], count], strict=True)]
