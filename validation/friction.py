"""Files of rigs with Coulomb friction, from a simulator of its own, and what `find_decays` finds in them.

Between two events the rig is linear and its motion is exact (matrix exponential). An event is a mass that stops or
breaks loose; its time is bisected to rounding. A mass at rest stays there while the force on it is below its friction.
"""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from tabulate import tabulate

from suspid import find_decays, read_record
from suspid.units import Hertz, RealArray, Second

# Seeds that were not used during development.
FIRST_SEED = 730_000
# A start this near to the release is right [s], and a stop this far after the dead stop keeps samples at rest [s].
RIGHT, LATE = 0.05, 0.05


@dataclass(frozen=True, kw_only=True, slots=True)
class Rig:
    """A chain of masses above the ground, each with Coulomb friction against the ground.

    Parameters
    ----------
    mass, stiffness, damping, friction : tuple of float
        From the ground up: masses [kg], springs [N/m] and dampers [N s/m] below them, friction forces [N].
    """

    mass: tuple[float, ...]
    stiffness: tuple[float, ...]
    damping: tuple[float, ...]
    friction: tuple[float, ...]

    def accelerations(self) -> tuple[RealArray, RealArray, RealArray]:
        """Return ``M^-1 S``, ``M^-1 D`` and the friction over the masses."""
        count = len(self.mass)
        links = np.eye(count) - np.eye(count, k=-1)
        inverse = np.diag(1 / np.array(self.mass))
        stiff, damp = (inverse @ links.T @ np.diag(each) @ links for each in (self.stiffness, self.damping))
        return np.asarray(stiff), np.asarray(damp), np.array(self.friction) / np.array(self.mass)

    @property
    def wn(self) -> RealArray:
        """Natural frequencies without damping and friction [rad/s], ascending."""
        return np.asarray(np.sqrt(np.sort(np.linalg.eigvals(self.accelerations()[0]).real)))


def released(rig: Rig, position: RealArray, timepts: RealArray) -> tuple[RealArray, Second]:
    """Return the motion after a release from rest, (mass, time), and when the last mass stops [s].

    Parameters
    ----------
    rig : Rig
        The rig.
    position : ndarray (mass,)
        Positions at the release [m].
    timepts : ndarray (time,)
        Times after the release [s], ascending from 0.
    """
    from scipy.linalg import expm

    stiff, damp, friction = rig.accelerations()
    count, end = len(rig.mass), float(timepts[-1])
    state, now = np.concatenate([position, np.zeros(count)]), 0.0
    force = -stiff @ position
    signs = np.where(np.abs(force) > friction, np.sign(force), 0.0)
    out = np.tile(position[:, None], len(timepts))
    while np.any(signs) and now < end:
        system = _system(stiff, damp, friction, signs)
        step = 0.02 / float(rig.wn[-1])
        event, mass = _next_event(system, state, signs, (stiff, damp, friction), step=step, most=end - now)
        seen = timepts > now
        powers = expm(system * (timepts[seen] - now)[:, None, None])
        out[:, seen] = (powers @ np.append(state, 1.0))[:, :count].T
        state, now = (expm(system * event) @ np.append(state, 1.0))[:-1], now + event
        state[count + mass] = 0.0
        force = -stiff @ state[:count] - damp @ state[count:]
        loose = signs[mass] == 0 or abs(force[mass]) > friction[mass]
        signs = np.where(np.arange(count) == mass, np.sign(force[mass]) * loose, signs)
        out[:, timepts > now] = state[:count, None]
    return out, now if not np.any(signs) else np.inf


def _system(stiff: RealArray, damp: RealArray, friction: RealArray, signs: RealArray) -> RealArray:
    """Return the state matrix while the masses move in given directions or rest (0); the last state is 1."""
    count, moving = len(signs), np.abs(signs)
    system = np.zeros((2 * count + 1, 2 * count + 1))
    system[:count, count:-1] = np.diag(moving)
    system[count:-1, :count] = -stiff * moving[:, None]
    system[count:-1, count:-1] = -damp * moving[:, None]
    system[count:-1, -1] = -friction * signs
    return system


def _next_event(
    system: RealArray,
    state: RealArray,
    signs: RealArray,
    forces: tuple[RealArray, RealArray, RealArray],
    *,
    step: Second,
    most: Second,
) -> tuple[Second, int]:
    """Return after what time a mass stops or breaks loose, or ``most``, and which one."""
    from scipy.linalg import expm

    stiff, damp, friction = forces
    count = len(signs)

    def margins(state: RealArray) -> RealArray:
        """Speed in the direction of motion of each moving mass, friction less force of each mass at rest."""
        force = -stiff @ state[:count] - damp @ state[count : 2 * count]
        return np.asarray(np.where(signs != 0, state[count : 2 * count] * signs, friction - np.abs(force)))

    here, after = np.append(state, 1.0), 0.0
    stepping = expm(system * step)
    while after < most:
        there = stepping @ here
        over = margins(there) < 0
        if np.any(over):

            def least(time: Second, since: RealArray = here) -> float:
                return float(np.min(margins(expm(system * time) @ since)))

            event = _bisected(least, step)
            return after + event, int(np.argmin(margins(expm(system * event) @ here)))
        here, after = there, after + step
    return most, 0


