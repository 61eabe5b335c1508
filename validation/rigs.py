"""Files of rigs that are not quite linear, from a simulator of its own, and what the first command says of them.

One or two masses on springs and dampers, with friction against the ground or in the struts, dampers that differ in
compression and rebound, or springs that stiffen. Motion is integrated to 1e-9 between events; an event is a contact
that sticks or breaks loose. A record has what a test bench leaves in a file: rest, a pull and a held force before the
release, an encoder's steps, a dead stop, stamps of a drifting or rounded clock.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
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
# A turn is the end of a stretch that misses it by less than this share of a swing: stretches end at turns, or at a dead
# stop.
LATE = 0.1
# Files of each kind and number of masses.
SEEDS = int(os.environ.get("SUSPID_SEEDS", "100"))
KINDS = ("friction", "bilinear", "cubic")
# Friction where the springs are: only of several masses another thing than against the ground.
IN_STRUTS = "friction in the struts"
# The same from accelerometers.
FELT = "friction in the struts, accelerometers"
# Against the ground, from sensors with white noise in place of the steps of an encoder: nothing rests in it.
NOISY = "friction, noise"
# Those of one mass and of two, and in the order in which each has seeds of its own.
OF_ONE, OF_TWO, SEEDED = (*KINDS, NOISY), (*KINDS, NOISY, IN_STRUTS, FELT), (*KINDS, IN_STRUTS, FELT, NOISY)
# Friction that stops both masses within a cycle or two leaves little to find: those that move for this long [s] have a
# row of their own.
MOVES_FOR = 0.5
# Samples of the exact motion in a period of the fastest mode: a sum over them is an integral to 1e-4.
FINE = 60
# Cycles over which means are taken begin this often in each: means do not jump where one more has room.
PER_CYCLE = 8


@dataclass(frozen=True, kw_only=True)
class Rig:
    """A chain of masses above the ground.

    Parameters
    ----------
    mass, stiffness, damping : ndarray (mass,)
        From the ground up: masses [kg], springs [N/m] and dampers [N s/m] below them.
    friction : ndarray (contact,)
        Friction of each contact [N].
    cubic : ndarray (mass,)
        Force of each spring ``k u (1 + cubic u^2)`` at travel ``u`` [1/m2].
    rebound : float
        Damping while a spring lengthens over that while it shortens [1]; the mean of both is ``damping``.
    struts : bool
        Whether friction is in the struts, beside springs and dampers, and not of each mass against the ground.
    """

    mass: RealArray
    stiffness: RealArray
    damping: RealArray
    friction: RealArray
    cubic: RealArray
    rebound: float = 1.0
    struts: bool = False

    @cached_property
    def links(self) -> RealArray:
        """Travel of each spring from the positions, (spring, mass)."""
        return np.asarray(np.eye(len(self.mass)) - np.eye(len(self.mass), k=-1))

    @cached_property
    def contacts(self) -> RealArray:
        """Travel of each contact from the positions, (contact, mass)."""
        return self.links if self.struts else np.eye(len(self.mass))

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

    def friction_of(self, force: RealArray, signs: RealArray) -> RealArray:
        """Return the friction of each contact [N] under forces on the masses: those that stick (0) take what they must.

        ``signs`` are the directions in which contacts slide.
        """
        sticks, inverse = signs == 0, self.contacts / self.mass
        push = inverse @ (force - self.contacts.T @ (self.friction * signs))
        held = np.zeros(len(signs))
        if np.any(sticks):
            held[sticks] = np.linalg.solve((inverse @ self.contacts.T)[np.ix_(sticks, sticks)], push[sticks])
        return np.asarray(np.where(sticks, held, self.friction * signs))


@dataclass(frozen=True, kw_only=True)
class Motion:
    """Motion after a release from rest, (mass, sample), turns (time and position of each) and the dead stop [s].

    ``stuck`` is since when the first contact sticks that does not slide again [s].
    """

    time: RealArray
    position: RealArray
    velocity: RealArray
    turns: tuple[RealArray, ...]
    stop: Second
    stuck: Second


def released(rig: Rig, position: RealArray, timepts: RealArray) -> Motion:
    """Integrate the motion after a release from rest at given times, ascending from 0."""
    from scipy.integrate import solve_ivp

    count, now, end = len(rig.mass), 0.0, float(timepts[-1])
    state = np.concatenate([position, np.zeros(count)])
    signs = _sliding(rig, state, np.zeros(len(rig.friction)))
    out = np.tile(state[:, None], len(timepts))
    # A contact that has just broken loose does not yet stick again.
    still = SLACK * float(np.max(np.abs(position)) * rig.wn[-1])
    turns: list[list[tuple[float, float]]] = [[(0.0, float(x))] for x in position]
    since = np.where(signs == 0, 0.0, np.inf)
    while now < end and np.any(signs):

        def slope(_: float, s: RealArray, signs: RealArray = signs) -> RealArray:
            force = rig.force(s[:count], s[count:])
            return np.concatenate([s[count:], (force - rig.contacts.T @ rig.friction_of(force, signs)) / rig.mass])

        def event(contact: int, signs: RealArray = signs) -> Callable[[float, RealArray], float]:
            sign, most = signs[contact], (1 + SLACK) * rig.friction[contact]
            if sign:
                return lambda _, s: float(rig.contacts[contact] @ s[count:] * sign) + still
            return lambda _, s: float(most - abs(rig.friction_of(rig.force(s[:count], s[count:]), signs)[contact]))

        events = [event(contact) for contact in range(len(signs))]
        for each in events:
            each.terminal, each.direction = True, -1  # type: ignore[attr-defined]
        solved: Any = solve_ivp(
            slope, (now, end), state, method="DOP853", rtol=1e-9, atol=1e-12, events=events, dense_output=True
        )
        seen = (timepts > now) & (timepts <= solved.t[-1])
        if np.any(seen):
            out[:, seen] = solved.sol(timepts[seen])
        now, state = float(solved.t[-1]), solved.y[:, -1]
        hit = next((k for k, times in enumerate(solved.t_events) if len(times)), None)
        if hit is None:
            break
        if not rig.struts:
            turns[hit].append((now, float(state[hit])))
        # What stops sliding sticks where friction holds it, and slides the other way where not.
        stops = signs[hit] != 0
        signs = np.where(np.arange(len(signs)) == hit, 0.0, signs)
        if stops:
            state[count:] = _sticking(rig, state[count:], signs == 0)
        signs = _sliding(rig, state, signs)
        since = np.where(signs == 0, np.minimum(since, now), np.inf)
        out[:count, timepts > now], out[count:, timepts > now] = state[:count, None], 0.0
    stop = np.inf if np.any(signs) else now
    return Motion(
        time=timepts,
        position=out[:count],
        velocity=out[count:],
        turns=tuple(np.array(each) for each in turns),
        stop=stop,
        stuck=float(np.min(since)),
    )


def accelerations(rig: Rig, motion: Motion) -> RealArray:
    """Return what accelerometers on the masses feel of a motion, (mass, sample)."""
    travel = rig.contacts @ motion.velocity
    still = SLACK * np.max(np.abs(travel), initial=0.0)
    out = np.empty_like(motion.position)
    for k, (position, velocity) in enumerate(zip(motion.position.T, motion.velocity.T, strict=True)):
        force = rig.force(position, velocity)
        signs = np.where(np.abs(travel[:, k]) > still, np.sign(travel[:, k]), 0.0)
        out[:, k] = (force - rig.contacts.T @ rig.friction_of(force, signs)) / rig.mass
    return out


def _sliding(rig: Rig, state: RealArray, signs: RealArray) -> RealArray:
    """Return in which directions contacts slide: those that stick beyond their friction are let go, the worst first."""
    count, signs = len(rig.mass), signs.copy()
    force = rig.force(state[:count], state[count:])
    while True:
        needed = rig.friction_of(force, signs)
        over = np.where(signs == 0, np.abs(needed) - rig.friction, 0.0)
        worst = int(np.argmax(over))
        if over[worst] <= 0:
            return signs
        signs[worst] = np.sign(needed[worst])


def _sticking(rig: Rig, velocity: RealArray, sticks: NDArray[np.bool_]) -> RealArray:
    """Return velocities after contacts stick, which takes away the speed in them and nothing else: an impulse."""
    rows = rig.contacts[sticks]
    impulse = np.linalg.solve(rows / rig.mass @ rows.T, rows @ velocity)
    return velocity - (rows.T @ impulse) / rig.mass


@dataclass(frozen=True, kw_only=True)
class Release:
    """A record of a release and its truth, by the clock of the file; ``values`` are what it holds, (mass, sample)."""

    rig: Rig
    pace: float  # of the clock
    motion: Motion  # from the release on, by an exact clock, `FINE` samples in a period of the fastest mode
    stamps: RealArray
    values: RealArray
    unit: str
    turns: tuple[RealArray, ...]
    start: Second
    stop: Second
    stuck: Second
    step: float  # below which motion is not seen [m]

    @property
    def moves(self) -> Second:
        """How long it moves; with friction in struts, until one of them sticks for good."""
        return min(self.stuck if self.rig.struts else self.stop, float(self.stamps[-1])) - self.start

    @property
    def late(self) -> Second:
        """By how much a turn may lie outside of a stretch of which it is an end."""
        return LATE * np.pi / float(self.rig.wn[0])


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
    if kind in ("friction", NOISY, IN_STRUTS, FELT):
        force = np.max(np.abs(rig.force(held, none)))
        rig = replace(rig, friction=rng.uniform(0.01, 0.1) * force * rng.uniform(0.5, 1.0, masses))
        if kind in (IN_STRUTS, FELT):
            # Half of them in the upper strut alone, as of a guide without friction.
            rubs = [float(rng.uniform() < 0.5), *[1.0] * (masses - 1)]
            rig = replace(rig, struts=True, friction=rig.friction * rubs)
    elif kind == "cubic":
        rig = replace(rig, cubic=rng.uniform(0.05, 0.2) / np.max(np.abs(travel)) ** 2 * np.ones(masses))
    elif kind == "bilinear":
        rig = replace(rig, rebound=float(rng.choice([3.0, 1 / 3])), damping=2 * rig.damping)
    return rig, np.asarray(held)


def release(
    kind: str, masses: int, *, seed: int, first: Release | None = None, test: int = 0, damping: float = 1.0
) -> Release:
    """Return a random record: rest, in half of the records a pull, a held force, release, dead stop.

    The rate is 100 to 1000 Hz (at least ten samples in a period of the fastest mode), encoders have 8 to 12 bits over
    1.1 to 2 times the swing, and the clock is exact, off by up to 0.1 %, or rounded to milliseconds. Accelerometers are
    sampled three times as fast; their noise is 0.1 to 1.5 % of the largest value, as that of other noisy sensors, their
    offset up to 5 % of it. Another ``test`` than the ``first`` is of the same rig, let go from 0.5 to 1 of the way, by
    the same clock; its dampers and friction may be others by a factor.
    """
    rng = np.random.default_rng([seed, masses, SEEDED.index(kind)])
    rig, held = random_rig(kind, masses, rng)
    rate = float(np.exp(rng.uniform(np.log(max(100.0, 10 * rig.wn[-1] / (2 * np.pi))), np.log(1000.0))))
    rate *= 3 if kind == FELT else 1
    if first is not None:
        rng = np.random.default_rng([seed, masses, SEEDED.index(kind), test])
        held = held * rng.uniform(0.5, 1.0)
        rig = replace(rig, damping=damping * rig.damping, friction=damping * rig.friction)
    before, after = rng.uniform(0.2, 1.0), rng.uniform(0.5, 2.0) + rng.uniform(0.0, 1.0)
    time = np.arange(int(rate * (before + after))) / rate
    moved = released(rig, held, np.concatenate([[0.0], time[time > before] - before]))
    level = np.ones(int(np.sum(time <= before)))
    if rng.uniform() < 0.5:
        level = np.clip((time[time <= before] / before - 0.2) / 0.4, 0.0, 1.0)
    fine = released(rig, held, np.arange(0.0, after, 2 * np.pi / rig.wn[-1] / FINE))
    if kind == FELT:
        felt = accelerations(rig, moved)[:, 1:]
        values = np.concatenate([np.zeros((masses, len(level))), felt], axis=1)
        largest = np.max(np.abs(values), axis=1, keepdims=True)
        noise = 10 ** rng.uniform(-3.0, -1.8) * largest
        values += noise * rng.standard_normal(values.shape) + rng.uniform(-0.05, 0.05, (masses, 1)) * largest
        step = float(np.min(noise)) / float(rig.wn[-1]) ** 2
    else:
        values = np.concatenate([held[:, None] * level, moved.position[:, 1:]], axis=1)
        if kind == NOISY:
            step = 10 ** rng.uniform(-3.0, -1.8) * float(np.max(np.abs(values)))
            values += step * rng.standard_normal(values.shape)
        else:
            bits = int(rng.integers(8, 13))
            step = rng.uniform(1.1, 2.0) * 2 * float(np.max(np.abs(values))) / 2**bits
            values = step * np.round(values / step + rng.uniform(-0.5, 0.5, (masses, 1)))
    clock = int(rng.integers(3))
    pace = 1 + rng.uniform(-1e-3, 1e-3) if clock == 1 else 1.0
    if first is not None:
        clock, pace = 1, first.pace
    stamps = np.round(time, 3) if clock == 2 else pace * time
    return Release(
        rig=rig,
        pace=pace,
        motion=fine,
        stamps=np.asarray(stamps),
        values=np.asarray(values),
        unit="m/s^2" if kind == FELT else "m",
        turns=tuple(np.column_stack([pace * (each[:, 0] + before), each[:, 1]]) for each in moved.turns),
        start=float(pace * before),
        stop=float(pace * (before + moved.stop)),
        stuck=float(pace * (before + moved.stuck)),
        step=step,
    )


def write(record: Release, path: Path) -> None:
    """Write a record as a text file: a header, stamps with 6 digits after the point, values with 9."""
    names = ["time [s]", *(f"x{k + 1} [{record.unit}]" for k in range(len(record.values)))]
    np.savetxt(
        path,
        np.column_stack([record.stamps, record.values.T]),
        fmt=["%.6f", *["%.9f"] * len(record.values)],
        delimiter=",",
        header=",".join(names),
        comments="",
    )


def equivalent(record: Release, start: Second, stop: Second) -> tuple[RealArray, RealArray, RealArray]:
    """Return amplitude, natural frequency [rad/s] and damping ratio of each cycle of one mass within a stretch.

    A cycle lasts from the middle of a swing, between two turns, to that of the next but one; its damping ratio is that
    of a linear decay between the two, its amplitude half the way from turn to turn. Of an equal pair of turns (a dead
    stop) none is used.
    """
    time, x = record.turns[0].T
    inside = (time >= start - record.late) & (time <= stop + record.late)
    time, x = time[inside], x[inside]
    swing = 0.5 * np.abs(np.diff(x))
    first, last = swing[:-2], swing[2:]
    if not len(first):
        return np.empty(0), np.empty(0), np.empty(0)
    ratio = np.log(first / last) / (2 * np.pi)
    zeta = ratio / np.sqrt(1 + ratio**2)
    middle = 0.5 * (time[:-1] + time[1:])
    wn = 2 * np.pi / (middle[2:] - middle[:-2]) / np.sqrt(1 - zeta**2)
    return np.sqrt(first * last), wn, zeta


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What the first command says of one file, beside the truth.

    The truth is the mean over the cycles of the stretch that was used; of one mass that depends on its amplitude, over
    those of the swings for which the result states it.
    """

    right: bool  # as many modes as masses
    wn: float = np.nan  # largest error of a natural frequency, as a share
    zeta: float = np.nan  # largest error of a damping ratio, as a share
    sds: tuple[float, float] = (np.nan, np.nan)  # largest errors of both in standard deviations
    within: tuple[float, float] = (np.nan, np.nan)  # shares of the modes within 1.96 of them
    level: Level = Level.NONE
    moves: Second = 0.0  # how long the record moves


