"""Find free decays in a recording: after a bump, a step, a drop, a release."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from suspid.arguments import explained
from suspid.cleaning import RecordLike, as_record
from suspid.decays.bursts import RINGING, RISE, Burst, died_down, find_bursts
from suspid.decays.candidates import Recording, decays_after, examined
from suspid.decays.coarse import coarsened
from suspid.decays.decay import Decay, Decays, is_grave
from suspid.decays.doubts import doubts_of_company
from suspid.decays.envelopes import Envelopes, envelopes, finest
from suspid.decays.fading import decay_of_fading
from suspid.decays.others import shares_a_mode, with_doubts_of_others
from suspid.decays.releases import releases
from suspid.decays.tails import free_end
from suspid.errors import RecordError
from suspid.levels import FEWEST_SAMPLES
from suspid.signals import Signal, as_signal
from suspid.threads import in_one_thread
from suspid.units import Hertz, Second
from suspid.words import DecayDoubt, DecayRemark, Remark

# Most events that are examined, the strongest first, and the number of doubtful or refused ones in a row that ends the
# search. Higher numbers find more of the weak decays of a long drive; each costs a tenth of a second.
MOST_BURSTS, MOST_IN_VAIN = 200, 8
# With at most this many events, none of them a decay, the whole record may be one.
FEW_BURSTS = 4


@explained
@in_one_thread
def find_decays(
    response: RecordLike, *, fs: Hertz | None = None, given: Sequence[tuple[Second, Second]] | None = None
) -> Decays:
    """Return the free decays in a recording, the best first.

    Each channel is split into octave bands; an event is a stretch in which a band rises further above its background
    than noise does. Later and later starts are tried from its onset on: the excitation ends at the first start from
    which damped exponentials explain all but noise, with no more poles than from the next starts. `identify` must find
    the same modes from there, or from a little later; otherwise that is a doubt. Steady noise, steady tones and rolling
    on a road give no decay. An event without a free decay is left out, and `Decays.remarks` says why. Where no event is
    beyond doubt, free motion is looked for after each of several pushes, and at the end of the record.

    Parameters
    ----------
    response : control.TimeResponseData, or what `as_record` takes
        The recording, uniformly sampled: displacements, velocities, accelerations, any channels.
    fs : float, optional
        Sampling rate [Hz] of samples that come without a time.
    given : sequence of (float, float), optional
        First and last time [s] of stretches that are known to decay freely: they are checked but not moved.

    Returns
    -------
    Decays
        In order of rank: decays without doubts first, then by how well they determine their modes.

    Raises
    ------
    RecordError
        If the recording cannot be used, or a given stretch is not within it.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import free_decay, quarter_car
    >>> from suspid.records import as_response
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> values = 1e-5 * np.random.default_rng(1).standard_normal((2, 3000))
    >>> values[:, 1200:] += free_decay(car, np.arange(1800) / 100, initial_state={"v_tire": 1.0}).y
    >>> decays = find_decays(as_response(np.arange(3000) / 100, values, ["chassis", "tire"]))
    >>> [round(decay.start, 1) for decay in decays]
    [12.0]
    """
    signal = as_signal(as_record(response, fs=fs), least=FEWEST_SAMPLES, copied=False)
    if given is not None:
        recording = _recording(signal)
        bursts = [_given(signal, recording.bands, first, last) for first, last in given]
        judged = [examined(recording, burst, moved=False) for burst in bursts]
        return _ranked([d for decays, _ in judged for d in decays], [r for _, remarks in judged for r in remarks])
    decays, remarks = _found(signal)
    if not decays:
        faded = decay_of_fading(signal, level=float(np.max(envelopes(signal).level)))
        decays = [] if faded is None else [faded]
    coarse = None if decays else coarsened(signal)
    if coarse is not None:
        decays, said = _found(coarse)
        remarks = said if decays else remarks
    return _ranked(with_doubts_of_others(signal, decays), remarks)


def decay_at_end(signal: Signal) -> Decay | None:
    """Return the decay at the end of a recording that is driven before, with its doubts; None without one."""
    return _at_end(_recording(signal))


def _recording(signal: Signal) -> Recording:
    quantum = finest(signal.values)
    return Recording(signal=signal, bands=envelopes(signal, quantum), finest=quantum)


def _found(signal: Signal) -> tuple[list[Decay], list[Remark]]:
    """Return the decays after the strongest events of a recording, and why others are none."""
    recording = _recording(signal)
    bursts = sorted(find_bursts(recording.bands), key=lambda burst: -burst.level)
    decays: list[Decay] = []
    remarks: list[Remark] = [] if bursts else [_nothing(recording.bands)]
    looked, vain, refused = 0, 0, list[Burst]()
    for burst in bursts[:MOST_BURSTS]:
        here, said = decays_after(recording, burst)
        decays += here
        remarks += said
        refused += [] if here else [burst]
        looked, vain = looked + 1, 0 if any(not decay.doubts for decay in here) else vain + 1
        if vain == MOST_IN_VAIN:
            break
    if not decays and len(bursts) <= FEW_BURSTS:
        # A decay that fills most of the record has no background to rise above.
        decays += examined(recording, _whole(signal, recording.bands), moved=True)[0]
    elif bursts and all(any(doubt.code is DecayDoubt.CUT_OFF for doubt in d.doubts) for d in decays):
        # Above a background at rest, the end of a slow decay rises again and again.
        last = signal.start + signal.step * (signal.values.shape[1] - 1)
        whole = examined(recording, replace(bursts[0], stop=last, cut=False, again=()), moved=True)[0]
        decays = [*whole, *(d for d in decays if not any(w.start <= d.stop and d.start <= w.stop for w in whole))]
    if bursts and all(_left(decay) > 1 for decay in decays):
        # A blow excites more modes than can be separated; once the fast ones have decayed, the slow ones can.
        for later in died_down(recording.bands, bursts[0]):
            slow = examined(recording, later, moved=True)[0]
            if slow and _left(slow[0]) <= 1:
                decays = [*slow]
                break
    if len(bursts) > looked:
        remarks.insert(0, Remark(DecayRemark.NOT_ALL, {"found": len(bursts), "examined": looked}))
    out = [_in_company(decay, decays, refused) for decay in decays]
    # What drives the motion makes events that are no decays; it says nothing of the end, where it is gone.
    if all(decay.doubts for decay in out):
        likely = [decay for decay in out if not _gravely_doubted(decay)]
        let_go = [decay for decay in _let_go(recording) if not _overlaps(decay, likely)]
        end = _at_end(recording) if not likely and not let_go else None
        ends = [] if end is None or _gravely_doubted(end) else [end]
        # Of the same motion, one decay is enough.
        out = [*let_go, *ends, *(decay for decay in out if not _overlaps(decay, let_go))]
    return out, remarks


def _gravely_doubted(decay: Decay) -> bool:
    return any(is_grave(doubt) for doubt in decay.doubts)


def _at_end(recording: Recording) -> Decay | None:
    """Return the decay at the end of a recording that is driven before, if there is one."""
    signal = recording.signal
    free = free_end(signal, recording.finest)
    if free is None:
        return None
    first, last = (signal.start + signal.step * sample for sample in (free[0], free[1] - 1))
    decays, _ = examined(recording, _given(signal, recording.bands, first, last), moved=True, alone=True)
    return decays[0] if decays else None


def _overlaps(decay: Decay, others: Sequence[Decay]) -> bool:
    return any(other.start < decay.stop and decay.start < other.stop for other in others)


def _within(decay: Decay, other: Decay) -> bool:
    """Return whether a decay is the end of another."""
    return other is not decay and other.start < decay.start and decay.stop <= other.stop


def _let_go(recording: Recording) -> list[Decay]:
    """Return the decays after pushes that are beyond grave doubt; all are doubted where most pushes have none.

    After each push a body shows the same modes: a decay that shares none with another does not speak for a release.
    """
    signal = recording.signal
    found, looked = releases(signal, recording.finest)
    decays = []
    for sample, after in found:
        first, last = (signal.start + signal.step * place for place in (sample, after - 1))
        here, _ = examined(recording, _given(signal, recording.bands, first, last), moved=False, alone=True)
        decays += [decay for decay in here if not _gravely_doubted(decay)]
    alike = len(decays) if len(decays) == 1 else sum(shares_a_mode(decay, decays) for decay in decays)
    company = doubts_of_company(looked - alike, looked)
    return [replace(decay, doubts=(*decay.doubts, *company)) for decay in decays]


def _in_company(decay: Decay, decays: Sequence[Decay], refused: Sequence[Burst]) -> Decay:
    """Return a decay, doubted if most events that are not far weaker are no decays; those are no larger than clicks.

    What rises within the decay, as where friction holds a mass and lets it go, is part of it.
    """
    others = sum(burst.level > decay.level - RISE and not decay.start < burst.onset < decay.stop for burst in refused)
    beside = sum(other.level > decay.level - RISE for other in decays)
    return replace(decay, doubts=(*decay.doubts, *doubts_of_company(others, others + beside)))


def _left(decay: Decay) -> float:
    """Return the largest share of the motion that a doubt about a decay says is left unexplained."""
    doubted = [doubt for doubt in decay.doubts if doubt.code in (DecayDoubt.FORCED, DecayDoubt.DRIVEN)]
    return max((share for doubt in doubted if isinstance(share := doubt.numbers["share"], float)), default=0.0)


def _ranked(decays: Iterable[Decay], remarks: Iterable[Remark]) -> Decays:
    # Of a decay that is doubted, the end is no better than all of it.
    parts = [decay for decay in decays if decay.doubts and any(_within(decay, other) for other in decays)]
    order = sorted(decays, key=lambda decay: (bool(decay.doubts) + (decay in parts), -decay.strength))
    return Decays(tuple(replace(decay, rank=rank) for rank, decay in enumerate(order, start=1)), tuple(remarks))


def _nothing(bands: Envelopes) -> Remark:
    """Return the remark that no event was found."""
    at = int(np.argmax(bands.level))
    time, level = float(bands.timepts[at]), float(bands.level[at])
    return Remark(DecayRemark.NO_EVENT, {"time": time, "level": level, "threshold": bands.threshold})


def _whole(signal: Signal, bands: Envelopes) -> Burst:
    """Return the whole record as an event."""
    return _given(signal, bands, signal.start, signal.start + signal.step * (signal.values.shape[1] - 1))


def _given(signal: Signal, bands: Envelopes, first: Second, last: Second) -> Burst:
    """Return a stretch that the user gives as an event."""
    time = signal.timepts
    if not (time[0] - 0.5 * signal.step <= first < last <= time[-1] + 0.5 * signal.step):
        raise RecordError(
            f"the stretch {first:g} … {last:g} s is not within the record, {time[0]:g} … {time[-1]:g} s; give its "
            f"first and last time"
        )
    inside = (bands.timepts >= first) & (bands.timepts <= last)
    levels = bands.levels[:, inside] if np.any(inside) else bands.levels[:, :1]
    early = np.median(levels[:, : max(1, levels.shape[1] // 4)], axis=1)
    rings = np.flatnonzero(early > bands.threshold - RINGING)
    top = bands.centres[rings[0]] if rings.size else bands.centres[0]
    return Burst(
        onset=first,
        peak=first,
        stop=last,
        level=float(np.max(levels)),
        top=float(top),
        width=signal.step,
        cut=False,
    )
