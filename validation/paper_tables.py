"""Rows of the report on the paper's example: truth, printed values, estimates and the bound."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from tabulate import tabulate

from suspid import ModalSet, eigenmodes, statespace
from suspid.units import ComplexArray, RealArray, Second
from validation.bounds import Bound
from validation.study import Study, bound, case_methods, paper_car
from validation.table2 import ACTUAL_WN, ACTUAL_ZETA, CASES, Case

# With fewer draws than this no RMSE is printed.
FEWEST_DRAWS = 10
# Errors below this, of identification without noise, are rounding and change from machine to machine.
ROUNDING = 1e-6
TRAPEZOIDAL_STEP: Second = 0.002

Studies = dict[tuple[str, tuple[str, ...], str], Study]


def truth_rows() -> list[list[str]]:
    """Return the rows of the exact modes, printed above every part of Table 2."""
    truth = eigenmodes(paper_car())
    return [
        ["actual, paper", *_modes_text(ACTUAL_WN, ACTUAL_ZETA, 2), "", ""],
        ["actual, exact", *_modes_text(truth.wn[::-1], 100 * truth.zeta[::-1], 4), "", ""],
    ]


def damping_rows() -> list[list[str]]:
    """Return the modes of each reading of Table 1's damping, for comparison with Table 2."""
    tenfold = statespace(paper_car()).A
    printed, exact = eigenmodes(paper_car(damping_factor=1.0)), eigenmodes(paper_car())
    stepped = ModalSet(poles=trapezoidal_poles(np.asarray(tenfold), TRAPEZOIDAL_STEP))
    rows = [
        ["Table 2, actual", *_modes_text(ACTUAL_WN, ACTUAL_ZETA, 2)],
        ["Table 2, original", *_modes_text(CASES[0].wn, CASES[0].zeta, 4)],
    ]
    for name, modes in (
        ("1. c as printed: 30, 20, 10 N s/m", printed),
        ("2. ten times that: 300, 200, 100 N s/m", exact),
        ("3. as 2, trapezoidal rule at 2 ms", stepped),
    ):
        rows.append([name, *_modes_text(modes.wn[::-1], 100 * modes.zeta[::-1], 4)])
    return rows


def trapezoidal_poles(A: RealArray, step: Second) -> ComplexArray:
    """Return the poles that integrating ``x' = A x`` by the trapezoidal rule at a fixed step shows [rad/s].

    One step multiplies the state by ``(I - A h / 2)^-1 (I + A h / 2)``; the poles are the logarithms of
    its eigenvalues over h, those of the upper half plane.
    """
    half = 0.5 * step * A
    factors = np.linalg.eigvals(np.linalg.solve(np.eye(len(A)) - half, np.eye(len(A)) + half))
    poles = np.log(factors.astype(complex)) / step
    return np.asarray(poles[poles.imag > 0])


def best_step() -> Second:
    """Return the step of the trapezoidal rule that best fits the frequencies of Table 2's original row [s]."""
    from scipy.optimize import minimize_scalar

    A = np.asarray(statespace(paper_car()).A)

    def distance(step: float) -> float:
        found = np.sort(np.abs(trapezoidal_poles(A, step)))
        return float(np.sum((found - np.sort(CASES[0].wn)) ** 2))

    return float(minimize_scalar(distance, bounds=(1e-4, 5e-3), method="bounded", options={"xatol": 1e-7}).x)


def case_rows(case: Case, channels: tuple[str, ...], studies: Studies, seeds: int) -> list[list[str]]:
    """Return the rows of one case: printed values, bound, and every method's estimates."""
    rows = [["paper", *_modes_text(case.wn, case.zeta, 4), *(f"{error:.2e}" for error in case.mae)]]
    errors = [np.abs(np.subtract(case.wn, ACTUAL_WN)), np.abs(np.subtract(case.zeta, ACTUAL_ZETA))]
    rows.append(["paper, error", *_short_pairs(*errors), *(short(float(np.mean(e))) for e in errors)])
    least = None if case.snr_db is None else bound(case.snr_db, channels)
    if least is not None:
        efficient = np.sqrt(2 / np.pi)
        pairs = _short_pairs(least.wn_std[::-1], 100 * least.zeta_std[::-1])
        means = (efficient * np.mean(least.wn_std), efficient * 100 * np.mean(least.zeta_std))
        rows.append(["bound", *pairs, *(short(float(m)) for m in means)])
    for method in case_methods(case):
        study = studies[case.name, channels, method]
        rows += _exact_rows(method, study) if least is None else _noisy_rows(method, study, least, seeds)
    return rows


