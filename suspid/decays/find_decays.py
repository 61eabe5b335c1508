"""Where in a long recording something decays freely: after a bump, a step, a drop, a release."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from suspid.decays.bursts import Burst, Envelopes, envelopes, find_bursts, finest
from suspid.decays.doubts import (
    Kind,
    clipped_samples,
    doubts_of,
    doubts_of_background,
    doubts_of_company,
    drowned,
    fits,
    kind_of,
    refused,
)
from suspid.decays.starts import searched, verified
from suspid.decays.trials import block_size, quiet_variance, tried
from suspid.errors import RecordError
from suspid.identification import FEWEST_SAMPLES
from suspid.signals import Signal, as_signal
from suspid.units import Decibel, RealArray, Second
from suspid.values import frozen_real, text_table

if TYPE_CHECKING:
    import control

# The strongest bursts, so many, are looked at.
MOST_BURSTS = 16
# After so many on end that are no decays beyond doubt the others, weaker still, are left alone.
MOST_IN_VAIN = 8
# Bands that rise again more often than so within a burst are no sign of further decays. Between two rises must lie so
# many periods of the highest band that stands out.
MOST_AGAIN, LEAST_PERIODS = 3, 8.0
# Once the start is known, so many blocks of the stretch are looked at.
MOST_IN_ALL = 2000


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Decay:
    """A stretch of free decay.

    Parameters
    ----------
    start, stop : float
        Its first and last time [s]; the forcing has ended at the start.
    rank : int
        1 for the one that determines its modes best.
    kind : {"impulse", "step", "release", "step or release"} or None
        What set it off; None if the record does not tell.
    level : float
        How far it stands above the background, at its peak in its best band [dB].
    cycles : float
        How many it makes before it sinks into the noise or ends: of the mode that makes most, among those that
        carry at least a hundredth of the energy [1].
    strength : float
        Energy of its modes over the variance of the noise, times the square of the cycles [dB].
    wn, zeta : ndarray (mode,)
        Natural frequencies [rad/s] and damping ratios [1] that it was recognised by; `identify` knows them better.
    doubts : tuple of str
        What speaks against it; empty if nothing does.
    """

    start: Second
    stop: Second
    rank: int
    kind: Kind | None
    level: Decibel
    cycles: float
    strength: Decibel
    wn: RealArray
    zeta: RealArray
    doubts: tuple[str, ...]

    def __str__(self) -> str:
        said = f"; {'; '.join(self.doubts)}" if self.doubts else ""
        what = f"{self.cycles:.1f} cycles, {self.level:.0f} dB above the background"
        return f"{self.start:.6g} … {self.stop:.6g} s: {what}{said}"


class Decays(tuple[Decay, ...]):
    """Decays in order of rank, and what else stood out.

    Attributes
    ----------
    remarks : tuple of str
        What is no decay, and why; what was not looked at.
    """

    remarks: tuple[str, ...]

    def __new__(cls, decays: Iterable[Decay] = (), *, remarks: Sequence[str] = ()) -> Decays:
        """Hold the decays in the order given."""
        made = super().__new__(cls, decays)
        made.remarks = tuple(remarks)
        return made

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle with the remarks."""
        return _made, (tuple(self), self.remarks)

    def __str__(self) -> str:
        columns: dict[str, list[str]] = {
            "rank": [str(decay.rank) for decay in self],
            "start [s]": [f"{decay.start:.6g}" for decay in self],
            "stop [s]": [f"{decay.stop:.6g}" for decay in self],
            "after": [decay.kind or "?" for decay in self],
            "above background [dB]": [f"{decay.level:.0f}" for decay in self],
            "cycles": [f"{decay.cycles:.1f}" for decay in self],
            "f [Hz]": [", ".join(f"{wn / (2 * np.pi):.3g}" for wn in decay.wn) for decay in self],
            "doubts": ["; ".join(decay.doubts) or "none" for decay in self],
        }
        parts = [text_table(columns)] if self else ["no free decay"]
        return "\n".join([*parts, *self.remarks])


def _made(decays: tuple[Decay, ...], remarks: tuple[str, ...]) -> Decays:
    return Decays(decays, remarks=remarks)


