"""The problem of a drive: spectra of all records, and the unknowns of their channels and mounts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from suspid.cleaning import DRIFT
from suspid.greybox.further import FIRST_RELAXATION, GAINS, TIMES, check_some_known, chosen_of, label
from suspid.greybox.measured_causes import Extras, Source, WheelProblem
from suspid.greybox.noise_levels import node_basis
from suspid.greybox.spectra import spectra_of
from suspid.greybox.transfers import layout_of
from suspid.greybox.trials import Trial
from suspid.model import Suspension, eigenmodes
from suspid.reconstruction import Unknowns
from suspid.units import Hertz, Second

# The band, over the lowest and the highest natural frequency of the nominal car: 0.5 to 27 Hz for most cars. Below it
# accelerations hold little, above it the wheels' motion hardly moves the body. Delays are
# told from mounts, and roads from tires, above the wheels' modes.
BELOW, ABOVE = 0.4, 2.5
STRETCH_PERIODS = 8.0  # of the lowest mode, in a stretch: longer ones have fewer ends, shorter ones follow slow changes


def wheel_problem(
    car: Suspension,
    trials: Sequence[Trial],
    unknowns: Unknowns,
    *,
    gains: Sequence[str] | None,
    delays: Sequence[str] | None,
    mounts: Sequence[str] | None,
    band: tuple[Hertz, Hertz] | None,
    stretch: Second | None,
) -> WheelProblem:
    """Return the problem, with gains and delays of all causes and all mounts unknown unless some are named."""
    own = band_of(car)
    limits, lowest = own if band is None else band, own[0] / BELOW
    sources = []
    for numbers in by_logger(trials):
        trial = trials[numbers[0]]
        layout = layout_of(car, trial)
        # The gain of a channel that shows free coordinates too, such as a travel, is that of springs and dampers.
        causes = [trial.channels[c] for c in layout.causes if not np.any(layout.on_free[c])]
        check_some_known("delays", delays or (), trial.channels)
        length = STRETCH_PERIODS / lowest if stretch is None else stretch
        spectra = spectra_of([trials[i] for i in numbers], length=length, band=limits)
        sources.append(
            Source(
                trial=trial,
                numbers=numbers,
                starts=tuple(trials[i].start for i in numbers),
                layout=layout,
                spectra=spectra,
                basis=node_basis(spectra.hertz, spectra.values.shape[1]),
                gains=tuple(trial.channels.index(c) for c in chosen_of("gains", gains, trial.channels, causes)),
                delays=tuple(trial.channels.index(c) for c in chosen_of("delays", delays, trial.channels, causes)),
            )
        )
    struts = [s.name for s in car.struts]
    layout = sources[0].layout
    damped = [j for j in layout.bridges if car.struts[j].damping > 0]
    between = [struts[j] for j in damped if np.any(layout.arms_given[j])]
    springy = tuple(struts.index(name) for name in chosen_of("mounts", mounts, [struts[j] for j in damped], between))
    bare = WheelProblem(sources=tuple(sources), unknowns=unknowns, extras=_extras(car, springy, [], []))
    return replace(
        bare,
        extras=_extras(
            car,
            springy,
            [label(s.trial.channels[c], i, len(sources)) for i, s in enumerate(sources) for c in s.gains],
            [label(s.trial.channels[c], i, len(sources)) for i, s in enumerate(sources) for c in s.delays],
        ),
    )


def by_logger(trials: Sequence[Trial]) -> list[tuple[int, ...]]:
    """Return the numbers of trials in groups that share gains, delays and noise levels."""
    groups: list[list[int]] = []
    for i, trial in enumerate(trials):
        home = next((group for group in groups if _alike(trials[group[0]], trial)), None)
        if home is None:
            groups.append([i])
        else:
            home.append(i)
    return [tuple(numbers) for numbers in groups]


def _alike(one: Trial, other: Trial) -> bool:
    """Return whether two trials are of one logger, with the same channels and masses, at one rate."""
    same = one.logger is not None and one.logger == other.logger and one.channels == other.channels
    same = same and one.wheels == other.wheels and np.array_equal(one.added, other.added)
    return same and abs(one.step / other.step - 1) < DRIFT


def band_of(car: Suspension) -> tuple[Hertz, Hertz]:
    """Return the band about the natural frequencies of a car, up to `ABOVE` times the highest."""
    # A damper on a mount adds a real pole far above, at which nothing of the car's own moves.
    rigid = replace(car, struts=[replace(strut, mount_stiffness=None) for strut in car.struts])
    hertz = eigenmodes(rigid).wn / (2 * np.pi)
    return BELOW * float(np.min(hertz[hertz > 0])), ABOVE * float(np.max(hertz))


def _extras(car: Suspension, mounts: Sequence[int], gains: Sequence[str], delays: Sequence[str]) -> Extras:
    a, b, c = len(mounts), len(gains), len(delays)
    relaxation = [max(car.struts[j].relaxation, FIRST_RELAXATION * TIMES) / TIMES for j in mounts]
    return Extras(
        names=(
            *(f"{car.struts[j].name}.relaxation" for j in mounts),
            *(f"{name}.gain" for name in gains),
            *(f"{name}.delay" for name in delays),
        ),
        mounts=tuple(mounts),
        start=np.array([*relaxation, *[1.0] * b, *[0.0] * c]),
        positive=np.array([False] * a + [True] * b + [False] * c, bool),
        scale=np.array([TIMES] * a + [1.0] * b + [TIMES] * c),
        lower=np.array([0.0] * a + [GAINS[0]] * b + [-np.inf] * c),
        upper=np.array([np.inf] * a + [GAINS[1]] * b + [np.inf] * c),
    )
