"""The paper's cases on a stated record, identified over many draws of noise."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache
from itertools import product, starmap
from multiprocessing import get_context
from typing import TYPE_CHECKING, Any, cast

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
from suspid.records import as_response
from suspid.units import Decibel, Hertz, RealArray, Second
from suspid.values import frozen_real
from suspid.wavelets import denoise
from validation.bounds import Bound, cramer_rao, decay_amplitudes
from validation.table2 import CASES, Case

if TYPE_CHECKING:
    import control

    from suspid.identification.identification import Method

RATE: Hertz = 500.0
DURATION: Second = 10.0
START = {"v_tire": 1.0}
# Table 1 prints c = 30, 20, 10 N s/m; the modes of Table 2 belong to ten times that.
DAMPING_FACTOR = 10.0
# A mode counts as found if the distance of an estimated pole, over the natural frequency, is less than this.
FOUND = 0.05
# Methods of `identify` that are judged; add the name of a new one here.
METHODS: tuple[str, ...] = ("ridge", "likelihood")
# For denoised records only: the paper's method on the denoised record, in the windows of the noisy record.
NOISY_WINDOWS = "ridge, windows of the noisy record"
# The bandwidth of least entropy is chosen among these, as in the paper.
CANDIDATES = range(1, 51)
# Draws that a process takes at once.
BLOCK = 25
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
        """Whether each mode was found, (draw, mode)."""
        return np.asarray(np.isfinite(self.wn))

    @property
    def complete(self) -> NDArray[np.bool_]:
        """Whether all modes of a draw were found, (draw,)."""
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
    poles, amplitudes = decay_amplitudes(statespace(paper_car()), START)
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
    pairs = list(product(CASES, channel_sets))
    # A noisy record and its denoised form share the noise of their signal-to-noise ratio and channels.
    groups = list(product(dict.fromkeys(case.snr_db for case in CASES), channel_sets))
    blocks = [
        (snr_db, channels, range(start, min(start + BLOCK, seeds if snr_db is not None else 1)))
        for snr_db, channels in groups
        for start in range(0, seeds if snr_db is not None else 1, BLOCK)
    ]
    with _mapping(workers) as run:
        # Choosing N anew in every draw would take ten times as long.
        found = run(_least_entropy, [(case, channels, candidates) for case, channels in pairs])
        chosen = {(case.name, channels): best for (case, channels), best in zip(pairs, found, strict=True)}
        estimates = list(run(_estimates, [(*block, chosen) for block in blocks]))
    studies = {}
    for case, channels in pairs:
        for method in case_methods(case):
            parts = [
                e[case.name, method] for e, b in zip(estimates, blocks, strict=True) if b[:2] == (case.snr_db, channels)
            ]
            wn, zeta = np.concatenate(parts, axis=1)
            studies[case.name, channels, method] = Study(
                bandwidth=chosen[case.name, channels], wn=frozen_real(wn), zeta=frozen_real(zeta)
            )
    return studies


@contextmanager
def _mapping(workers: int) -> Iterator[Callable[..., Iterable[Any]]]:
    """Provide a map over tuples of arguments, in this process or in several."""
    if workers == 1:
        yield starmap
        return
    # Forking a process that runs threads is unsafe.
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        yield lambda function, arguments: pool.map(function, *zip(*arguments, strict=True))


def _least_entropy(case: Case, channels: tuple[str, ...], candidates: Sequence[float]) -> float:
    return entropy_search(case, channels, seed=0, candidates=candidates).best


def _estimates(
    snr_db: Decibel | None,
    channels: tuple[str, ...],
    seeds: Sequence[int],
    chosen: Mapping[tuple[str, tuple[str, ...]], float],
) -> dict[tuple[str, str], RealArray]:
    """Return wn and zeta, (2, draw, mode), by name of the case and method, for all cases of one noise."""
    truth = eigenmodes(paper_car())
    cases = sorted((case for case in CASES if case.snr_db == snr_db), key=lambda case: case.denoised)
    out = {(c.name, m): np.full((2, len(seeds), len(truth)), np.nan) for c in cases for m in case_methods(c)}
    for i, seed in enumerate(seeds):
        noisy_ridges: tuple[Ridge, ...] = ()
        for case in cases:
            record = case_record(case, channels, seed=seed)
            for method in available_methods():
                try:
                    found = identify(
                        record, modes=3, method=cast("Method", method), bandwidth=chosen[case.name, channels]
                    )
                    modes: ModalSet | None = found.modes
                    if method == "ridge" and not case.denoised:
                        noisy_ridges = found.ridges
                except IdentificationError as error:
                    modes = error.found
                out[case.name, method][:, i] = matched(modes, truth)
            if case.denoised and noisy_ridges:
                modes = fit_ridges([_on_record(ridge, record) for ridge in noisy_ridges])
                out[case.name, NOISY_WINDOWS][:, i] = matched(modes, truth)
    return out


def matched(modes: ModalSet | None, truth: ModalSet) -> RealArray:
    """Return wn and zeta of the estimate nearest to each true pole, NaN where none is near, (2, mode)."""
    out = np.full((2, len(truth)), np.nan)
    for k, pole in enumerate(truth.poles if modes is not None and len(modes) else ()):
        assert modes is not None
        distance = np.abs(modes.poles - pole)
        j = int(np.argmin(distance))
        if distance[j] < FOUND * abs(pole):
            out[:, k] = modes.wn[j], modes.zeta[j]
    return out


def _on_record(ridge: Ridge, record: control.TimeResponseData) -> Ridge:
    """Return the ridge with the skeleton of another record of the same times."""
    wavelet = ridge.wavelet
    row = cwt(record, omega=[ridge.omega], bandwidth=wavelet.bandwidth, center=wavelet.center)
    return replace(ridge, skeleton=row.rows[0])