def _bisected(margin: Callable[[Second], float], high: Second) -> Second:
    low = 0.0
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if margin(middle) > 0 else (low, middle)
    return high


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Release:
    """A record of a release, as an encoder sees it.

    Parameters
    ----------
    rig : Rig
        The rig.
    timepts, position : ndarray
        Stamps [s] and positions [m], (sample,) and (mass, sample).
    start, stop : float
        Time of the release and of the dead stop; infinite if it moves to the end [s].
    """

    rig: Rig
    timepts: RealArray
    position: RealArray
    start: Second
    stop: Second


def release(masses: int, bits: int, *, seed: int) -> Release:
    """Return a random record: rest, in half of the records a slow pull, a held force, release, dead stop.

    Friction is 1 to 10 % of the first spring force, the rate 100 to 1000 Hz, the motion 4 to 12 periods of the first
    mode within 0.5 to 2 s, and the range of the encoder 1.1 to 2 times the swing.
    """
    rng = np.random.default_rng(seed)
    first = 2 * np.pi * rng.uniform(4, 12) / rng.uniform(1.0, 2.0)
    mass = tuple(float(m) for m in rng.uniform(0.5, 3.0, masses))
    stiffness = tuple(float(k) for k in rng.uniform(0.5, 2.0, masses))
    soft = Rig(mass=mass, stiffness=stiffness, damping=(0.0,) * masses, friction=(0.0,) * masses)
    scale = float((first / soft.wn[0]) ** 2)
    stiffness = tuple(scale * k for k in stiffness)
    damping = tuple(2 * float(rng.uniform(0.003, 0.02)) * k / first for k in stiffness)
    held = np.asarray(np.cumsum(rng.uniform(0.005, 0.03, masses)) * rng.choice([-1, 1]), float)
    force = np.abs(np.array(soft.mass) * (scale * soft.accelerations()[0] @ held))
    friction = tuple(float(f) for f in rng.uniform(0.01, 0.1) * np.max(force) * rng.uniform(0.5, 1.0, masses))
    rig = Rig(mass=mass, stiffness=stiffness, damping=damping, friction=friction)
    rate: Hertz = float(np.exp(rng.uniform(np.log(max(100.0, 10 * rig.wn[-1] / (2 * np.pi))), np.log(1000.0))))
    before, after = rng.uniform(0.2, 1.0), rng.uniform(1.5, 3.0)
    time = np.asarray(np.arange(int(rate * (before + after))) / rate, float)
    motion, stop = released(rig, held, np.concatenate([[0.0], time[time > before] - before]))
    level = np.ones(int(np.sum(time <= before)))
    if rng.uniform() < 0.5:
        level = np.clip((time[time <= before] / before - 0.2) / 0.4, 0.0, 1.0)
    position = np.concatenate([held[:, None] * level, motion[:, 1:]], axis=1)
    step = rng.uniform(1.1, 2.0) * 2 * np.max(np.abs(position)) / 2**bits
    position = step * np.round(position / step + rng.uniform(-0.5, 0.5, (masses, 1)))
    return Release(rig=rig, timepts=time, position=np.asarray(position), start=float(before), stop=float(before + stop))


def write(record: Release, path: Path) -> None:
    """Write a record as a text file: a header, stamps with 6 digits after the point, positions with 9."""
    names = ["time [s]", *(f"x{k + 1} [m]" for k in range(len(record.position)))]
    rows = [",".join([f"{t:.6f}", *(f"{x:.9f}" for x in column)]) for t, column in zip(
        record.timepts, record.position.T, strict=True
    )]  # fmt: skip
    path.write_text("\n".join([",".join(names), *rows]) + "\n", encoding="utf-8")


def report(*, seeds: int = 25, bits: Sequence[int] = (8, 10, 12)) -> str:
    """Return the report as markdown."""
    rows = [_row(masses, bit, range(FIRST_SEED, FIRST_SEED + seeds)) for masses in (1, 2) for bit in bits]
    headers = [
        "masses, encoder", "records", "none found", "start right", "and without doubts", "dead stop kept",
        "doubts and reasons, most frequent first",
    ]  # fmt: skip
    return "\n\n".join(
        [
            "# Rigs with Coulomb friction",
            f"Random rigs, seeds {FIRST_SEED} and on, from their files: friction 1 to 10 % of the first spring force, "
            f"viscous damping 0.3 to 2 %, 100 to 1000 Hz, rest and held force before the release, dead stop after. "
            f"Right: the best decay starts within {1000 * RIGHT:g} ms of the release. Dead stop kept: it ends more "
            f"than {1000 * LATE:g} ms after the last mass has stopped.",
            tabulate(rows, headers=headers, tablefmt="github", disable_numparse=True),
        ]
    )


def _row(masses: int, bits: int, seeds: Sequence[int]) -> list[str]:
    none = right = sound = kept = 0
    said = Counter[str]()
    with tempfile.TemporaryDirectory() as folder:
        for seed in seeds:
            record, path = release(masses, bits, seed=seed), Path(folder) / "release.csv"
            write(record, path)
            decays = find_decays(read_record(path))
            if not decays:
                none += 1
                said.update(str(remark.code) for remark in decays.remarks)
                continue
            best = decays[0]
            near = abs(best.start - record.start) < RIGHT
            right, sound = right + near, sound + (near and not best.doubts)
            kept += best.stop > record.stop + LATE
            said.update(str(doubt.code) for doubt in best.doubts)
    often = ", ".join(f"{code} {number}" for code, number in said.most_common(6))
    return [f"{masses}, {bits} bits", *map(str, (len(seeds), none, right, sound, kept)), often]


if __name__ == "__main__":
    print(report())
