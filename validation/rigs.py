"""Files of rigs that are not quite linear, from a simulator of its own, and what the first command says of them.

One or two masses on springs and dampers, with friction against the ground, dampers that differ in compression and
rebound, or springs that stiffen. Motion is integrated to 1e-9 between events; an event is a mass that stops or breaks
loose. A record has what a test bench leaves in a file: rest, a pull and a held force before the release, an encoder's
steps, a dead stop, stamps of a drifting or rounded clock.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from tabulate import tabulate

from suspid import Analysis, SuspidError, analyse
from suspid.units import RealArray, Second
from suspid.words import Level

# Seeds that were not used during development.
FIRST_SEED = 910_000
# Share of the speed and of the friction below which a mass is at rest: event after event at one time is rounding.
SLACK = 1e-9
# Turns that near to the ends of a stretch are within it [s]: some samples.
LATE = 0.005
KINDS = ("friction", "bilinear", "cubic")


@dataclass(frozen=True, kw_only=True)
class Rig:
    """A chain of masses above the ground.

    Parameters
    ----------
    mass, stiffness, damping : ndarray (mass,)
        From the ground up: masses [kg], springs [N/m] and dampers [N s/m] below them.
    friction : ndarray (mass,)
        Friction of each mass against the ground [N].
    cubic : ndarray (mass,)
        Force of each spring ``k u (1 + cubic u^2)`` at travel ``u`` [1/m2].
    rebound : float
        Damping while a spring lengthens over that while it shortens [1]; the mean of both is ``damping``.
    """

    mass: RealArray
    stiffness: RealArray
    damping: RealArray
    friction: RealArray
    cubic: RealArray
    rebound: float = 1.0

    @cached_property
    def links(self) -> RealArray:
        """Travel of each spring from the positions, (spring, mass)."""
        return np.asarray(np.eye(len(self.mass)) - np.eye(len(self.mass), k=-1))

    @cached_property
    def wn(self) -> RealArray:
        """Natural frequencies at small amplitudes, without damping and friction [rad/s], ascending."""
        stiff = self.links.T @ np.diag(self.stiffness) @ self.links / self.mass[:, None]
        return np.asarray(np.sqrt(np.sort(np.linalg.eigvals(stiff).real)))

    def force(self, position: RealArray, velocity: RealArray) -> RealArray:
        """Return what springs and dampers exert on each mass [N]."""
        travel, speed = self.links @ position, self.links @ velocity
        share = np.where(speed > 0, self.rebound, 1.0) * 2 / (1 + self.rebound)
        return -self.links.T @ (self.stiffness * travel * (1 + self.cubic * travel**2) + self.damping * share * speed)


@dataclass(frozen=True, kw_only=True)
class Motion:
    """Positions after a release from rest, (mass, sample), turns (time and position of each) and the dead stop [s]."""

    position: RealArray
    turns: tuple[RealArray, ...]
    stop: Second


def released(rig: Rig, position: RealArray, timepts: RealArray) -> Motion:
    """Integrate the motion after a release from rest at given times, ascending from 0."""
    from scipy.integrate import solve_ivp

    count, now, end = len(rig.mass), 0.0, float(timepts[-1])
    state = np.concatenate([position, np.zeros(count)])
    force = rig.force(position, np.zeros(count))
    signs = np.where(np.abs(force) > rig.friction, np.sign(force), 0.0)
    out = np.tile(np.asarray(position, float)[:, None], len(timepts))
    # A mass that has just broken loose is not yet at rest again.
    still = SLACK * float(np.max(np.abs(position)) * rig.wn[-1])
    turns: list[list[tuple[float, float]]] = [[(0.0, float(x))] for x in position]
    while now < end and np.any(signs):
        moving = signs != 0

        def slope(_: float, s: RealArray, signs: RealArray = signs, moving: Any = moving) -> RealArray:
            push = (rig.force(s[:count], s[count:]) - rig.friction * signs) / rig.mass
            return np.concatenate([s[count:] * moving, push * moving])

        def event(mass: int, sign: float) -> Callable[[float, RealArray], float]:
            if sign:
                return lambda _, s: float(s[count + mass] * sign) + still
            return lambda _, s: float((1 + SLACK) * rig.friction[mass] - abs(rig.force(s[:count], s[count:])[mass]))

        events = [event(mass, sign) for mass, sign in enumerate(signs)]
        for each in events:
            each.terminal, each.direction = True, -1  # type: ignore[attr-defined]
        solved: Any = solve_ivp(
            slope, (now, end), state, method="DOP853", rtol=1e-9, atol=1e-12, events=events, dense_output=True
        )
        seen = (timepts > now) & (timepts <= solved.t[-1])
        if np.any(seen):
            out[:, seen] = solved.sol(timepts[seen])[:count]
        now, state = float(solved.t[-1]), solved.y[:, -1]
        out[:, timepts > now] = state[:count, None]
        hit = next((k for k, times in enumerate(solved.t_events) if len(times)), None)
        if hit is None:
            break
        state[count + hit] = 0.0
        turns[hit].append((now, float(state[hit])))
        force = rig.force(state[:count], state[count:])
        signs = signs.copy()
        loose = signs[hit] == 0 or abs(force[hit]) > rig.friction[hit]
        signs[hit] = np.sign(force[hit]) if loose else 0.0
    stop = np.inf if np.any(signs) else now
    return Motion(position=out, turns=tuple(np.array(each) for each in turns), stop=stop)


@dataclass(frozen=True, kw_only=True)
class Release:
    """A record of a release and its truth, by the clock of the file; ``position`` is what it holds, (mass, sample)."""

    rig: Rig
    pace: float  # of the clock
    stamps: RealArray
    position: RealArray
    turns: tuple[RealArray, ...]
    start: Second
    stop: Second
    step: float


def random_rig(kind: str, masses: int, rng: np.random.Generator) -> tuple[Rig, RealArray]:
    """Return a rig of a kind and where it is held before the release [m]."""
    cycles, seconds = rng.uniform(4, 14), rng.uniform(0.6, 2.0)
    first = 2 * np.pi * cycles / seconds
    mass, stiffness = rng.uniform(0.5, 3.0, masses), rng.uniform(0.5, 2.0, masses)
    none = np.zeros(masses)
    rig = Rig(mass=mass, stiffness=stiffness, damping=none, friction=none, cubic=none)
    stiffness = stiffness * float(first / rig.wn[0]) ** 2
    held = np.cumsum(rng.uniform(0.005, 0.03, masses)) * rng.choice([-1, 1])
    rig = replace(rig, stiffness=stiffness, damping=2 * rng.uniform(0.003, 0.02, masses) * stiffness / first)
    travel = rig.links @ held
    if kind == "friction":
        force = np.max(np.abs(rig.force(held, none)))
        rig = replace(rig, friction=rng.uniform(0.01, 0.1) * force * rng.uniform(0.5, 1.0, masses))
    elif kind == "cubic":
        rig = replace(rig, cubic=rng.uniform(0.05, 0.2) / np.max(np.abs(travel)) ** 2 * np.ones(masses))
    elif kind == "bilinear":
        rig = replace(rig, rebound=float(rng.choice([3.0, 1 / 3])), damping=2 * rig.damping)
    return rig, np.asarray(held)


def release(kind: str, masses: int, *, seed: int) -> Release:
    """Return a random record: rest, in half of the records a pull, a held force, release, dead stop.

    The rate is 100 to 1000 Hz (at least ten samples in a period of the fastest mode), encoders have 8 to 12 bits over
    1.1 to 2 times the swing, and the clock is exact, off by up to 0.1 %, or rounded to milliseconds.
    """
    rng = np.random.default_rng([seed, masses, KINDS.index(kind)])
    rig, held = random_rig(kind, masses, rng)
    rate = float(np.exp(rng.uniform(np.log(max(100.0, 10 * rig.wn[-1] / (2 * np.pi))), np.log(1000.0))))
    before, after = rng.uniform(0.2, 1.0), rng.uniform(0.5, 2.0) + rng.uniform(0.0, 1.0)
    time = np.arange(int(rate * (before + after))) / rate
    moved = released(rig, held, np.concatenate([[0.0], time[time > before] - before]))
    level = np.ones(int(np.sum(time <= before)))
    if rng.uniform() < 0.5:
        level = np.clip((time[time <= before] / before - 0.2) / 0.4, 0.0, 1.0)
    position = np.concatenate([held[:, None] * level, moved.position[:, 1:]], axis=1)
    bits = int(rng.integers(8, 13))
    step = rng.uniform(1.1, 2.0) * 2 * float(np.max(np.abs(position))) / 2**bits
    position = step * np.round(position / step + rng.uniform(-0.5, 0.5, (masses, 1)))
    clock = rng.integers(3)
    pace = 1 + rng.uniform(-1e-3, 1e-3) if clock == 1 else 1.0
    stamps = np.round(time, 3) if clock == 2 else pace * time
    return Release(
        rig=rig,
        pace=pace,
        stamps=np.asarray(stamps),
        position=np.asarray(position),
        turns=tuple(np.column_stack([pace * (each[:, 0] + before), each[:, 1]]) for each in moved.turns),
        start=float(pace * before),
        stop=float(pace * (before + moved.stop)),
        step=step,
    )


def write(record: Release, path: Path) -> None:
    """Write a record as a text file: a header, stamps with 6 digits after the point, positions with 9."""
    names = ["time [s]", *(f"x{k + 1} [m]" for k in range(len(record.position)))]
    np.savetxt(
        path,
        np.column_stack([record.stamps, record.position.T]),
        fmt=["%.6f", *["%.9f"] * len(record.position)],
        delimiter=",",
        header=",".join(names),
        comments="",
    )


def equivalent(record: Release, start: Second, stop: Second) -> tuple[RealArray, RealArray, RealArray]:
    """Return amplitude, natural frequency [rad/s] and damping ratio of each cycle of one mass within a stretch.

    A cycle lasts from a turn to the next but one; its damping ratio is that of a linear decay between the two, its
    amplitude half the way from turn to turn. Of an equal pair of turns (a dead stop) none is used.
    """
    time, x = record.turns[0].T
    inside = (time >= start - LATE) & (time <= stop + LATE)
    time, x = time[inside], x[inside]
    swing = 0.5 * np.abs(np.diff(x))
    first, last = swing[:-2], swing[2:]
    if not len(first):
        return np.empty(0), np.empty(0), np.empty(0)
    ratio = np.log(first / last) / (2 * np.pi)
    zeta = ratio / np.sqrt(1 + ratio**2)
    wn = 2 * np.pi / (time[2:-1] - time[:-3]) / np.sqrt(1 - zeta**2)
    return np.sqrt(first * last), wn, zeta


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What the first command says of one file, beside the truth.

    The truth of one mass is the mean over the cycles of the stretch that was used; of two masses, the frequencies
    without friction and damping, if the springs are linear.
    """

    right: bool  # as many modes as masses
    wn: float = np.nan  # largest error of a natural frequency, as a share
    zeta: float = np.nan  # error of the damping ratio, as a share
    sds: tuple[float, float] = (np.nan, np.nan)  # both in standard deviations
    level: Level = Level.NONE


