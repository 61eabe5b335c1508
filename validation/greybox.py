"""Springs and dampers straight from records, beside the bound and beside other methods.

Records come from the independent motion of `validation.motion`; the library starts 30 % off.
"""

from __future__ import annotations

import importlib.util
import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from suspid import Suspension, SuspidError, estimate
from suspid.text_tables import text_table
from suspid.units import RealArray
from validation.greybox_bounds import value_of
from validation.greybox_memory import memory_table
from validation.greybox_misfits import corner_table, simulator_table
from validation.greybox_peers import equation_error, era_and_reconstruct, ssi_and_reconstruct, welch_h1
from validation.greybox_rows import Row, rows
from validation.tyres import FIRST_SEED

if TYPE_CHECKING:
    import control

SEEDS = int(os.environ.get("SUSPID_SEEDS", "100"))
CORNERS = 20  # draws of each corner: its error is that of the car that is left out, the same in all
LEVEL = 0.95
# Rows of which four times as many draws are made: the RMSE of 100 draws scatters by 7 %, and of many parameters at
# their bounds the largest lies above its own by more than that without any loss.
OFTEN = (
    "class C, 60 s", "class D, 60 s",
    "half car, modes 10% apart, 40 dB", "half car, modes 2% apart, 40 dB",
    "full car, 60 s at 100 Hz, gain, delay, mount known",
)  # fmt: skip
BESIDE_PEERS = (
    "class B, 60 s, gain, delay, mount known", "wheel sensor 2 ms late", "mount 1e6 N/m",
    "quarter car, 20 dB", "half car, modes 10% apart, 40 dB", "half car, modes 2% apart, 40 dB",
)  # fmt: skip

