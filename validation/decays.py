"""Found decays against known ones: place, start after the excitation, and coverage of the intervals."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from tabulate import tabulate

from suspid import ModalSet, Suspension, analyse, eigenmodes, free_decay, statespace
from suspid.decays import Decay, find_decays
from suspid.errors import SuspidError
from suspid.identification.identify_repeats import identify_repeats
from suspid.records import as_response
from suspid.units import Decibel, Hertz, RealArray, Second
from validation import cars
from validation.bounds import decay_amplitudes

if TYPE_CHECKING:
    import control

MASSES = ("seat", "chassis", "tire")
RATE: Hertz = 250.0
DURATION: Second = 180.0
# Recordings of each kind, and seeds that were not used during development.
RECORDINGS = 5
FIRST_SEED = 910_000
# Repeats against their bound: seeds, samples of each decay.
SEEDS = 100
LENGTHS = (1500, 2500, 2000, 900)
# A decay that starts this long before the end of a bump [s], or this long after it, belongs to it.
BEFORE, AFTER = 0.1, 1.0
# Errors over their bounds; coverage by the intervals of poles and of shapes; disagreement of repeats.
Judged = tuple[RealArray, RealArray, RealArray, RealArray]


@dataclass(frozen=True, kw_only=True, slots=True)
class Case:
    """Recordings of one kind: a quantity, the road while rolling, the noise of the sensors."""

    quantity: str
    rolling: float
    snr_db: Decibel
    bumps: int = 4


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Outcome:
    """Result for one recording: bumps found, errors of the starts, false decays, coverage of the intervals."""

    bumps: int
    found: int
    doubtless: int
    late: RealArray
    false: int
    false_doubtless: int
    covered: RealArray
    joint: RealArray
    first: RealArray


# The height of the road is a random walk, 3 mm / sqrt(s) at 1, during the decays as well.
CASES = tuple(
    Case(quantity=quantity, rolling=rolling, snr_db=snr)
    for quantity, rolling, snr in (
        ("displacement", 0.0, 40.0),
        ("displacement", 0.0, 60.0),
        ("displacement", 0.1, 50.0),
        ("velocity", 0.0, 50.0),
        ("acceleration", 0.0, 40.0),
        ("acceleration", 0.0, 60.0),
        ("acceleration", 0.3, 50.0),
    )
)
SILENT = tuple(
    Case(quantity=quantity, rolling=rolling, snr_db=snr, bumps=0)
    for quantity in ("displacement", "velocity", "acceleration")
    for rolling, snr in ((0.0, 0.0), (1.0, 40.0))
)


def report(*, recordings: int = RECORDINGS, seeds: int = SEEDS) -> str:
    """Return the report as markdown."""
    with ProcessPoolExecutor(max_workers=2) as pool:
        rows = []
        for case in (*CASES, *SILENT):
            numbers = range(FIRST_SEED, FIRST_SEED + recordings)
            rows.append(_row(case, list(pool.map(outcome, [case] * recordings, numbers))))
        repeats = [
            _repeats_row(name, car, list(pool.map(repeated, [car] * seeds, range(FIRST_SEED, FIRST_SEED + seeds))))
            for name, car in (("paper's car", cars.PAPER), ("hatchback", cars.HATCHBACK), ("van", cars.VAN))
        ]
    headers = [
        "recording", "bumps found", "of them without doubts", "start late [ms]: median, 90 %", "false per hour",
        "without doubts", "coverage of 95 %: each", "jointly", "first command",
    ]  # fmt: skip
    parts = [
        "# Finding decays",
        f"{recordings} recordings of {DURATION:g} s at {RATE:g} Hz a row, each of another random car (zeta mostly 0.1 "
        f"to 0.4), three channels, {CASES[0].bumps} half-sine bumps of 20 to 100 ms and 20 to 80 mm at random times, "
        f"sensor noise so far below the largest value, offsets and slow drifts, seeds {FIRST_SEED} and on. Rolling: a "
        f"road whose height is a random walk, 1 is 3 mm in a second, and it goes on while the car decays. Coverage: "
        f"share of the 95 % intervals of wn and zeta that hold, after automatic cutting, of the modes that lie within "
        f"a quarter of a true one; of decays without doubts, each alone, and all such decays of a recording jointly; "
        f"and of what `analyse`, the first command, says of each recording, with doubts or without.",
        tabulate(rows, headers=headers, tablefmt="github", disable_numparse=True),
        "# Repeats",
        f"Four decays ({', '.join(f'{n / 500:g}' for n in LENGTHS)} s at 500 Hz) from random states, three channels "
        f"with different noise, 20 dB, offsets; {seeds} recordings. Bound: that of all decays jointly, poles shared, "
        f"amplitudes and offsets free.",
        tabulate(
            repeats,
            headers=["car", "right number of modes", "largest RMSE/bound", "mean RMSE/bound", "coverage of 95 %",
                     "of shapes", "repeats said to disagree at 1 %"],
            tablefmt="github",
            disable_numparse=True,
        ),
    ]  # fmt: skip
    return "\n\n".join(parts) + "\n"


def outcome(case: Case, seed: int) -> Outcome:
    """Return the result for one recording."""
    car, record, ends = recording(case, seed=seed)
    truth = eigenmodes(car)
    found = find_decays(record)
    matches = [_match(decay, ends) for decay in found]
    hits = {match: decay for decay, match in zip(found, matches, strict=True) if match is not None}
    false = [decay for decay, match in zip(found, matches, strict=True) if match is None]
    good = [decay for decay in hits.values() if not decay.doubts]
    covered, joint, first = np.zeros(0), np.zeros(0), np.zeros(0)
    if hits:
        first = _covered(analyse(record).modes, truth)
    if good:
        try:
            repeats = identify_repeats(record, good)
            covered = np.concatenate([_covered(each.modes, truth) for each in repeats.each])
            joint = _covered(repeats.modes, truth)
        except SuspidError:
            covered = joint = np.zeros(0)
    return Outcome(
        bumps=len(ends),
        found=len(hits),
        doubtless=len(good),
        late=np.array([decay.start - ends[match] for match, decay in hits.items()]),
        false=len(false),
        false_doubtless=sum(not decay.doubts for decay in false),
        covered=covered,
        joint=joint,
        first=first,
    )


def recording(case: Case, *, seed: int) -> tuple[Suspension, control.TimeResponseData, list[Second]]:
    """Return a random car, its recording, and when each bump ends [s]."""
    rng = np.random.default_rng(seed)
    car = cars.random_car(rng)
    count = round(RATE * DURATION)
    time = np.arange(count) / RATE
    road = 0.003 * case.rolling * np.cumsum(rng.standard_normal(count)) / np.sqrt(RATE)
    ends = []
    for slot in np.sort(rng.choice(12, case.bumps, replace=False)):
        begin, width = 8.0 + 13.0 * slot + rng.uniform(0, 4), float(np.exp(rng.uniform(np.log(0.02), np.log(0.1))))
        inside = (time > begin) & (time < begin + width)
        road[inside] += rng.uniform(0.02, 0.08) * np.sin(np.pi * (time[inside] - begin) / width)
        # Between samples the road is a straight line: the last one of the bump ends at the next sample.
        ends.append(float(time[np.flatnonzero(inside)[-1] + 1]))
    values = respond(car, road, quantity=case.quantity)
    if not np.any(values):
        values = rng.standard_normal(values.shape)
    peak = np.max(np.abs(values - np.median(values, axis=1, keepdims=True)), axis=1, keepdims=True)
    values = values + peak * 10 ** (-case.snr_db / 20) * rng.standard_normal(values.shape)
    slow = np.sin(2 * np.pi * time / DURATION * rng.uniform(0.2, 0.8) + rng.uniform(0, 6, (3, 1)))
    values = values + peak * (rng.uniform(-0.5, 0.5, (3, 1)) + 0.03 * slow)
    return car, as_response(time, values, MASSES), ends


def respond(car: Suspension, road: RealArray, *, quantity: str) -> RealArray:
    """Return the exact motion of the masses on a road that is a straight line between samples, (mass, sample)."""
    from scipy.signal import lfilter

    suffix = "" if quantity == "displacement" else f"_{quantity}"
    system = statespace(car, outputs=[mass + suffix for mass in MASSES])
    step = 1 / RATE
    rate = np.diff(road, append=road[-1]) / step
    poles, vectors = np.linalg.eig(np.asarray(system.A, float))
    inputs = np.linalg.solve(vectors, np.asarray(system.B, float).astype(complex))
    seen = np.asarray(system.C, float) @ vectors
    values = np.asarray(system.D, float) @ np.stack([road, rate])
    for k, pole in enumerate(poles):
        # x' = pole x + b_0 road + b_1 rate, the rate constant and the road linear over a step.
        growth = np.exp(pole * step)
        constant = (growth - 1) / pole
        linear = (constant - step) / pole
        driven = inputs[k, 0] * (constant * road + linear * rate) + inputs[k, 1] * constant * rate
        state = lfilter([1.0], [1.0, -growth], np.concatenate([[0.0], driven[:-1]]))
        values = values + np.real(np.outer(seen[:, k], state))
    return np.asarray(values)


def _match(decay: Decay, ends: Sequence[Second]) -> int | None:
    late = [k for k, end in enumerate(ends) if -BEFORE <= decay.start - end <= AFTER]
    return late[0] if late else None


def _covered(found: ModalSet, truth: ModalSet) -> RealArray:
    """Return which 95 % intervals contain the truth, for modes near a true one."""
    if not len(found):
        return np.zeros(0)
    interval, out = found.interval(0.95), []
    for k, pole in enumerate(found.poles):
        nearest = int(np.argmin(np.abs(truth.poles - pole)))
        if abs(truth.poles[nearest] - pole) < 0.25 * abs(truth.poles[nearest]):
            out.append(interval.wn[k, 0] <= truth.wn[nearest] <= interval.wn[k, 1])
            out.append(interval.zeta[k, 0] <= truth.zeta[nearest] <= interval.zeta[k, 1])
    return np.array(out, float)


def _row(case: Case, outcomes: Sequence[Outcome]) -> list[str]:
    bumps, found = sum(o.bumps for o in outcomes), sum(o.found for o in outcomes)
    hours = len(outcomes) * DURATION / 3600
    late = 1000 * np.concatenate([o.late for o in outcomes])
    covered, joint, first = (
        np.concatenate([getattr(o, name) for o in outcomes]) for name in ("covered", "joint", "first")
    )
    what = f"{case.quantity}, noise -{case.snr_db:g} dB" + (f", rolling {case.rolling:g}" if case.rolling else "")
    return [
        what if case.bumps else f"{case.quantity}, no bump, " + ("rolling" if case.rolling else "white noise"),
        f"{found} of {bumps}",
        f"{sum(o.doubtless for o in outcomes)}",
        f"{np.median(late):.0f}, {np.quantile(np.abs(late), 0.9):.0f}" if late.size else "-",
        f"{sum(o.false for o in outcomes) / hours:.1f}",
        f"{sum(o.false_doubtless for o in outcomes) / hours:.1f}",
        f"{100 * np.mean(covered):.1f} % of {covered.size}" if covered.size else "-",
        f"{100 * np.mean(joint):.1f} % of {joint.size}" if joint.size else "-",
        f"{100 * np.mean(first):.1f} % of {first.size}" if first.size else "-",
    ]


def repeated(car: Suspension, seed: int) -> Judged | None:
    """Return errors over the joint bound and coverage of poles and shapes, or None if the number of modes is wrong."""
    system, truth = statespace(car), eigenmodes(car)
    rng, shaken = np.random.default_rng(5), np.random.default_rng(seed)
    states = [{"v_tire": rng.normal(), "v_chassis": 0.5 * rng.normal(), "z_seat": 0.01 * rng.normal()} for _ in LENGTHS]
    times = [np.arange(count) / 500 for count in LENGTHS]
    clean = [np.atleast_2d(free_decay(system, t, initial_state=x).y) for t, x in zip(times, states, strict=True)]
    noise = [np.sqrt(np.mean(c**2, axis=1)) * 0.1 * np.array([1.0, 2.0, 0.5]) for c in clean]
    values = np.hstack(
        [
            c + std[:, None] * shaken.standard_normal(c.shape) + 0.01 * shaken.standard_normal((3, 1))
            for c, std in zip(clean, noise, strict=True)
        ]
    )
    record = as_response(np.arange(values.shape[1]) / 500, values, MASSES)
    edges = np.concatenate([[0], np.cumsum(LENGTHS)]) / 500
    spans = [(float(a), float(b) - 0.002) for a, b in pairwise(edges)]
    found = identify_repeats(record, spans)
    if len(found.modes) != len(truth):
        return None
    errors = np.concatenate([found.modes.wn - truth.wn, found.modes.zeta - truth.zeta])
    held = _covered(found.modes, truth)
    assert found.modes.shapes is not None
    assert truth.shapes is not None
    assert found.modes.covariance is not None
    strongest = np.argmax(np.abs(found.modes.shapes), axis=0)
    apart = (found.modes.shapes - truth.shapes / truth.shapes[strongest, np.arange(len(truth))]).T.ravel()
    std = np.sqrt(np.diag(found.modes.covariance)[2 * len(truth) :])
    shapes = np.abs(np.stack([apart.real, apart.imag], axis=1).ravel())[std > 0] < 1.959964 * std[std > 0]
    return (
        errors / joint_bound(car, states, times, noise),
        held,
        shapes.astype(float),
        np.array([agreement.probability < 0.01 for agreement in found.consistency], float),
    )


def joint_bound(
    car: Suspension, states: Sequence[dict[str, float]], times: Sequence[RealArray], noise: Sequence[RealArray]
) -> RealArray:
    """Return the least standard deviations of wn, then zeta, from several decays with common poles.

    The information of each decay and channel on the poles, its own amplitudes and offset projected out, adds up: the
    sum that `validation.bounds.cramer_rao` forms over the channels of one record.
    """
    system = statespace(car)
    total = np.zeros(())
    for state, time, stds in zip(states, times, noise, strict=True):
        poles, amplitudes = decay_amplitudes(system, state)
        powers = np.exp(np.outer(time, poles))
        basis, _ = np.linalg.qr(np.column_stack([powers.real, -powers.imag, np.ones(len(time))]))
        for row, std in zip(amplitudes, stds, strict=True):
            slopes = time[:, None] * powers * row
            common = np.column_stack([slopes.real, -slopes.imag]) / std
            common -= basis @ (basis.T @ common)
            total = total + common.T @ common
    scale = 1 / np.sqrt(np.diag(total))
    covariance = np.linalg.inv(total * np.outer(scale, scale)) * np.outer(scale, scale)
    count, wn = len(poles), np.abs(poles)
    stds = np.empty(2 * count)
    for k, pole in enumerate(poles):
        pair = covariance[np.ix_([k, k + count], [k, k + count])]
        by_wn = np.array([pole.real, pole.imag]) / wn[k]
        by_zeta = np.array([-(pole.imag**2), pole.real * pole.imag]) / wn[k] ** 3
        stds[k], stds[k + count] = np.sqrt(by_wn @ pair @ by_wn), np.sqrt(by_zeta @ pair @ by_zeta)
    return stds


def _repeats_row(name: str, car: Suspension, outcomes: Sequence[Judged | None]) -> list[str]:
    right = [o for o in outcomes if o is not None]
    ratios = np.sqrt(np.mean(np.array([errors for errors, *_ in right]) ** 2, axis=0))
    held, shapes, apart = (float(100 * np.mean(np.concatenate([o[i] for o in right]))) for i in (1, 2, 3))
    return [
        f"{name}, zeta {', '.join(f'{zeta:.3g}' for zeta in eigenmodes(car).zeta)}",
        f"{100 * len(right) / len(outcomes):.0f} %",
        f"{np.max(ratios):.2f}",
        f"{np.mean(ratios):.2f}",
        f"{held:.1f} %",
        f"{shapes:.1f} %",
        f"{apart:.1f} %",
    ]