def outcome(kind: str, masses: int, seed: int) -> Outcome:
    """Write a record as a file, analyse it without any setting, and compare with the truth."""
    record = release(kind, masses, seed=seed)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "release.csv"
        write(record, path)
        try:
            found = analyse(path)
        except SuspidError:
            return Outcome(right=False)
    return judged(record, found)


def judged(record: Release, found: Analysis) -> Outcome:
    """Return how far the modes of an analysis are off."""
    truth, modes, level = record.rig.wn / record.pace, found.modes, found.verdict.level
    right = len(modes) == len(truth)
    if not len(modes) or modes.wn_std is None or modes.zeta_std is None:
        return Outcome(right=right, level=level)
    if len(truth) == 1:
        used = found.identification.response.time
        _, wn, zeta = equivalent(record, float(used[0]), min(float(used[-1]), record.stop))
        if not len(wn):
            return Outcome(right=right, level=level)
        mean = np.array([np.mean(wn), np.mean(zeta)])
        k = int(np.argmin(np.abs(modes.wn - mean[0])))
        off = np.array([modes.wn[k], modes.zeta[k]]) - mean
        sds = off / np.array([modes.wn_std[k], modes.zeta_std[k]])
        shares = off / mean
        return Outcome(right=right, wn=shares[0], zeta=shares[1], sds=(sds[0], sds[1]), level=level)
    if not right or np.any(record.rig.cubic > 0):
        return Outcome(right=right, level=level)
    off = modes.wn - truth
    worst = int(np.argmax(np.abs(off / truth)))
    return Outcome(
        right=right,
        wn=float(off[worst] / truth[worst]),
        sds=(float(np.max(np.abs(off) / modes.wn_std)), np.nan),
        level=level,
    )


