"""Frequencies of a body from its motion on unknown roads, without damping."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from suspid.arguments import explained
from suspid.cleaning import RecordLike, as_record
from suspid.errors import InputError, RecordError
from suspid.greybox.body_mode import BodyMode, BodyModes
from suspid.greybox.body_spectra import (
    LINE_WIDTH,
    LOWER,
    PERIODOGRAM,
    UPPER,
    WORTH,
    Fitted,
    Periodograms,
    Shape,
    fitted,
    misfit_without,
    periodograms,
    scattered,
)
from suspid.greybox.trials import records_of
from suspid.greybox.wheels import body_channels
from suspid.levels import likely
from suspid.model import Suspension, output_weights
from suspid.signals import PASSED, as_signal
from suspid.units import Hertz, Second
from suspid.words import Remark, count
from suspid.words.drives import BodyCheck

# Models: straight or bent roads, the damper's numerator as it follows or free, in bands that begin and end elsewhere.
# Below 0.5 Hz accelerometers show slopes and braking.
BANDS = ((0.5, 4.0), (0.5, 6.0), (0.7, 5.0))
LEAST_TOP: Hertz = 3.0  # where bands end at least: twice the frequency of the body of an ordinary car
FEWEST_PARTS = 6  # fewer say nothing of their scatter
AT_BOUND_SHARE = 0.02  # of the range of a parameter: nearer to an end it is not determined


@explained
def body_modes(
    records: RecordLike | Sequence[RecordLike],
    *,
    car: Suspension | None = None,
    channels: Sequence[str] | None = None,
    rng: np.random.Generator | None = None,
) -> BodyModes:
    """Return the natural frequency of the body from its motion on unknown roads.

    A resonance on an unknown road is fitted to the mean spectrum of all stretches. The slope of the road and the level
    of each window are free; a bent road, a free numerator of the damper and several bands are further models. The
    interval contains those of all models that the records do not reject; each has the scatter of a bootstrap over
    blocks of the drive. Damping is not reported: it depends on the model of the road by a factor of two.

    Parameters
    ----------
    records : control.TimeResponseData, or what `as_record` takes, or sequence of them
        Stretches of a drive, such as ``find_drives(…).records``; accelerations, unless a car says otherwise.
    car : Suspension, optional
        Says which channels are on the body, and what they measure.
    channels : sequence of str, optional
        Channels to use. Default: those that move with no wheel, else all.
    rng : numpy.random.Generator, optional
        Draws the blocks. Default: a fixed seed.

    Raises
    ------
    InputError
        If there is no record, or no such channel.
    RecordError
        If the stretches are too short or too few.

    Examples
    --------
    >>> from suspid import eigenmodes, quarter_car, road_profile, simulate
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> t = np.arange(0, 400, 0.01)
    >>> road = road_profile(20.0 * t, roughness="B", rng=np.random.default_rng(3))
    >>> found = body_modes([simulate(car, t, {"road": road}, outputs=["chassis_acceleration"])])
    >>> low, high = found[0].interval()
    >>> bool(low < eigenmodes(car).wn[0] / (2 * np.pi) < high)
    True
    """
    if isinstance(records, Sequence) and not records:
        raise InputError("there is no stretch of a drive; see find_drives")
    signals = [as_signal(as_record(record)) for record in records_of(records)]
    names = list(channels) if channels is not None else _on_body(signals[0].channels, car)
    for name in names:
        if any(name not in signal.channels for signal in signals):
            raise InputError(f"there is no channel {name!r} in every stretch")
    rng = np.random.default_rng(0) if rng is None else rng
    bands = _bands(max(signal.step for signal in signals))
    band = min(low for low, _ in bands), max(high for _, high in bands)
    modes = []
    for name in names:
        rows = [(signal.values[signal.channels.index(name)], signal.step) for signal in signals]
        order = 2 if car is None else _order(car, name)
        modes.append(_mode(name, periodograms(rows, order=order, band=band), bands, rng))
    return BodyModes(modes=tuple(modes), seconds=float(sum(signal.duration for signal in signals)))


def _bands(step: Second) -> tuple[tuple[Hertz, Hertz], ...]:
    """Return the bands of the models, up to what the sampling passes.

    Raises
    ------
    RecordError
        If too little remains.
    """
    top = PASSED / step
    if top < LEAST_TOP:
        raise RecordError(
            f"{1 / step:.4g} Hz is too slow for the body's frequency: at that rate the spectrum is known up to "
            f"{top:.2g} Hz, and {LEAST_TOP:g} Hz are needed; record with {LEAST_TOP / PASSED:g} Hz at least"
        )
    return tuple(dict.fromkeys((low, min(high, top)) for low, high in BANDS))


def _on_body(channels: Sequence[str], car: Suspension | None) -> list[str]:
    """Return the channels that show no wheel; all, if every channel does."""
    if car is None:
        return list(channels)
    return list(body_channels(car, channels) or channels)


def _order(car: Suspension, channel: str) -> int:
    return output_weights(car, channel)[0]


def _mode(
    channel: str, spectra: Periodograms, bands: Sequence[tuple[Hertz, Hertz]], rng: np.random.Generator
) -> BodyMode:
    blocks = np.unique(spectra.blocks)
    if len(blocks) < FEWEST_PARTS:
        parts = count(len(blocks), "part")
        raise RecordError(
            f"{len(spectra.power)} windows of {PERIODOGRAM:g} s in {parts} of the drive are too few for intervals; "
            f"{FEWEST_PARTS} parts of {PERIODOGRAM / 2 * 6:g} s are needed: record a longer drive"
        )
    mean, nothing = spectra.mean, float("nan")
    worth = WORTH * len(spectra.power) / LINE_WIDTH
    shapes = [
        Shape(bent=bent, numerator=free, band=band)
        for band in bands
        for bent in (False, True)
        for free in (False, True)
    ]
    every = [fitted(shape, spectra.hertz, mean) for shape in shapes]
    kept = [one for one in every if not _ruled_out(one, every, worth)]
    gain = [worth * (misfit_without(spectra.hertz, mean, one.shape.band) - one.misfit) for one in kept]
    # A resonance has three parameters more than a smooth spectrum of the same slope; in every model it must be there.
    if any(likely(one, 3) for one in gain):
        return BodyMode(channel=channel, hertz=nothing, why=Remark(BodyCheck.NO_RESONANCE, {"channel": channel}))
    if any(_at_end(one) for one in kept):
        return BodyMode(channel=channel, hertz=nothing, why=Remark(BodyCheck.NOT_DETERMINED, {"channel": channel}))
    where = [np.flatnonzero(spectra.blocks == block) for block in blocks]
    # Draws of the bootstrap: standard deviations to 5 %.
    drawn = [np.concatenate([where[i] for i in rng.integers(0, len(where), len(where))]) for _ in range(200)]
    means = np.array([np.mean(spectra.power[rows], axis=0) for rows in drawn])
    models = [
        (one.hertz, float(np.std(scattered(one, spectra.hertz, mean, means, worth=worth), ddof=1))) for one in kept
    ]
    low, high = min(f for f, _ in models), max(f for f, _ in models)
    return BodyMode(
        channel=channel, hertz=0.5 * (low + high), models=tuple(models), zetas=tuple(one.zeta for one in kept)
    )


def _ruled_out(one: Fitted, every: Sequence[Fitted], worth: float) -> bool:
    """Return whether a model of the same band with more freedom fits so much better that chance is no explanation."""
    for other in every:
        more = len(other.shape.free) - len(one.shape.free)
        if other.shape.band == one.shape.band and more > 0 and not likely(worth * (one.misfit - other.misfit), more):
            return True
    return False


def _at_end(one: Fitted) -> bool:
    """Return whether frequency or damping ended at a bound, or beyond the band: there is no peak of a mode."""
    share = (one.parameters - LOWER) / (UPPER - LOWER)
    ended = np.any((share[2:4] < AT_BOUND_SHARE) | (share[2:4] > 1 - AT_BOUND_SHARE))
    return bool(ended) or one.hertz > one.shape.band[1]
