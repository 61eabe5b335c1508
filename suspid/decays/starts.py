"""From which sample on a stretch decays freely: searched with trials, verified with `identify`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from suspid.decays.bursts import Burst
from suspid.decays.doubts import refused
from suspid.decays.sketches import clearly_driven
from suspid.decays.trials import FEWEST_BLOCKS, Trial, tried
from suspid.errors import SuspidError
from suspid.identification import REASONS, Identification, identify
from suspid.signals import Signal, as_response
from suspid.units import RealArray

# Starts that are tried lie by this factor further from the onset, up to this share of the stretch; then the interval
# between the last that fails and the first that holds is halved so often.
LATER, LATEST, HALVINGS = 1.4, 0.4, 2
# Before all of them these are looked at, over fewer blocks: if each is refused, so is the stretch.
LOOKS, LOOK_BLOCKS = (1, 6, 11), 300
# A start holds if the next ones need no fewer poles: those that absorb the forcing are gone then.
NEXT = 2
# If none holds, later ones are tried for so many periods of the band that knows the onset after the one that leaves
# least.
PATIENCE = 4
# A start that leaves less than this share of the motion may be the end of the search.
FITTING = 0.5
# A start is verified, or one of those so many quarters of a block later.
QUARTERS = (0, 1, 2, 3, 4, 6, 9, 14, 20)
BRIEF = REASONS["a few samples"]
# Modes that carry at least this share of the energy are found again: as near as this share of their frequency and so
# many of their own standard deviations, beside a residual at most so many times as loud as white noise.
STRONG, NEAR, SURE, LOUDEST = 0.05, 0.05, 5.0, 4.0


def searched(
    signal: Signal, least: RealArray, burst: Burst, first: int, last: int, size: int, clipped: NDArray[np.bool_]
) -> tuple[int, Trial | None, bool]:
    """Return the first sample from which a stretch decays freely, the fit from there, and whether all is driven.

    Parameters
    ----------
    signal : Signal
        The recording.
    least : ndarray (channel,)
        Least variance of the noise of a block.
    burst : Burst
        What stands out.
    first, last : int
        Its first sample, and the one after its last.
    size : int
        Samples per block.
    clipped : ndarray (sample,)
        Which samples are clipped: those early in the stretch are left out.
    """
    known: dict[int, Trial | None] = {}
    driven: dict[int, bool] = {}

    def at(index: int) -> Trial | None:
        if index not in known:
            known[index] = tried(signal.values[:, index:last], step=signal.step, size=size, least=least)
        return known[index]

    def hopeless(index: int) -> bool:
        if index not in driven:
            long_enough = (last - index) // size >= FEWEST_BLOCKS
            driven[index] = long_enough and clearly_driven(signal.values[:, index:last], size=size)
        return driven[index]

    early = np.flatnonzero(clipped[first : first + (last - first) // 4])
    begin = first + (int(early[-1]) + 1 if early.size else 0)
    pace = max(1.0, 0.25 * burst.width / signal.step)
    delays = [0.0, pace]
    while delays[-1] * LATER < LATEST * (last - begin):
        delays.append(delays[-1] * LATER)
    places = list(dict.fromkeys(begin + round(delay) for delay in delays))
    seen = None
    for look in (places[number] for number in LOOKS if number < len(places)):
        if not hopeless(look):
            part = signal.values[:, look:last]
            trial = tried(part, step=signal.step, size=size, least=least, most=LOOK_BLOCKS)
            seen = seen or trial
            if trial is None or refused(trial) is None:
                break
    else:
        if len(places) > 1:
            return begin, seen, seen is None
    shares: list[tuple[float, int]] = []
    for number, place in enumerate(places):
        if hopeless(place):
            continue
        trial = at(place)
        if trial is None:
            break
        if not len(trial.modes):
            continue
        after = [at(later) for later in places[number + 1 : number + 1 + NEXT]] if trial.excess <= 1 else []
        if trial.excess <= 1 and all(later is None or later.poles >= trial.poles for later in after):
            return *_earlier(at, places[number - 1] if number else place, place), False
        shares.append((trial.early, place))
        fewest = min(shares)
        if fewest[0] < FITTING and place - fewest[1] > PATIENCE * burst.width / signal.step:
            break
    if not shares:
        return (begin, None, True) if all(driven.get(place) for place in places) else (begin, at(begin), False)
    # Where no start holds, the first from which about as little is left as from any other.
    place = next(place for share, place in shares if share <= 1.5 * min(shares)[0])
    return place, at(place), False


def _earlier(at: Callable[[int], Trial | None], low: int, high: int) -> tuple[int, Trial | None]:
    """Return an earlier start that holds too, between one that does not and one that does, by halving."""
    found = at(high)
    for _ in range(HALVINGS):
        middle = (low + high) // 2
        trial = at(middle) if middle not in (low, high) else None
        if found is None or trial is None:
            break
        if trial.excess <= 1 and len(trial.modes) and trial.poles <= found.poles:
            high, found = middle, trial
        else:
            low = middle
    return high, found


def verified(signal: Signal, trial: Trial, begin: int, last: int, size: int, *, moved: bool) -> tuple[int, str | None]:
    """Return a start from which `identify` finds the modes of a trial, and what it says if there is none.

    A trial looks at means over blocks; a few samples of what came before hide in them, and not from `identify`.

    Parameters
    ----------
    signal : Signal
        The recording, the channels that take part.
    trial : Trial
        The fit that recognised the decay.
    begin, last : int
        First sample of the decay, and the one after its last.
    size : int
        Samples per block.
    moved : bool
        Whether later starts may be tried.
    """
    said: str | None = None
    usable: int | None = None
    places = [begin + round(quarter * max(1.0, size / 4)) for quarter in QUARTERS] if moved else [begin]
    for place in places:
        if place - begin > LATEST * (last - begin):
            break
        part = signal.values[:, place:last]
        try:
            found = identify(as_response(signal.timepts[place:last], part, signal.channels))
        except SuspidError as error:
            objection: str | None = f"it cannot be identified: {error}"
        else:
            objection = _objection(trial, found)
            # What is gone within a few samples stands for samples of what came before.
            if objection is None and not any(c.removed and c.reason == BRIEF for c in found.considered):
                return place, None
            usable = place if objection is None and usable is None else usable
        said = said or objection
    return (begin, said) if usable is None else (usable, None)


def _objection(trial: Trial, found: Identification) -> str | None:
    """Return what an identification says against the modes of a trial, or None."""
    strong = trial.strengths >= STRONG * np.max(trial.strengths)
    poles = trial.selection.fit.poles.pairs[trial.modes][strong] / trial.step
    spread = -poles.real * np.sqrt(2 / trial.strengths[strong])
    reach = NEAR * np.abs(poles) + SURE * spread
    missing, loudest = [], 1.0
    for pole, most in zip(poles, reach, strict=True):
        apart = np.abs(found.modes.poles - pole)
        if not apart.size or np.min(apart) > most:
            missing.append(f"{abs(pole) / (2 * np.pi):.3g}")
            continue
        loudest = max(loudest, float(found.loudness[np.argmin(apart)]))
    if missing:
        return f"identified alone, from its first sample to its last, it shows no mode at {', '.join(missing)} Hz"
    if loudest > LOUDEST:
        return (
            f"identified alone, it leaves {10 * np.log10(loudest):.0f} dB more beside its modes than white noise: "
            f"it is driven on, or not linear"
        )
    return None
