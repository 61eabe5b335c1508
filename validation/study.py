"""The paper's cases on a stated record, and what identification makes of them over many draws of noise."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from multiprocessing import get_context
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import NDArray

from suspid import (
    BandwidthSearch,
    IdentificationError,
    InputError,
    ModalSet,
    Ridge,
    Suspension,
    add_noise,
    cwt,
    eigenmodes,
    fit_ridges,
    free_decay,
    identify,
    quarter_car,
    statespace,
)
from suspid.denoising import denoise
from suspid.signals import as_response
from suspid.units import Decibel, Hertz, RealArray, Second
from suspid.values import frozen_real
from validation.bounds import Bound, cramer_rao, decay_amplitudes
from validation.table2 import CASES, Case

if TYPE_CHECKING:
    import control

    from suspid.identification import Method

RATE: Hertz = 500.0
DURATION: Second = 10.0
START = {"v_tire": 1.0}
# Table 1 prints c = 30, 20, 10 N s/m; the modes of Table 2 belong to ten times that.
DAMPING_FACTOR = 10.0
# A mode counts as found if an estimate lies this near to its natural frequency, in relative terms.
FOUND = 0.05
# Every method that `identify` knows is judged; another one is one more name here.
METHODS: tuple[str, ...] = ("ridge", "likelihood")
# For denoised records only: the paper's method on the denoised record, in the windows that the noisy one allows.
NOISY_WINDOWS = "ridge, windows of the noisy record"
# The bandwidth of least entropy is chosen among these, as in the paper.
CANDIDATES = range(1, 51)
CHANNEL_SETS: tuple[tuple[str, ...], ...] = (("seat",), ("tire",), ("seat", "chassis", "tire"))


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Study:
    """Estimates of one case from one set of channels by one method over many draws.

    Parameters
    ----------
    bandwidth : float
        N of the wavelet.
    wn, zeta : ndarray (draw, mode)
        Estimates [rad/s], [1], ascending in frequency; NaN where a mode was lost.
    """

    bandwidth: float
    wn: RealArray
    zeta: RealArray

    @property
    def found(self) -> NDArray[np.bool_]:
        """Which modes were found, (draw, mode)."""
        return np.asarray(np.isfinite(self.wn))

    @property
    def complete(self) -> NDArray[np.bool_]:
        """In which draws all modes were found, (draw,)."""
        return np.asarray(np.all(self.found, axis=1))


def paper_car(*, damping_factor: float = DAMPING_FACTOR) -> Suspension:
    """Return the car of Table 1, its printed damping times a factor."""
    return quarter_car(
        seat_mass=200.0,
        chassis_mass=200.0,
        tire_mass=200.0,
        seat_stiffness=200e3,
        chassis_stiffness=400e3,
        tire_stiffness=800e3,
        seat_damping=30.0 * damping_factor,
        chassis_damping=20.0 * damping_factor,
        tire_damping=10.0 * damping_factor,
    )


def clean_record() -> control.TimeResponseData:
    """Return the decay after a unit impulse of velocity on the tire: displacements, 500 Hz, 10 s."""
    return free_decay(paper_car(), np.arange(int(RATE * DURATION)) / RATE, initial_state=START)


def case_record(case: Case, channels: Sequence[str], *, seed: int) -> control.TimeResponseData:
    """Return the record of a case: the same seed gives every set of channels, and both forms, the same noise."""
    record = clean_record()
    if case.snr_db is not None:
        record = add_noise(record, snr_db=case.snr_db, rng=np.random.default_rng(seed))
    labels = list(record.output_labels)
    picked = np.asarray(record.y)[[labels.index(name) for name in channels]]
    chosen = as_response(np.asarray(record.time), picked, channels, title=case.name)
    return denoise(chosen) if case.denoised else chosen


def bound(snr_db: Decibel, channels: Sequence[str]) -> Bound:
    """Return the Cramér-Rao bound for the record's poles from some channels, ascending in frequency."""
    system = statespace(paper_car())
    start = np.array([START.get(label, 0.0) for label in system.state_labels])
    poles, amplitudes = decay_amplitudes(system, start)
    record = clean_record()
    picked = [list(record.output_labels).index(name) for name in channels]
    std = np.sqrt(np.mean(np.asarray(record.y)[picked] ** 2, axis=1) * 10 ** (-snr_db / 10))
    return cramer_rao(poles, amplitudes[picked], np.asarray(record.time), noise_std=std)