def find_decays(response: control.TimeResponseData, *, given: Sequence[tuple[Second, Second]] | None = None) -> Decays:
    """Return the stretches of free decay in a recording, the best first.

    Each channel is split into octave bands; where one stands further above its background than noise does, something
    happened there. From the onset on, later and later starts are tried: the first from which damped exponentials
    explain all but noise, with no more poles than from the next starts on, is where the forcing has ended. `identify`
    must find the same modes from there, or from a little later; else that is a doubt. Steady noise, steady tones and
    rolling on a road give no decay. What stands out and does not decay freely is left out, and `Decays.remarks` says
    why; what is usable with care carries its doubts.

    Parameters
    ----------
    response : control.TimeResponseData
        The recording, uniformly sampled: displacements, velocities, accelerations, any channels.
    given : sequence of (float, float), optional
        First and last time [s] of stretches that are known to decay freely: they are judged, not moved.

    Returns
    -------
    Decays
        A tuple of `Decay`, in order of rank: those without doubts first, each by what it tells of its modes.

    Raises
    ------
    RecordError
        If the recording cannot be used, or a given stretch is not within it.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import free_decay, quarter_car
    >>> from suspid.signals import as_response
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> values = 1e-5 * np.random.default_rng(1).standard_normal((2, 3000))
    >>> values[:, 1200:] += free_decay(car, np.arange(1800) / 100, initial_state={"v_tire": 1.0}).y
    >>> decays = find_decays(as_response(np.arange(3000) / 100, values, ["chassis", "tire"]))
    >>> [round(decay.start, 1) for decay in decays]
    [12.0]
    """
    signal = as_signal(response, least=FEWEST_SAMPLES)
    found = envelopes(signal)
    rounding = finest(signal.values)
    remarks: list[str] = []
    decays: list[Decay] = []
    if given is not None:
        for first, last in given:
            decays += _judged(signal, found, rounding, _given(signal, found, first, last), remarks, moved=False)
        return _ranked(decays, remarks)
    bursts = find_bursts(found)
    if not bursts:
        at = int(np.argmax(found.level))
        remarks.append(
            f"Nothing stands out: the level is highest at t = {found.timepts[at]:.6g} s, {found.level[at]:.1f} dB "
            f"above the background, and steady noise reaches {found.threshold:.1f} dB."
        )
    looked, vain = 0, 0
    for burst in sorted(bursts, key=lambda burst: -burst.level)[:MOST_BURSTS]:
        here = _apart(signal, found, rounding, burst, remarks)
        decays += here
        looked, vain = looked + 1, 0 if any(not decay.doubts for decay in here) else vain + 1
        if vain == MOST_IN_VAIN:
            break
    if len(bursts) > looked:
        remarks.insert(
            0,
            f"{len(bursts)} stretches stand out; the {looked} strongest were looked at. Cut the recording, or give "
            f"the stretches, for the others.",
        )
    company = doubts_of_company(looked - len(decays), looked)
    return _ranked([replace(decay, doubts=(*decay.doubts, *company)) for decay in decays], remarks)


def _ranked(decays: list[Decay], remarks: list[str]) -> Decays:
    order = sorted(decays, key=lambda decay: (bool(decay.doubts), -decay.strength))
    return Decays([replace(decay, rank=rank) for rank, decay in enumerate(order, start=1)], remarks=remarks)


