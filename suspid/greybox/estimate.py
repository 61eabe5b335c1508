"""Springs, dampers and masses of a suspension straight from records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

from suspid.arguments import explained
from suspid.cleaning import RecordLike
from suspid.greybox.axle_data import Led
from suspid.greybox.estimates import Estimate
from suspid.greybox.fitted_car import Asked, fitted_car
from suspid.greybox.record_test import RecordTest
from suspid.greybox.rolling import Speed
from suspid.model import Suspension
from suspid.reconstruction import Bounds
from suspid.threads import in_one_thread
from suspid.units import Hertz, Metre, Ratio, Second


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
    noisy: Sequence[str] | None = None,
    band_hz: tuple[Hertz, Hertz] | None = None,
    stretch: Second | None = None,
    road: Literal["iso8608"] | None = None,
    speed: Speed | Sequence[Speed] | None = None,
    wheel_radius: Metre | None = None,
    behind: Led | None = None,
) -> Estimate:
    """Estimate stiffness and damping of every strut directly from records, for known topology.

    A free decay, or a record under known roads or forces, is explained as motion of the suspension from an unknown
    start, plus an offset and white noise of unknown level on every channel. The start and the offsets are
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
        units; a unit in brackets behind the name, ``"chassis [mm]"``, is converted. Causes are inputs or outputs. Of
        several the verdict says where they are not of one car with the same springs and dampers.
    suspension : Suspension
        Known masses and topology; its k and c are the nominal values: the start, and the values of fixed parameters. A
        strut of nominal stiffness 0 is a damper alone and stays one.
    given : sequence of str
        What moves the car. Roads, and forces named as in `statespace`, count as exactly known unless they are `noisy`;
        roads that are not given do not move. Coordinates, such as ``("tire",)``, are given as measured by the channels.
        ``"roads"`` and ``"wheels"`` are all of them. Empty: a free decay.
    fixed, bounds, ties, nominal_std, free_masses : optional
        Fixed, bounded and tied parameters, prior knowledge, and unknown masses, as in `reconstruct`. A given
        force gives unknown masses a scale, as known ones do.
    gains, delays : sequence of str, optional
        Channels whose gain [1], or delay behind the other channels [s], is unknown. Default: where motion is given, all
        that show nothing but given motion; else those without which the records are not explained. A known road or
        force is a channel, too: beside it, gains and delays of all others can be found; without one, only ratios of
        gains and differences of delays. Given motion, and channels beside a known road or force, may be seconds late.
    mounts : sequence of str, optional
        Struts whose damper may have a mount of unknown stiffness: the strut is ``k + c s / (1 + tau s)`` with
        relaxation tau [s]. Default: where motion is given, all that have a damper and act between given and other
        coordinates; else those without which the records are not explained. A rubber mount of 1e6 N/m that is left out
        makes k of a driven car 20 % too large.
    noisy : sequence of str, optional
        Given roads and forces that are measured with noise of unknown level: it moves no part of the car, so it is in
        the likelihood (errors in variables, as where motion is given). Default: where the records hold such noise.
    band_hz : (float, float), optional
        Frequencies that are used where motion is given, or causes are `noisy`, and only there [Hz]. Default: from 0.4
        times the lowest natural frequency of the nominal car to 2.5 times the highest.
    stretch : float, optional
        Length of the stretches that are transformed where motion is given, or causes are `noisy` [s]. Default: eight
        periods of the lowest mode; 24 of them where causes are noisy.
    road : "iso8608", optional
        Model of the road, where the motion of wheels is given. Default: none; tires then stay at their nominal values.
        The damping of tires counts as known to 50 % unless it has a `nominal_std` or is fixed.
    speed : float, str, array or sequence of them, optional
        Speed of the car [m/s], for a model of the road: a number, the name of a channel, or the speed at each sample;
        with several records one for all, or one for each.
    wheel_radius : float, optional
        Rolling radius of the wheels [m], to about 2 %; with the speed it gives the frequencies of unbalanced wheels.
    behind : mapping of str to (str, float), optional
        Which road meets what another has met, and how far behind [m], to some 10 %: ``{"road_rear": ("road_front",
        2.7)}`` for two axles on one track, whose wheels are given; of four wheels each rear one follows a front one,
        ``{"road_rear_left": ("road_front_left", 2.7), "road_rear_right": ("road_front_right", 2.7)}``. Where wheels
        roll over the same road, tires and wheel masses are found without a model of its spectrum, several times better.
        How far the roads are the same is estimated; if they are not, each axle is fitted by itself as without. Needs
        the speed.

    Returns
    -------
    Estimate
        ``suspension``, ``covariance``, ``modes`` and more; ``str()`` is the table.

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
    How an input moves between two samples (on a spline of third or fifth degree, on straight lines, or in steps) is
    taken from the record: as it explains the motion best. Residuals that are not white widen the intervals by their
    spectrum.

    Where motion is given, `fitted` and `residual` contain the band only, and whether the residual of the outputs
    follows the given motion is tested: it does where the car lacks something, such as the other axle. Intervals are
    those of the scores' scatter over all spectral lines. Delay and mount of one strut are nearly the same thing where
    the mount is stiff; fix one of them (``delays=()``) where it is known.

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
    asked = Asked(
        given=given,
        fixed=fixed,
        bounds=bounds,
        ties=ties,
        nominal_std=nominal_std,
        free_masses=free_masses,
        gains=gains,
        delays=delays,
        mounts=mounts,
        noisy=noisy,
        band_hz=band_hz,
        stretch=stretch,
        road=road,
        speed=speed,
        wheel_radius=wheel_radius,
        behind=behind,
    )
    return fitted_car(records, suspension, asked)
