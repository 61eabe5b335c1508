"""Three tests of one rig that is not quite linear, joined, and single ones compared, from their files.

The rigs are those of `rigs`, let go from different heights, with one clock. The truth is that of the
exact motion at the amplitude at which the joint mode holds.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from tabulate import tabulate

from suspid import Analysis, SuspidError, analyse, compare
from suspid.identification import AmplitudeDependence, Described, at_common_amplitudes
from suspid.words import Level
from validation.rigs import Release, equivalent, release, write

# Seeds that were not used during development.
FIRST_SEED = 930_000
SEEDS = int(os.environ.get("SUSPID_SEEDS", "40"))
KINDS = ("friction", "bilinear", "cubic")
TESTS = 3
# Dampers and friction of a test after a change.
CHANGED = 1.3


@dataclass(frozen=True, kw_only=True)
class Joint:
    """What a joint analysis says beside the truth, and what comparisons of single tests say."""

    right: bool = False  # one mode
    common: bool = False  # the decays met an amplitude in common
    wn: float = np.nan  # error of the natural frequency, as a share
    zeta: float = np.nan  # of the damping ratio
    sds: tuple[float, float] = (np.nan, np.nan)  # both in standard deviations
    disagrees: bool = False
    same: bool | None = None  # a repeat compared with the first test: no value changed
    told: bool | None = None  # a test with other dampers and friction: the damping changed
    level: Level = Level.NONE


def joint(kind: str, seed: int) -> Joint:
    """Write three tests of a rig and one of it after a change, join the three, and compare two with the first."""
    first = release(kind, 1, seed=seed)
    tests = [first, *(release(kind, 1, seed=seed, first=first, test=number) for number in range(1, TESTS))]
    tests.append(release(kind, 1, seed=seed, first=first, test=TESTS, damping=CHANGED))
    with tempfile.TemporaryDirectory() as folder:
        files = [Path(folder) / f"test {number}.csv" for number in range(TESTS + 1)]
        for file, test in zip(files, tests, strict=True):
            write(test, file)
        try:
            found = analyse(files[:TESTS])
            alone, again, other = (analyse(files[k]) for k in (0, 1, TESTS))
        except SuspidError:
            return Joint()
    return _judged(tests[:TESTS], found, same=_alike(again, alone), told=_alike(other, alone))


def _alike(found: Analysis, expected: Analysis) -> tuple[bool, bool]:
    """Return whether frequency and damping pass as those of the same rig, as `suspid compare` judges."""
    sides = [Described(modes=one.modes, tables=_tables(one)) for one in (found, expected)]
    if not all(len(side.modes) == 1 for side in sides):
        return False, False
    one, other, _ = at_common_amplitudes(*sides)
    rows = {row.quantity: row.verdict == "ok" for row in compare(one, other).table}
    return rows["wn"], rows["zeta"]


def _tables(found: Analysis) -> Sequence[AmplitudeDependence | None]:
    return found.identification.amplitude_dependence or (None,) * len(found.modes)


def _judged(tests: Sequence[Release], found: Analysis, *, same: tuple[bool, bool], told: tuple[bool, bool]) -> Joint:
    modes, repeats, level = found.modes, found.repeats, found.verdict.level
    assert repeats is not None
    said = Joint(right=len(modes) == 1, same=all(same), told=not told[1], level=level)
    if not said.right or modes.wn_std is None or modes.zeta_std is None:
        return said
    disagrees = repeats.consistency[0].widening > 1
    table = repeats.amplitude_dependence[0] if repeats.amplitude_dependence else None
    if table is None:
        return replace(said, disagrees=disagrees)
    wn, zeta = np.mean([_at(test, table.holds_at) for test in tests], axis=0)
    off = float(modes.wn[0]) - wn, float(modes.zeta[0]) - zeta
    sds = off[0] / float(modes.wn_std[0]), off[1] / float(modes.zeta_std[0])
    return replace(said, common=True, wn=off[0] / wn, zeta=off[1] / zeta, sds=sds, disagrees=disagrees)


def _at(test: Release, amplitude: float) -> tuple[float, float]:
    """Return natural frequency and damping ratio of the exact motion at an amplitude, between its cycles."""
    sizes, wn, zeta = equivalent(test, test.start, test.stop)
    order = np.argsort(sizes)
    at = [float(np.interp(np.log(amplitude), np.log(sizes[order]), part[order])) for part in (wn, zeta)]
    return at[0], at[1]


def report(*, seeds: int = SEEDS) -> str:
    """Return the report as markdown."""
    rows = []
    with ProcessPoolExecutor(max_workers=2) as pool:
        for kind in KINDS:
            order = range(FIRST_SEED, FIRST_SEED + seeds)
            found = list(pool.map(joint, [kind] * seeds, order, chunksize=2))
            rows.append([f"1, {kind}", str(seeds), *_shares(found)])
            print("  ".join(rows[-1]), file=sys.stderr, flush=True)
    headers = [
        "masses, kind", "rigs", "one mode", "common amplitude", "wn within 1 %", "zeta within 15 %",
        "wn within 95 % interval", "zeta within 95 % interval", "said to disagree", "a repeat: no change",
        f"damping x {CHANGED}: said", "sound and beyond 4 sd",
    ]  # fmt: skip
    return (
        "\n\n".join(
            [
                "# Several tests of rigs that are not quite linear",
                f"Rigs of one mass, seeds {FIRST_SEED} and on, {TESTS} tests of each from different heights, on one "
                f"clock, joined by `analyse` of the files without any setting. Errors are those of rigs whose "
                f"tests met an amplitude in common, at that amplitude, against the mean of the exact motions there. "
                f"The first test is compared with the second as `suspid compare` does, and with one after dampers and "
                f"friction became {CHANGED} times as large.",
                tabulate(rows, headers=headers, tablefmt="github", disable_numparse=True),
            ]
        )
        + "\n"
    )


def _shares(found: Sequence[Joint]) -> list[str]:
    common = [one for one in found if one.common]
    right = [one for one in found if one.right]

    def share(held: Sequence[bool]) -> str:
        return f"{100 * float(np.mean(held)):.0f} %" if held else "-"

    return [
        share([one.right for one in found]),
        share([one.common for one in right]),
        share([abs(one.wn) < 0.01 for one in common]),
        share([abs(one.zeta) < 0.15 for one in common]),
        share([abs(one.sds[0]) < 1.96 for one in common]),
        share([abs(one.sds[1]) < 1.96 for one in common]),
        share([one.disagrees for one in right]),
        share([one.same for one in found if one.same is not None]),
        share([one.told for one in found if one.told is not None]),
        share([one.level is Level.SOUND and max(map(abs, one.sds)) > 4 for one in found]),
    ]
