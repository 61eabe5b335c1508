"""An estimate step by step: records and unknowns to a fit, its parameters, their checks and the verdict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple

import numpy as np

from suspid.cleaning import RecordLike
from suspid.errors import InputError
from suspid.greybox.axle_data import Led, behind_of, check_rolled
from suspid.greybox.causes import dies_down
from suspid.greybox.estimates import Estimate
from suspid.greybox.fits import Fit
from suspid.greybox.fitted_in_time import SensorsAsked, fitted_in_time
from suspid.greybox.judgement import changed_check, far_or_vague, folded, gains_off, on_bounds, rests_on
from suspid.greybox.late_causes import fit_drives
from suspid.greybox.modal import modes_with, mounted_car, of_car
from suspid.greybox.parameter_ends import Spread, changed
from suspid.greybox.record_test import RecordTest
from suspid.greybox.rolling import Speed, rolling_of, without_speed
from suspid.greybox.trials import Trial, trials_of
from suspid.greybox.whole_car import check_road, fit_with_road
from suspid.model import Suspension, check_linear, eigenmodes
from suspid.reconstruction import Bounds, parameter_names, unknowns_of
from suspid.records import as_response
from suspid.units import Hertz, Metre, RadianPerSecond, Ratio, Second
from suspid.values import frozen_real
from suspid.wording import Argument
from suspid.words import Check, Level, Remark, Verdict
from suspid.words.greybox import EstimateCheck, EstimateHeadline


class Asked(NamedTuple):
    """What is asked of an estimate: the arguments of `estimate`."""

    given: Sequence[str] = ()
    fixed: Sequence[str] = ()
    bounds: Bounds | None = None
    ties: Sequence[Sequence[str]] = ()
    nominal_std: Ratio | Mapping[str, Ratio] | None = None
    free_masses: Sequence[str] = ()
    gains: Sequence[str] | None = None
    delays: Sequence[str] | None = None
    mounts: Sequence[str] | None = None
    noisy: Sequence[str] | None = None
    band_hz: tuple[Hertz, Hertz] | None = None
    stretch: Second | None = None
    road: Literal["iso8608"] | None = None
    speed: Speed | Sequence[Speed] | None = None
    wheel_radius: Metre | None = None
    behind: Led | None = None


def fitted_car(
    records: RecordLike | RecordTest | Sequence[RecordLike | RecordTest],
    suspension: Suspension,
    asked: Asked,
    *,
    onsets: bool = True,
) -> Estimate:
    """Return what `estimate` returns; with ``onsets``, of records that are no free decays these are looked for.

    Raises
    ------
    InputError, RecordError, EstimationError
        As `estimate` does.
    """
    _check(suspension)
    trials = trials_of(records, suspension, asked.given)
    asked_of_road = {"behind": asked.behind or None, "wheel_radius": asked.wheel_radius, "speed": asked.speed}
    check_road(trials, road=asked.road, rolling=asked_of_road)
    driven = [bool(trial.wheels) for trial in trials]
    if any(driven) and not all(driven):
        raise InputError(
            Argument("given"),
            f": record {driven.index(True) + 1} has a cause that is measured motion of the car and record "
            f"{driven.index(False) + 1} has none; estimate from either, and give the result of one as ",
            Argument("nominal_std"),
        )
    if any(driven) and asked.noisy:
        raise InputError(Argument("noisy"), ": the noise of measured motion is always allowed for; leave it out")
    if not any(driven) and not asked.noisy:
        _check_unused({"band_hz": asked.band_hz, "stretch": asked.stretch})
    beyond = _beyond(suspension, trials)
    unknowns = unknowns_of(
        suspension,
        rate=_usual_frequency(suspension),
        fixed=[*([asked.fixed] if isinstance(asked.fixed, str) else asked.fixed), *(() if asked.road else beyond)],
        bounds=asked.bounds,
        ties=asked.ties,
        nominal_std=asked.nominal_std,
        free_masses=asked.free_masses,
    )
    if asked.road:
        rolling = rolling_of(records, trials, speed=asked.speed, radius=asked.wheel_radius)
        trials = without_speed(trials, rolling)
        pairs = behind_of(asked.behind, suspension)
        check_rolled(pairs, suspension, trials, asked.speed)
        fit = fit_with_road(
            unknowns, trials, rolling, beyond=beyond, gains=asked.gains, delays=asked.delays, mounts=asked.mounts,
            band=asked.band_hz, stretch=asked.stretch, behind=pairs,
        )  # fmt: skip
    elif any(driven):
        options = {"gains": asked.gains, "mounts": asked.mounts, "stretch": asked.stretch}
        fit = fit_drives(suspension, trials, unknowns, delays=asked.delays, band=asked.band_hz, options=options)
    else:
        sensors = SensorsAsked(asked.gains, asked.delays, asked.mounts, asked.noisy, asked.band_hz, asked.stretch)
        fit, trials, unknowns = fitted_in_time(trials, unknowns, sensors, onsets=onsets)
    u = unknowns
    parameters = (*u.names, *fit.extras)
    turned = np.zeros((len(parameters), len(fit.covariance)))
    turned[: len(u.names), : len(u)] = u.spread[u.rows]
    turned[len(u.names) :, len(u) :] = np.diag(fit.extra_scale)
    covariance = turned @ fit.covariance @ turned.T
    values = np.append(u.parameters(fit.x)[u.rows], fit.extra_values)
    std = np.sqrt(np.diag(covariance))
    step = min(trial.step for trial in trials)
    car = mounted_car(u.suspension(fit.x), parameters, values, std, step)
    unused = tuple(dict.fromkeys(name for trial in trials for name in trial.unused))
    still = () if asked.road else tuple(suspension.coordinates[i] for i in trials[0].wheels)
    own = of_car(u)
    ranges = np.vstack([np.column_stack([u.lower, u.upper])[u.column] * u.scale[u.column, None], fit.extra_ranges])
    # The least relaxation stands for none: intervals that reach it contain a rigid mount.
    ranges[[name.endswith(".relaxation") for name in parameters], 0] = 0.0
    unbounded = values if fit.pull is None else values + turned @ fit.pull
    apart = changed(suspension, Spread(parameters, values, covariance, unbounded, ranges, fit.explains))
    said = [one.remark.numbers["names"] for one in fit.checks if one.remark.code is EstimateCheck.TIRE_DAMPING]
    assumed = {str(name) for names in said if isinstance(names, tuple) for name in names}
    checks = [
        *fit.checks,
        *on_bounds(u, fit.x),
        *gains_off(parameters, values, std),
        *folded(parameters, values, std),
        changed_check(tuple(name for name in parameters if name in apart)),
        *far_or_vague(suspension, u.names[: len(own)], values[: len(own)], std[: len(own)], assumed=assumed),
        *rests_on(suspension, u.names, still=still, forced=any(len(trial.forces) for trial in trials)),
        *([Check(Remark(EstimateCheck.STILL, {"names": still}), Level.NOTE)] if still else []),
        *(
            [Check(Remark(EstimateCheck.CANCELS, {"names": beyond, "given": ", ".join(still)}), Level.NOTE)]
            if beyond and not asked.road
            else []
        ),
        *([Check(Remark(EstimateCheck.UNUSED, {"names": unused}), Level.NOTE)] if unused else []),
        *_driven(fit, trials),
    ]
    headline = Remark(EstimateHeadline.FOUND, {"parameters": len(u.names), "records": len(trials)})
    return Estimate(
        suspension=car,
        nominal=suspension,
        parameters=parameters,
        values=frozen_real(values),
        covariance=frozen_real(covariance),
        unbounded=frozen_real(unbounded),
        ranges=frozen_real(ranges),
        held=tuple(n for n in parameter_names(suspension) if n not in u.names and not n.endswith(".mass")),
        modes=modes_with(car, u, parameters, covariance, still),
        fitted=tuple(
            as_response(s.timepts, s.values, s.channels, inputs=trial.known)
            for s, trial in zip(fit.fitted, trials, strict=True)
        ),
        residual=tuple(as_response(s.timepts, s.values, s.channels) for s in fit.residual),
        noise_std=tuple(frozen_real(std) for std in fit.noise),
        chi_square=fit.chi_square,
        freedom=fit.freedom,
        explains=fit.explains,
        alternatives=fit.alternatives,
        verdict=Verdict(headline, tuple(checks)),
        road=fit.roads,
        causes=tuple(trial.causes for trial in trials),
        band_hz=fit.band,
    )


def _driven(fit: Fit, trials: Sequence[Trial]) -> list[Check]:
    """Return what is said of records that count as free decays, are not explained and do not die down."""
    free = all(not trial.causes for trial in trials)
    if not free or fit.explains or any(dies_down(trial.values) for trial in trials):
        return []
    each = [channel for trial in trials for channel in trial.channels]
    loggers = len(trials) > 1 and len({*each}) == len(each)
    return [Check(Remark(EstimateCheck.DRIVEN, {"loggers": loggers}), Level.DOUBTFUL)]


def _check(suspension: object) -> None:
    if not isinstance(suspension, Suspension):
        hint = "; take its .suspension" if hasattr(suspension, "suspension") else ""
        raise InputError(f"estimate needs a Suspension here, not {type(suspension).__name__}{hint}")
    check_linear(suspension, "estimate")


def _check_unused(settings: Mapping[str, object]) -> None:
    """Refuse settings of the frequency domain where records are fitted in time."""
    for name, value in settings.items():
        if value is not None:
            raise InputError(
                Argument(name),
                " does not apply here: free decays and records under known roads and forces are fitted in the time "
                "domain; leave it out, or name measured motion in ",
                Argument("given"),
            )


def _usual_frequency(car: Suspension) -> RadianPerSecond:
    """Return the median natural frequency, the scale of dampings; 1 rad/s where nothing is sprung."""
    sprung = [wn for wn in eigenmodes(car).wn.tolist() if 0 < wn < np.inf]
    return float(np.median(sprung)) if sprung else 1.0


def _beyond(car: Suspension, trials: Sequence[Trial]) -> tuple[str, ...]:
    """Return the parameters of struts that act beyond the given motion in every test, and so cancel."""
    arms = car.arms(car.coordinates)
    acts = np.zeros(len(car.struts), bool)
    for trial in trials:
        free = [i for i in range(len(car.coordinates)) if i not in trial.wheels]
        acts |= np.any(arms[:, free] != 0, axis=1)
    return tuple(s.name for s, one in zip(car.struts, acts, strict=True) if not one)