def equivalent_modes(
    rig: Rig, moved: Motion, start: Second, stop: Second, *, seen: float
) -> tuple[RealArray, RealArray]:
    """Return natural frequencies [rad/s] and damping ratios of several masses: means over cycles of the slowest mode.

    In each cycle friction is replaced by dampers, and what is cubic in springs by springs, as it is for two tones that
    keep no phase with each other (describing functions); what a bilinear damper has beyond its mean does no work over a
    cycle. Cycles begin `PER_CYCLE` times in each. Friction changes no natural frequency. A mode counts where it moves a
    mass by more than ``seen`` [m].
    """
    mass, count = np.diag(rig.mass), len(rig.mass)
    stiff = rig.links.T @ np.diag(rig.stiffness) @ rig.links
    damp = rig.links.T @ np.diag(rig.damping) @ rig.links
    values, shapes = np.linalg.eig(np.linalg.solve(mass, stiff))
    order = np.argsort(values)
    wn, shapes = np.sqrt(values[order].real), shapes[:, order]
    shapes = shapes / np.sqrt(np.sum(shapes * (mass @ shapes), axis=0))
    stiffness, damping = shapes.T @ stiff @ shapes, shapes.T @ damp @ shapes
    q, p = shapes.T @ mass @ moved.position, shapes.T @ mass @ moved.velocity
    sizes = np.sqrt(q**2 + (p / wn[:, None]) ** 2)
    inside = np.flatnonzero((moved.time >= start) & (moved.time <= stop))
    cycle = 2 * np.pi / float(rig.wn[0])
    of_cycle = min(len(inside), round(cycle / float(moved.time[1] - moved.time[0])))
    parts = np.lib.stride_tricks.sliding_window_view(inside, of_cycle)
    found, weights = [], []
    for part in parts[np.linspace(0, len(parts) - 1, 1 + PER_CYCLE * len(parts) // of_cycle).astype(int)]:
        size = np.sqrt(np.mean(sizes[:, part] ** 2, axis=1))
        travel, speed = np.abs(rig.links @ shapes) * size, np.abs(rig.contacts @ shapes) * size * wn
        springs = np.array([1.5 * np.sum(travel**2, axis=1) - 0.75 * travel[:, k] ** 2 for k in range(count)]).T
        springs = rig.links.T @ ((rig.stiffness * rig.cubic)[:, None] * springs * (rig.links @ shapes))
        others = np.sqrt(np.maximum(np.sum(speed**2, axis=1, keepdims=True) - speed**2, 0.0))
        dampers = rig.friction[:, None] * _friction_of_tone(speed, others) * (rig.contacts @ shapes)
        without = _poles(stiffness + shapes.T @ springs, damping)
        poles = _poles(stiffness + shapes.T @ springs, damping + shapes.T @ rig.contacts.T @ dampers)
        if len(poles) == count:
            found.append([np.abs(without), -poles.real / np.abs(poles)])
            weights.append(size * np.max(np.abs(shapes), axis=0) > seen)
    weight = np.array(weights, float)
    weight[:, ~np.any(weight, axis=0)] = 1.0
    mean_wn, zeta = np.sum(weight[:, None] * np.array(found), axis=0) / np.sum(weight, axis=0)
    return mean_wn, zeta


def _friction_of_tone(speed: RealArray, others: RealArray) -> RealArray:
    """Return the damper that a friction of 1 is to a tone of a speed, beside another: a mean over the other's phase."""
    phase = np.cos(np.pi * (np.arange(4000) + 0.5) / 4000)
    width = np.sqrt(np.clip(1 - (others[..., None] * phase / speed[..., None]) ** 2, 0.0, None))
    return np.asarray(4 / np.pi / speed * np.mean(width, axis=-1))


def _poles(stiffness: RealArray, damping: RealArray) -> NDArray[np.complex128]:
    """Return the poles of ``q'' + damping q' + stiffness q = 0`` in the upper half plane, ascending in modulus."""
    count = len(stiffness)
    poles = np.linalg.eigvals(np.block([[np.zeros((count, count)), np.eye(count)], [-stiffness, -damping]]))
    poles = poles[poles.imag > 0]
    return np.asarray(poles[np.argsort(np.abs(poles))])


def outcome(kind: str, masses: int, seed: int) -> Outcome:
    """Write a record as a file, analyse it without any setting, and compare with the truth."""
    record = release(kind, masses, seed=seed)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "release.csv"
        write(record, path)
        try:
            found = analyse(path)
        except SuspidError:
            return Outcome(right=False, moves=record.moves)
    return replace(judged(record, found), moves=record.moves)


def judged(record: Release, found: Analysis) -> Outcome:
    """Return how far the modes of an analysis are off."""
    truth, modes, level = record.rig.wn / record.pace, found.modes, found.verdict.level
    right = len(modes) == len(truth)
    if not len(modes) or modes.wn_std is None or modes.zeta_std is None or (len(truth) > 1 and not right):
        return Outcome(right=right, level=level)
    used = found.identification.response.time
    start, stop = float(used[0]), min(float(used[-1]), record.stop)
    if len(truth) == 1:
        # From the first turn of the result to its last: it states the middles of the first and of the last swing.
        for each in found.identification.amplitude_dependence:
            quarter = np.pi / 2 / float(record.rig.wn[0])
            start, stop = each.spans[0][0] - quarter, each.spans[-1][1] + quarter
        _, by_cycle, zetas = equivalent(record, start, stop)
        if not len(by_cycle):
            return Outcome(right=right, level=level)
        wn, zeta = np.array([np.mean(by_cycle)]), np.array([np.mean(zetas)])
        kept = [int(np.argmin(np.abs(modes.wn - wn)))]
    else:
        moved = record.motion
        wn, zeta = equivalent_modes(
            record.rig, moved, (start - record.late - record.start) / record.pace,
            (stop + record.late - record.start) / record.pace, seen=record.step,
        )  # fmt: skip
        wn, kept = wn / record.pace, list(range(len(truth)))
    off = np.array([modes.wn[kept] - wn, modes.zeta[kept] - zeta])
    shares = off / np.array([wn, zeta])
    sds = off / np.array([modes.wn_std[kept], modes.zeta_std[kept]])
    worst = np.argmax(np.abs(shares), axis=1)
    inside = np.mean(np.abs(sds) < 1.96, axis=1)
    most = np.max(np.abs(sds), axis=1)
    return Outcome(
        right=right,
        wn=float(shares[0, worst[0]]),
        zeta=float(shares[1, worst[1]]),
        sds=(float(most[0]), float(most[1])),
        within=(float(inside[0]), float(inside[1])),
        level=level,
    )


def report(*, seeds: int = SEEDS) -> str:
    """Return the report as markdown; ``SUSPID_SEEDS=40 python -m validation rigs`` writes it of 40 files a row."""
    rows = []
    with ProcessPoolExecutor(max_workers=2) as pool:
        for masses in (1, 2):
            for kind in OF_ONE if masses == 1 else OF_TWO:
                found = _outcomes(pool, kind, masses, FIRST_SEED, seeds)
                rows.append(_shown([f"{masses}, {kind}", str(seeds), *_shares(found)]))
                if kind == "friction":
                    first, long = FIRST_SEED, _moving(found)
                    while len(long) < seeds:
                        first += seeds
                        long += _moving(_outcomes(pool, kind, masses, first, seeds))
                    rows.append(
                        _shown([f"{masses}, {kind}, {MOVES_FOR} s or more", str(seeds), *_shares(long[:seeds])])
                    )
    headers = [
        "masses, kind", "records", "right number of modes", "wn within 1 %", "zeta within 15 %",
        "wn within 95 % interval", "zeta within 95 % interval", "sound and beyond 4 sd",
    ]  # fmt: skip
    return (
        "\n\n".join(
            [
                "# Rigs that are not quite linear",
                f"Random rigs from their files, seeds {FIRST_SEED} and on, `analyse` without any setting. Friction 1 "
                f"to 10 % of the first spring force, against the ground or in the struts (in half of the latter only "
                f"in the upper one), there from encoders or accelerometers, elsewhere from encoders or sensors with "
                f"white noise; dampers 1:3; springs 5 to 20 % stiffer at the first peak. Errors are those of records "
                f"with modes to compare (of two masses: with both), the larger of the modes, against means over the "
                f"cycles that the result is of: from turn to turn (one mass) or of the equivalent linear system (two "
                f"masses). Intervals are counted by mode. Friction may stop masses, or lock a strut, within some "
                f"cycles: against the ground, the first {seeds} that move "
                f"for {MOVES_FOR} s or more have a row of their own.",
                tabulate(rows, headers=headers, tablefmt="github", disable_numparse=True),
            ]
        )
        + "\n"
    )


def _shown(row: list[str]) -> list[str]:
    """Print a row as soon as it is known: all of them take long."""
    print("  ".join(row), file=sys.stderr, flush=True)
    return row


def _outcomes(pool: Executor, kind: str, masses: int, first: int, seeds: int) -> list[Outcome]:
    """Return the outcomes of as many seeds from a first one on."""
    order = range(first, first + seeds)
    return list(pool.map(outcome, [kind] * seeds, [masses] * seeds, order, chunksize=5))


def _moving(found: Sequence[Outcome]) -> list[Outcome]:
    """Return the outcomes of records that move for `MOVES_FOR`."""
    return [one for one in found if one.moves >= MOVES_FOR]


def _shares(found: Sequence[Outcome]) -> list[str]:
    """Return the columns of a row: shares of the records to which each applies."""
    wn, zeta = (np.array([getattr(one, name) for one in found]) for name in ("wn", "zeta"))
    within = np.array([one.within for one in found])
    wrong = [one.level is Level.SOUND and bool(np.nanmax([*map(abs, one.sds), 0.0]) > 4) for one in found]

    def share(held: NDArray[np.bool_] | RealArray, known: RealArray) -> str:
        return f"{100 * np.mean(held[~np.isnan(known)]):.0f} %" if not np.all(np.isnan(known)) else "-"

    return [
        f"{100 * np.mean([one.right for one in found]):.0f} %",
        share(np.abs(wn) < 0.01, wn),
        share(np.abs(zeta) < 0.15, zeta),
        share(within[:, 0], within[:, 0]),
        share(within[:, 1], within[:, 1]),
        f"{100 * np.mean(wrong):.0f} %",
    ]


if __name__ == "__main__":
    print(report())