def _given(signal: Signal, found: Envelopes, first: Second, last: Second) -> Burst:
    """Return a stretch that the user gives as a burst."""
    time = signal.timepts
    if not (time[0] - 0.5 * signal.step <= first < last <= time[-1] + 0.5 * signal.step):
        raise RecordError(
            f"the stretch {first:g} … {last:g} s is not within the record, {time[0]:g} … {time[-1]:g} s; give its "
            f"first and last time"
        )
    inside = (found.timepts >= first) & (found.timepts <= last)
    levels = found.levels[:, inside] if np.any(inside) else found.levels[:, :1]
    rings = np.flatnonzero(np.median(levels[:, : max(1, levels.shape[1] // 4)], axis=1) > found.threshold - 3.0)
    top = found.centres[rings[0]] if rings.size else found.centres[0]
    return Burst(
        onset=first,
        peak=first,
        stop=last,
        level=float(np.max(levels)),
        top=float(top),
        width=signal.step,
        cut=False,
    )


def _apart(signal: Signal, found: Envelopes, rounding: RealArray, burst: Burst, remarks: list[str]) -> list[Decay]:
    """Return the decays after a burst: the second begins where a band rises again, if no decay lasts through that."""
    said: list[str] = []
    out = _judged(signal, found, rounding, burst, said, moved=True)
    if not burst.again or len(burst.again) > MOST_AGAIN or (out and out[0].start < burst.again[0]):
        remarks += said
        return out
    for onset in reversed(burst.again):
        later = _judged(signal, found, rounding, replace(burst, onset=onset), [], moved=True)
        if later:
            out = later if not out or later[0].start < out[0].start else out
            break
    if not out:
        remarks += said
        return []
    edges = [burst.onset, *(onset for onset in burst.again if onset <= out[0].start)]
    for onset, stop in pairwise(edges):
        if stop - onset > LEAST_PERIODS * burst.width:
            out += _judged(
                signal, found, rounding, replace(burst, onset=onset, stop=stop, cut=True), remarks, moved=True
            )
    return out


def _judged(
    signal: Signal, found: Envelopes, rounding: RealArray, burst: Burst, remarks: list[str], *, moved: bool
) -> list[Decay]:
    """Return the decay after a burst in a list, or an empty one and a remark on why there is none."""
    where = f"t = {burst.onset:.6g} s stands {burst.level:.0f} dB above the background, but"
    first = max(0, int(np.ceil((burst.onset - signal.start) / signal.step - 1e-6)))
    last = min(signal.values.shape[1], int(np.floor((burst.stop - signal.start) / signal.step + 1e-6)) + 1)
    # A road that has been stepped on stands still afterwards: it takes no part.
    later = signal.values[:, first + (last - first) // 2 : last]
    moving = np.flatnonzero(np.ptp(later, axis=1) > 0) if later.size else np.zeros(0, np.intp)
    part = replace(
        signal,
        values=frozen_real(signal.values[moving]),
        channels=tuple(signal.channels[channel] for channel in moving),
    )
    clipped = clipped_samples(part.values)
    size = min(block_size(signal.step, burst.top), max(1, (last - first) // 64))
    begin, trial, driven, objection = first, None, False, None
    if moving.size:
        least = quiet_variance(part.values, size=size, length=last - first, finest=rounding[moving])
        if moved:
            begin, trial, driven = searched(part, least, burst, first, last, size, clipped)
        # What carries doubts anyway is not worth the time.
        if moved and trial is not None and fits(trial) and refused(trial) is None:
            begin, objection = verified(part, trial, begin, last, size, moved=True)
        if trial is not None or not moved:
            whole = tried(part.values[:, begin:last], step=signal.step, size=size, least=least, most=MOST_IN_ALL)
            trial = whole or trial
    if driven:
        remarks.append(f"{where} it goes on in a way that no decay follows: it is driven on.")
        return []
    if trial is None:
        remarks.append(f"{where} it is too short, or goes on too briefly, to be a decay.")
        return []
    reason = refused(trial) or drowned(trial, found, signal.start + signal.step * begin)
    if reason:
        remarks.append(f"{where} {reason}.")
        return []
    if not moved and fits(trial):
        _, objection = verified(part, trial, begin, last, size, moved=False)
    theta = trial.selection.fit.poles.pairs[trial.modes] / trial.step
    order = np.argsort(np.abs(theta))
    strong = trial.strengths >= 0.01 * np.max(trial.strengths)
    cycles = float(np.max(trial.cycles[strong]))
    energy = float(np.sum(trial.strengths))
    time = signal.start + signal.step * np.array([begin, last - 1])
    return [
        Decay(
            start=float(time[0]),
            stop=float(time[1]),
            rank=0,
            kind=kind_of(part, trial, first, begin) if moved else None,
            level=burst.level,
            cycles=cycles,
            strength=float(10 * np.log10(max(energy, 1e-30) * max(cycles, 1e-3) ** 2)),
            wn=frozen_real(np.abs(theta[order])),
            zeta=frozen_real(-theta[order].real / np.abs(theta[order])),
            doubts=(
                *doubts_of(part, trial, burst, cycles, begin, clipped[begin:last]),
                *doubts_of_background(part, trial, size=size, length=last - begin),
                *([objection] if objection else []),
            ),
        )
    ]