def report(*, seeds: int = 100) -> str:
    """Return the report as markdown."""
    rows = []
    with ProcessPoolExecutor(max_workers=2) as pool:
        for masses in (1, 2):
            for kind in KINDS:
                order = range(FIRST_SEED, FIRST_SEED + seeds)
                found = list(pool.map(outcome, [kind] * seeds, [masses] * seeds, order, chunksize=5))
                rows.append([f"{masses}, {kind}", str(seeds), *_shares(found)])
    headers = [
        "masses, kind", "records", "right number of modes", "wn within 1 %", "zeta within 15 %",
        "wn within 95 % interval", "zeta within 95 % interval", "sound and beyond 4 sd",
    ]  # fmt: skip
    return (
        "\n\n".join(
            [
                "# Rigs that are not quite linear",
                f"Random rigs from their files, seeds {FIRST_SEED} and on, `analyse` without any setting. Friction 1 "
                f"to 10 % of the first spring force; dampers 1:3; springs 5 to 20 % stiffer at the first peak. Errors "
                f"are those of records with a mode to compare, against means over the cycles of the stretch "
                f"that was used (one mass) or the linear frequencies (two masses).",
                tabulate(rows, headers=headers, tablefmt="github", disable_numparse=True),
            ]
        )
        + "\n"
    )


def _shares(found: Sequence[Outcome]) -> list[str]:
    """Return the columns of a row: shares of the records to which each applies."""
    wn, zeta = (np.array([getattr(one, name) for one in found]) for name in ("wn", "zeta"))
    sds = np.abs([one.sds for one in found])
    wrong = [one.level is Level.SOUND and bool(np.nanmax([*map(abs, one.sds), 0.0]) > 4) for one in found]

    def share(held: NDArray[np.bool_], known: RealArray) -> str:
        return f"{100 * np.mean(held[~np.isnan(known)]):.0f} %" if not np.all(np.isnan(known)) else "-"

    return [
        f"{100 * np.mean([one.right for one in found]):.0f} %",
        share(np.abs(wn) < 0.01, wn),
        share(np.abs(zeta) < 0.15, zeta),
        share(sds[:, 0] < 1.96, sds[:, 0]),
        share(sds[:, 1] < 1.96, sds[:, 1]),
        f"{100 * np.mean(wrong):.0f} %",
    ]


if __name__ == "__main__":
    print(report())
