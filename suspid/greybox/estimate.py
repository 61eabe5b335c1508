"""Springs, dampers and masses of a suspension straight from records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from suspid.arguments import explained
from suspid.cleaning import RecordLike
from suspid.errors import EstimationError, InputError
from suspid.greybox.causes import dies_down
from suspid.greybox.estimates import Estimate, Spread, changed
from suspid.greybox.fits import Fit
from suspid.greybox.further import further_asked
from suspid.greybox.judgement import beside_nominal, far_or_vague, gains_off, on_bounds, rests_on
from suspid.greybox.late_causes import fit_drives
from suspid.greybox.modal import modes_with, mounted_car, of_car
from suspid.greybox.onset import from_onset
from suspid.greybox.problem import Problem, default_holds
from suspid.greybox.rolling import Speed, rolling_of, without_speed
from suspid.greybox.time_domain import fit_in_time
from suspid.greybox.trials import RecordTest, Trial, trials_of
from suspid.greybox.whole_car import check_road, fit_with_road
from suspid.model import Suspension, check_linear, eigenmodes
from suspid.reconstruction import Bounds, Unknowns, parameter_names, unknowns_of
from suspid.signals import as_response
from suspid.threads import in_one_thread
from suspid.units import Hertz, Metre, RadianPerSecond, Ratio, Second
from suspid.values import frozen_real
from suspid.wording import Argument
from suspid.words import Check, Level, Number, Remark, Verdict
from suspid.words.greybox import EstimateCheck, EstimateHeadline


@explained
@in_one_thread
def estimate(
    records: RecordLike | RecordTest | Sequence[RecordLike | RecordTest],
    suspension: Suspension,
    *,
    given: Sequence[str] = (),
    fixed: Sequence[str] = (),
    bounds: Bounds | None = None,
    ties: Sequence[Sequence[str]] = (),
    nominal_std: Ratio | Mapping[str, Ratio] | None = None,
    free_masses: Sequence[str] = (),
    gains: Sequence[str] | None = None,
    delays: Sequence[str] | None = None,
    mounts: Sequence[str] | None = None,
    band_hz: tuple[Hertz, Hertz] | None = None,
    stretch: Second | None = None,
    road: Literal["iso8608"] | None = None,
    speed: Speed | Sequence[Speed] | None = None,
    wheel_radius: Metre | None = None,
) -> Estimate:
    """Estimate the stiffness and the damping of every strut straight from records, for known topology.

    A free decay, or a record under exactly known roads or forces, is explained as motion of the suspension from an
    unknown start, plus an offset and white noise of unknown level on every channel. The start and the offsets are
    linear and eliminated; stiffnesses, dampings and free masses are found by maximum likelihood over all records
    jointly: Gauss-Newton steps with analytic derivatives, from several starts, along growing stretches of the records.

    In everyday driving the road is unknown, but the wheels' motion can be measured. If it is given, the equations of
    the wheels are not used: road, tires and wheel masses cancel. The noise of the wheels' sensors is allowed for
    (errors in variables, in the frequency domain), their true motion is free at every frequency, and forces on the
    body (engine, wind) go into a noise of unknown smooth spectrum.

    With ``road="iso8608"`` a model of the road comes in as a second step, after springs and dampers: the spectrum of
    each wheel's motion is a power law of free exponent and of free level in every stretch, with smooth departures,
    plus wheel orders, through the whole car. It gives the tires, the wheels' masses if they are free, the modes of the
    whole car, and the road itself.

    Parameters
    ----------
    records : control.TimeResponseData, RecordTest, what `as_record` takes, or a sequence of them
        Measured motions as outputs, named as the outputs of `statespace` or as the sensors of the suspension, in SI
        units; a unit in brackets behind the name, ``"chassis [mm]"``, is converted. Causes are inputs or outputs.
    suspension : Suspension
        Known masses and topology; its k and c are the nominal values: the start, and the value of what is held. A
        strut of nominal stiffness 0 is a damper alone and stays one.
    given : sequence of str
        What moves the car. Roads, and forces named as in `statespace`, count as exactly known; roads that are not
        given stand still. Coordinates, such as ``("tire",)``, are given as measured by the channels. ``"roads"`` and
        ``"wheels"`` are all of them. Empty: a free decay.
    fixed, bounds, ties, nominal_std, free_masses : optional
        What of struts and masses is held, bounded, equal, known beforehand, and unknown, as in `reconstruct`. A given
        force gives unknown masses a scale, as known ones do.
    gains, delays : sequence of str, optional
        Channels whose gain [1], or delay behind the other channels [s], is unknown. Default: where motion is given, all
        that show nothing but given motion; else none. Of all channels together only ratios of gains and differences of
        delays can be found, and no delays under known roads and forces. Given motion may be seconds late or early.
    mounts : sequence of str, optional
        Struts whose damper may stand on a mount of unknown stiffness: the strut is ``k + c s / (1 + tau s)`` with
        relaxation tau [s]. Default: where motion is given, all that have a damper and act between given and other
        coordinates; else none. A rubber mount of 1e6 N/m that is left out makes k of a driven car 20 % too large.
    band_hz : (float, float), optional
        Frequencies that are used where motion is given, and only there [Hz]. Default: from 0.4 times the lowest
        natural frequency of the nominal car to 2.5 times the highest.
    stretch : float, optional
        Length of the stretches that are transformed where motion is given [s]. Default: eight periods of the lowest
        mode.
    road : "iso8608", optional
        Model of the road, where the motion of wheels is given. Default: none; tires then stay at their nominal values.
        The damping of tires counts as known to 50 % unless it has a `nominal_std` or is fixed.
    speed : float, str, array or sequence of them, optional
        Speed of the car [m/s], for a model of the road: a number, the name of a channel, or the speed at each sample;
        with several records one for all, or one for each.
    wheel_radius : float, optional
        Rolling radius of the wheels [m], to about 2 %; with the speed it gives the frequencies of unbalanced wheels.

    Returns
    -------
    Estimate
        ``suspension``, ``covariance``, ``modes`` and what else there is to know; ``str()`` is the table.

    Raises
    ------
    InputError
        If an argument is of the wrong type, a name is unknown, or arguments contradict each other; if a coordinate
        that is not given stands on a road while the motion of another is given.
    RecordError
        If a record cannot be used, or no channel of it measures the suspension.
    EstimationError
        If the records do not determine a combination of the unknowns, which is named.

    Notes
    -----
    Without a given force the records determine ratios to the masses alone: all intervals hold for the masses as given.
    How an input moves between two samples (on a cubic spline, on straight lines, or in steps) is taken from the record:
    as it explains the motion best. Residuals that are not white widen the intervals by their spectrum.

    Where motion is given, `fitted` and `residual` hold the band alone, and whether the residual of the outputs follows
    the given motion is tested: it does where the car lacks something, such as the other axle. Intervals are those of
    the scores' scatter over all spectral lines. Delay and mount of one strut are nearly the same thing where the mount
    is stiff; hold one of them (``delays=()``) where it is known.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import add_noise, free_decay, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> record = free_decay(car, np.arange(0, 3, 0.005), initial_state={"v_tire": 1.0})
    >>> noisy = add_noise(record, snr_db=30.0, rng=np.random.default_rng(1))
    >>> nominal = car.with_parameters(stiffness={"chassis": 15e3, "tire": 250e3}, damping={"chassis": 1000})
    >>> found = estimate(noisy, nominal, fixed=["tire.damping"])
    >>> low, high = found.interval(0.99)["chassis.damping"]
    >>> bool(low < 1500 < high and high - low < 50)
    True
    """
    _check(suspension)
    trials = trials_of(records, suspension, given)
    check_road(trials, road=road, rolling=(speed, wheel_radius))
    driven = [bool(trial.wheels) for trial in trials]
    if any(driven) and not all(driven):
        raise InputError(
            Argument("given"),
            f": record {driven.index(True) + 1} has a cause that is measured motion of the car and record "
            f"{driven.index(False) + 1} has none; estimate from either, and give the result of one as ",
            Argument("nominal_std"),
        )
    if not any(driven):
        _check_unused({"band_hz": band_hz, "stretch": stretch})
    beyond = _beyond(suspension, trials)
    unknowns = unknowns_of(
        suspension,
        rate=_usual_frequency(suspension),
        fixed=[*([fixed] if isinstance(fixed, str) else fixed), *(() if road else beyond)],
        bounds=bounds,
        ties=ties,
        nominal_std=nominal_std,
        free_masses=free_masses,
    )
    if road:
        rolling = rolling_of(records, trials, speed=speed, radius=wheel_radius)
        trials = without_speed(trials, rolling)
        fit = fit_with_road(
            unknowns, trials, rolling, beyond=beyond, gains=gains, delays=delays, mounts=mounts, band=band_hz,
            stretch=stretch,
        )  # fmt: skip
    elif any(driven):
        options = {"gains": gains, "mounts": mounts, "stretch": stretch}
        fit = fit_drives(suspension, trials, unknowns, delays=delays, band=band_hz, options=options)
    else:
        unknowns = further_asked(unknowns, trials, gains=gains, delays=delays, mounts=mounts)
        fit = fit_in_time(Problem(trials=trials, holds=default_holds(trials), unknowns=unknowns))
        if not fit.explains and not any(len(trial.inputs) for trial in trials):
            fit, trials = _from_onset(fit, trials, unknowns)
    u = unknowns
    parameters = (*u.names, *fit.extras)
    turned = np.zeros((len(parameters), len(fit.covariance)))
    turned[: len(u.names), : len(u)] = u.spread[u.rows]
    turned[len(u.names) :, len(u) :] = np.diag(fit.extra_scale)
    covariance = turned @ fit.covariance @ turned.T
    values = np.append(u.parameters(fit.x)[u.rows], fit.extra_values)
    std = np.sqrt(np.diag(covariance))
    car = mounted_car(u.suspension(fit.x), parameters, values, std)
    unused = tuple(dict.fromkeys(name for trial in trials for name in trial.unused))
    still = () if road else tuple(suspension.coordinates[i] for i in trials[0].wheels)
    own = of_car(u)
    ranges = np.vstack([np.column_stack([u.lower, u.upper])[u.column] * u.scale[u.column, None], fit.extra_ranges])
    unbounded = values if fit.pull is None else values + turned @ fit.pull
    apart = changed(suspension, Spread(parameters, values, covariance, unbounded, ranges, fit.explains))
    said = [one.remark.numbers["names"] for one in fit.checks if one.remark.code is EstimateCheck.TIRE_DAMPING]
    assumed = {str(name) for names in said if isinstance(names, tuple) for name in names}
    checks = [
        *fit.checks,
        *on_bounds(u, fit.x),
        *gains_off(parameters, values),
        beside_nominal(tuple(name for name in parameters if name in apart)),
        *far_or_vague(suspension, u.names[: len(own)], values[: len(own)], std[: len(own)], assumed=assumed),
        *rests_on(suspension, u.names, still=still, forced=any(len(trial.forces) for trial in trials)),
        *([Check(Remark(EstimateCheck.STILL, {"names": still}), Level.NOTE)] if still else []),
        *(
            [Check(Remark(EstimateCheck.CANCELS, {"names": beyond, "given": ", ".join(still)}), Level.NOTE)]
            if beyond and not road
            else []
        ),
        *([Check(Remark(EstimateCheck.UNUSED, {"names": unused}), Level.NOTE)] if unused else []),
        *([Check(Remark(EstimateCheck.DRIVEN), Level.DOUBTFUL)] if _driven(fit, trials) else []),
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


def _from_onset(fit: Fit, trials: tuple[Trial, ...], unknowns: Unknowns) -> tuple[Fit, tuple[Trial, ...]]:
    """Return the fit of the decays in records that begin before them, if that is nearer to an explanation."""
    later = from_onset(trials)
    if later is None:
        return fit, trials
    try:
        found = fit_in_time(Problem(trials=later, holds=default_holds(later), unknowns=unknowns))
    except EstimationError:
        return fit, trials
    if not found.explains and found.chi_square / max(found.freedom, 1) > fit.chi_square / max(fit.freedom, 1):
        return fit, trials
    numbers: dict[str, Number] = {"starts": ", ".join(f"{trial.start:.6g}" for trial in later)}
    note = Check(Remark(EstimateCheck.ONSET, numbers), Level.NOTE)
    return replace(found, checks=(*found.checks, note)), later


def _driven(fit: Fit, trials: Sequence[Trial]) -> bool:
    """Return whether records that count as free decays are not explained and do not die down."""
    free = all(not trial.wheels and not len(trial.inputs) for trial in trials)
    return free and not fit.explains and not any(dies_down(trial.values) for trial in trials)


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
                " is of no use here: free decays and records under known roads and forces are fitted in time; leave it "
                "out, or name measured motion in ",
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