HEAD = """# Springs and dampers straight from records

Records come from an independent integrator (`validation/motion.py`), which shares no equation with the library. The
nominal car is 30 % off in every spring and damper that is judged, up and down in turn. Bias, the Cramér-Rao bound, RMSE
and RMSE over the bound are given for k and c where one strut is judged, else as the range over all parameters. Coverage
is the mean over all parameters. 'explained' is the share of the draws in which the residual is accepted as noise. Time
is processor time on this machine.

Roads and forces that are known to some percent are measured with white noise of that share of their motion, whose
level the bound knows. Gain and delay of a wheel's sensor that is high and late are unknown to the bound; in rows
without 'told' `estimate` finds out which sensor it is.

The bound knows the start as little as the estimator does. Where wheels are given, starts are left out, forces on the
body are noise of known spectrum, and gain and delay of the wheels' sensors and a mount are unknown to both, unless they
are said to be known. Without a mount, delay and mount are nearly one thing, and the bound does not know that a mount is
not negative: c is then found with half its error. The bound of the row with a force on the body knows the spectrum of
that force; the estimator finds it from the record, as up to 24 levels over frequency. Bounds are of 0.5 to 25 Hz, the
band of the estimator ends at 2.5 times the wheels' modes, 27 to 30 Hz.

Of 60 s of class B 0.3 % are asked of k and c with gain, delay and mount unknown, 0.5 % of half and full cars. Bounds
are above that in part: 0.32 and 0.93 % without a mount, 0.31 % of c with one of 1e6 N/m, up to 1.23 % for the half car
and 0.77 % for the full one. What lies below its bound does so because no mount is negative. Intervals are those of the
profile of the likelihood within the bounds, wider beside one since likelihood ratios there are a mixture of
chi-squares. To first order 95 to 98 % of them hold there.

Seeds are those from 730000 on, which were not used during development; of corners those from 0 on.
`SUSPID_SEEDS=100 python -m validation greybox` prints these tables."""
SIMULATOR = """## Records of another simulator

A quarter car with a seat over a chirp, over a step, and released, without noise (rizoit, `shared/data`), 30 % off at
the start. Largest relative errors of all k and of all c but the tire's; 1e-4 and 1e-3 are asked of all three records
jointly."""
CORNER = """## A quarter car on a corner of a half car

The body's acceleration above an axle and that of its wheel, class B, 60 s. The dynamic index is the pitch inertia over
the mass and the distances of both axles from the centre. At 1 the other axle does not matter and nothing is to be told;
at the others the verdict must be doubtful and the intervals wide enough for the truth. 'stated' is the median of half
their width, 'both hold' the share of the draws in which those of k and c contain the truth."""
MEMORY = """## Memory

What `estimate` allocates at most while it fits a drive of two channels at 200 Hz, and what the record itself takes, in
double precision. The spectra of all stretches are kept, with the fitted motion and the residual of every sample, which
are most of it; derivatives are made for some stretches at a time. So it follows the length of the drive, and not into
how many stretches or records it is divided. A few stretches of minutes each take more: a transfer has a value at every
line."""
PEERS = """## Beside other methods

On the same records. Gain, delay and mount are unknown to `estimate` in the second and third drive; the other methods
have no place for them. 'failed' counts records of which the modes were not found, or the car was not rebuilt. pyOMA_2
gets the velocities of drives at 50 Hz (from accelerations it does not find the mode of the body), decays as they are,
and 30 block rows."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Tally:
    """What became of the draws of a case; parameters are those of the case."""

    draws: int
    failed: int
    error: RealArray  # (draw, parameter): relative
    bound: RealArray  # (parameter,): relative
    coverage: RealArray  # (parameter,)
    explained: float
    seconds: float  # processor time of one estimate, median

    @property
    def rmse(self) -> RealArray:
        """Relative root mean square error, (parameter,)."""
        return np.asarray(np.sqrt(np.mean(self.error**2, axis=0)))


def tally(row: Row, *, seeds: int = SEEDS) -> Tally:
    """Return errors and coverage of a case over many draws."""
    truth = np.array([value_of(row.car, name) for name in row.names])
    errors, holds, spent, explained, failed = [], [], [], 0, 0
    for seed in range(FIRST_SEED, FIRST_SEED + seeds):
        record = row.record(np.random.default_rng(seed))
        start = time.process_time()
        try:
            found = estimate(record, row.nominal, given=row.given, fixed=row.fixed, **row.options)
        except SuspidError:
            failed += 1
            continue
        spent.append(time.process_time() - start)
        ends, values = found.interval(LEVEL), dict(zip(found.parameters, found.values, strict=True))
        errors.append([values[name] / true - 1 for name, true in zip(row.names, truth, strict=True)])
        holds.append([ends[name][0] <= true <= ends[name][1] for name, true in zip(row.names, truth, strict=True)])
        explained += found.explains
    nothing = np.full((1, len(truth)), np.nan)
    return Tally(
        draws=seeds,
        failed=failed,
        error=np.array(errors) if errors else nothing,
        bound=np.full(len(truth), np.nan) if row.bound is None else row.bound() / truth,
        coverage=np.mean(holds, axis=0) if holds else nothing[0],
        explained=explained / max(len(errors), 1),
        seconds=float(np.median(spent)) if spent else np.nan,
    )


def table(cases: list[Row], *, seeds: int = SEEDS) -> str:
    """Return the table of some cases."""
    lines = [cells(row, tally(row, seeds=4 * seeds if row.name in OFTEN else seeds)) for row in cases]
    return text_table({name: [line[name] for line in lines] for name in lines[0]})


def cells(row: Row, found: Tally) -> dict[str, str]:
    """Return the line of a case, by column."""
    return {
        "record": row.name,
        "draws": str(found.draws),
        "failed": str(found.failed),
        "bias [%]": _span(100 * np.mean(found.error, axis=0), "{:+.2f}"),
        "bound [%]": _span(100 * found.bound, "{:.3g}"),
        "RMSE [%]": _span(100 * found.rmse, "{:.3g}"),
        "RMSE / bound": _span(found.rmse / found.bound, "{:.2f}"),
        "95 % that hold": f"{np.mean(found.coverage):.1%}",
        "explained": f"{found.explained:.0%}",
        "time [ms]": f"{1e3 * found.seconds:.0f}",
    }


def _span(values: RealArray, form: str) -> str:
    """Return two values, or the least and the largest of several."""
    shown = values if len(values) <= 2 else [np.min(values), np.max(values)]
    return (", " if len(values) <= 2 else " to ").join(form.format(value) for value in shown)


def peers_table(*, seeds: int = SEEDS) -> str:
    """Return the table of all methods on the same drives and decays."""
    sections = rows()
    drives = [r for r in sections["Everyday driving, wheels given"] if r.name in BESIDE_PEERS]
    decays = [r for r in sections["Free decays"] if r.name in BESIDE_PEERS]
    columns: dict[str, list[str]] = {name: [] for name in ("record", "method", "failed", "RMSE [%]", "RMSE / bound")}

    def add(row: Row, method: str, one: Callable[[object], RealArray]) -> None:
        truth, errors = np.array([value_of(row.car, name) for name in row.names]), []
        for seed in range(FIRST_SEED, FIRST_SEED + seeds):
            try:
                errors.append(one(row.record(np.random.default_rng(seed))) / truth - 1)
            except (SuspidError, np.linalg.LinAlgError, ValueError):
                continue
        nothing = np.full((1, len(truth)), np.nan)
        rmse = np.sqrt(np.mean(np.square(errors or nothing), axis=0))
        bound = np.full(len(truth), np.nan) if row.bound is None else row.bound() / truth
        cells = (
            row.name,
            method,
            f"{seeds - len(errors)}/{seeds}",
            _span(100 * rmse, "{:.3g}"),
            _span(rmse / bound, "{:.2f}"),
        )
        for column, cell in zip(columns.values(), cells, strict=True):
            column.append(cell)

    for row in (*drives, *decays):
        add(row, "suspid, estimate", partial(_estimated, row=row))
        if row in drives:
            add(row, "Welch H1, k and c fitted", partial(welch_h1, car=row.nominal))
            add(row, "equation error, least squares", partial(equation_error, car=row.nominal))
        else:
            add(row, "python-control ERA (order given) + reconstruct", partial(_by_modes, era_and_reconstruct, row=row))
        if importlib.util.find_spec("pyoma2"):
            add(row, "pyOMA_2 SSI-cov (order given) + reconstruct", partial(_by_modes, ssi_and_reconstruct, row=row))
    return text_table(columns)


def _estimated(record: control.TimeResponseData, *, row: Row) -> RealArray:
    found = estimate(record, row.nominal, given=row.given, fixed=row.fixed, **row.options)
    return parameters_of(found.suspension, row)


def _by_modes(
    method: Callable[[control.TimeResponseData, Suspension, tuple[str, ...]], Suspension],
    record: control.TimeResponseData,
    *,
    row: Row,
) -> RealArray:
    return parameters_of(method(record, row.nominal, row.fixed), row)


def parameters_of(car: Suspension, row: Row) -> RealArray:
    """Return the parameters of the case."""
    return np.array([value_of(car, name) for name in row.names])


def report() -> str:
    """Return the tables of all cases."""
    parts = [HEAD, *(f"## {name}\n\n```\n{table(cases)}\n```" for name, cases in rows().items())]
    parts += [
        f"{SIMULATOR}\n\n```\n{simulator_table()}\n```",
        f"{CORNER}\n\n```\n{corner_table(seeds=CORNERS)}\n```",
        f"{MEMORY}\n\n```\n{memory_table()}\n```",
        f"{PEERS}\n\n```\n{peers_table()}\n```",
    ]
    return "\n\n".join(parts) + "\n"