def entropy_search(
    case: Case, channels: Sequence[str], *, seed: int, candidates: Sequence[float] = CANDIDATES
) -> BandwidthSearch:
    """Return the entropy against bandwidth on the rows that `identify` uses."""
    record = case_record(case, channels, seed=seed)
    search = identify(record, modes=1, method="ridge", candidates=candidates).bandwidth_search
    assert search is not None
    return search


@cache
def available_methods() -> tuple[str, ...]:
    """Return the methods that `identify` accepts."""
    known = []
    for name in METHODS:
        try:
            identify(clean_record(), modes=3, method=cast("Method", name), bandwidth=20.0)
        except InputError:
            continue
        known.append(name)
    return tuple(known)


def case_methods(case: Case) -> tuple[str, ...]:
    """Return the methods that are tried on a case."""
    return available_methods() + ((NOISY_WINDOWS,) if case.denoised else ())


def run_studies(
    *,
    seeds: int,
    workers: int = 1,
    channel_sets: Sequence[tuple[str, ...]] = CHANNEL_SETS,
    candidates: Sequence[float] = CANDIDATES,
) -> dict[tuple[str, tuple[str, ...], str], Study]:
    """Return the study of every case, set of channels and method.

    Parameters
    ----------
    seeds : int
        How many draws of each noisy case.
    workers : int
        Processes to share the work. The result does not depend on it.
    channel_sets : sequence of tuple of str
        From which channels.
    candidates : sequence of float
        Bandwidths among which the one of least entropy is chosen, once per case and set of channels.

    Returns
    -------
    dict
        By name of the case, channels and method.
    """
    keys = [(c, ch, m) for c, ch in product(CASES, channel_sets) for m in case_methods(c)]
    if workers == 1:
        studies = [_study(*key, seeds, candidates) for key in keys]
    else:
        # Forking a process that runs threads is unsafe.
        with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
            studies = list(pool.map(_study, *zip(*keys, strict=True), [seeds] * len(keys), [candidates] * len(keys)))
    return {(c.name, ch, m): study for (c, ch, m), study in zip(keys, studies, strict=True)}


def _study(case: Case, channels: tuple[str, ...], method: str, seeds: int, candidates: Sequence[float]) -> Study:
    truth = eigenmodes(paper_car())
    # Choosing N anew in every draw would take ten times as long.
    best = entropy_search(case, channels, seed=0, candidates=candidates).best
    draws = range(seeds if case.snr_db is not None else 1)
    wn, zeta = np.full((2, len(draws), len(truth)), np.nan)
    for i, seed in enumerate(draws):
        try:
            modes = _estimate(case, channels, method, seed, best)
        except IdentificationError as error:
            modes = error.found
        for k, expected in enumerate(truth.wn):
            if modes is None:
                continue
            j = int(np.argmin(np.abs(modes.wn - expected)))
            if abs(modes.wn[j] - expected) < FOUND * expected:
                wn[i, k], zeta[i, k] = modes.wn[j], modes.zeta[j]
    return Study(bandwidth=best, wn=frozen_real(wn), zeta=frozen_real(zeta))


def _estimate(case: Case, channels: tuple[str, ...], method: str, seed: int, bandwidth: float) -> ModalSet | None:
    record = case_record(case, channels, seed=seed)
    if method != NOISY_WINDOWS:
        return identify(record, modes=3, method=cast("Method", method), bandwidth=bandwidth).modes
    noisy = case_record(replace(case, denoised=False), channels, seed=seed)
    ridges = identify(noisy, modes=3, method="ridge", bandwidth=bandwidth).ridges
    return fit_ridges([_on_record(ridge, record) for ridge in ridges])


def _on_record(ridge: Ridge, record: control.TimeResponseData) -> Ridge:
    """Return the ridge with the skeleton of another record of the same times."""
    wavelet = ridge.wavelet
    row = cwt(record, omega=[ridge.omega], bandwidth=wavelet.bandwidth, center=wavelet.center)
    return replace(ridge, skeleton=row.rows[0])