def _exact_rows(method: str, study: Study) -> list[list[str]]:
    """Return the rows of a record without noise: one draw."""
    truth = eigenmodes(paper_car())
    errors = np.abs(study.wn[0] - truth.wn)[::-1], 100 * np.abs(study.zeta[0] - truth.zeta)[::-1]
    return [
        [method, *_modes_text(study.wn[0, ::-1], 100 * study.zeta[0, ::-1], 4), "", ""],
        [f"{method}, error", *_short_pairs(*errors), *(short(float(np.mean(e))) for e in errors)],
    ]


def _noisy_rows(method: str, study: Study, least: Bound, seeds: int) -> list[list[str]]:
    truth, complete = eigenmodes(paper_car()), study.complete
    counts = [text for k in range(len(truth))[::-1] for text in (str(int(np.sum(study.found[:, k]))), "")]
    rows = [[f"{method}, found of {seeds}", *counts, f"all: {int(np.sum(complete))}", ""]]
    if np.sum(complete) < min(FEWEST_DRAWS, seeds):
        return rows
    wn, zeta = study.wn[complete, ::-1], 100 * study.zeta[complete, ::-1]
    errors = np.abs(wn - truth.wn[::-1]), np.abs(zeta - 100 * truth.zeta[::-1])
    rmse = [np.sqrt(np.mean(error**2, axis=0)) for error in errors]
    ratios = rmse[0] / least.wn_std[::-1], rmse[1] / (100 * least.zeta_std[::-1])
    return [
        [f"{method}, mean", *_modes_text(wn.mean(axis=0), zeta.mean(axis=0), 4), "", ""],
        [f"{method}, RMSE", *_short_pairs(*rmse), *(short(float(np.mean(error))) for error in errors)],
        [f"{method}, RMSE / bound", *_short_pairs(*ratios), "", ""],
        *rows,
    ]


def found_and_ratio(study: Study, least: Bound, seeds: int) -> list[str]:
    """Return in how many draws all modes were found, and the largest RMSE over its bound in these."""
    count = int(np.sum(study.complete))
    return [str(count), "" if count < min(FEWEST_DRAWS, seeds) else short(largest_ratio(study, least))]


def largest_ratio(study: Study, least: Bound) -> float:
    """Return the largest RMSE over its bound, of both quantities and all modes, over the complete draws."""
    truth, complete = eigenmodes(paper_car()), study.complete
    if not np.any(complete):
        return np.nan
    wn = np.sqrt(np.mean((study.wn[complete] - truth.wn) ** 2, axis=0)) / least.wn_std
    zeta = np.sqrt(np.mean((study.zeta[complete] - truth.zeta) ** 2, axis=0)) / least.zeta_std
    return float(max(np.max(wn), np.max(zeta)))


def markdown(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table of text, its numbers to the right."""
    align = ["left"] + ["right"] * (len(header) - 1)
    return tabulate(rows, headers=header, tablefmt="pipe", disable_numparse=True, colalign=align)


def _modes_text(wn: Sequence[float] | RealArray, zeta: Sequence[float] | RealArray, digits: int) -> list[str]:
    return [f"{value:.{digits}f}" for pair in zip(wn, zeta, strict=True) for value in pair]


def _short_pairs(wn: RealArray, zeta: RealArray) -> list[str]:
    return [short(float(value)) for pair in zip(wn, zeta, strict=True) for value in pair]


def short(value: float) -> str:
    """Return two significant digits, in positional form."""
    if 0 < value < ROUNDING:
        return f"< {ROUNDING:.0e}"
    return np.format_float_positional(float(f"{value:.1e}"), trim="-")
