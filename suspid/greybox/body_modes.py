"""Frequencies of a body from its motion on unknown roads, without damping."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import overload

import numpy as np

from suspid.arguments import explained
from suspid.cleaning import RecordLike, as_record
from suspid.errors import InputError, RecordError
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
from suspid.levels import LEVEL, check_level, likely, normal_reach
from suspid.model import Suspension, output_weights
from suspid.signals import as_signal
from suspid.text_tables import text_table
from suspid.units import Hertz, Ratio
from suspid.words import Check, Level, Remark, Verdict
from suspid.words.drives import BodyCheck

# Models: straight or bent roads, the damper's numerator as it follows or free, in bands that begin and end elsewhere.
# Below 0.5 Hz accelerometers show slopes and braking.
BANDS = ((0.5, 4.0), (0.5, 6.0), (0.7, 5.0))
SHAPES = tuple(
    Shape(bent=bent, numerator=free, band=band) for band in BANDS for bent in (False, True) for free in (False, True)
)
FEWEST_PARTS = 6  # fewer say nothing of their scatter
AT_BOUND_SHARE = 0.02  # of the range of a parameter: nearer to an end it is not determined


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class BodyMode:
    """The frequency of the body from one channel.

    Parameters
    ----------
    channel : str
        The channel.
    hertz : float
        Natural frequency [Hz]: the middle of the models that fit; NaN where there is no resonance, or it is not
        determined.
    models : tuple of (float, float)
        Frequency and standard deviation [Hz] of each model of road and damper that the records do not reject.
    zetas : tuple of float
        Damping ratio [1] of each: they differ, which is why none is reported.
    why : Remark or None
        Why there is no frequency.

    Examples
    --------
    >>> mode = BodyMode(channel="seat", hertz=1.2, models=((1.15, 0.02), (1.25, 0.02)), zetas=(0.2, 0.4), why=None)
    >>> low, high = mode.interval(0.95)
    >>> round(low, 2), round(high, 2)
    (1.11, 1.29)
    """

    channel: str
    hertz: Hertz
    models: tuple[tuple[Hertz, Hertz], ...] = ()
    zetas: tuple[Ratio, ...] = ()
    why: Remark | None = None

    def interval(self, level: Ratio = LEVEL) -> tuple[Hertz, Hertz]:
        """Return the bounds [Hz] that contain the intervals of all models.

        Examples
        --------
        >>> from suspid import BodyMode
        >>> mode = BodyMode(channel="seat", hertz=1.2, models=((1.2, 0.1),))
        >>> round((mode.interval(0.95)[1] - 1.2) / 0.1, 2)
        1.96
        """
        check_level(level)
        if not self.models:
            return float("nan"), float("nan")
        reach = normal_reach(level)
        return min(f - reach * s for f, s in self.models), max(f + reach * s for f, s in self.models)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class BodyModes(Sequence[BodyMode]):
    """Frequencies of the body, one for each channel, as a sequence.

    Parameters
    ----------
    modes : tuple of BodyMode
        One for each channel.
    seconds : float
        Length of the stretches that were used [s].

    Examples
    --------
    >>> mode = BodyMode(channel="seat", hertz=1.2, models=((1.15, 0.02), (1.25, 0.02)), zetas=(0.2, 0.4), why=None)
    >>> print(BodyModes(modes=(mode,), seconds=300.0))
      channel    f [Hz]    95 % interval      zeta [1]
    ---------  --------  ---------------  ------------
         seat       1.2      1.11 … 1.29  not reported
    Verdict: the body's frequency in 1 of the channels, from 300 s: sound. Every check that could be made was passed.
    note: Damping is not reported: depending on the model of the road it would be 0.2 or 0.4. ...
    """

    modes: tuple[BodyMode, ...]
    seconds: float

    def __len__(self) -> int:
        return len(self.modes)

    def __iter__(self) -> Iterator[BodyMode]:
        return iter(self.modes)

    @overload
    def __getitem__(self, index: int) -> BodyMode: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[BodyMode, ...]: ...

    def __getitem__(self, index: int | slice) -> BodyMode | tuple[BodyMode, ...]:
        return self.modes[index]

    @property
    def verdict(self) -> Verdict:
        """What was found, and why damping is not reported.

        Examples
        --------
        >>> from suspid import BodyMode, BodyModes
        >>> mode = BodyMode(channel="seat", hertz=1.2, models=((1.15, 0.02), (1.25, 0.02)), zetas=(0.2, 0.4), why=None)
        >>> BodyModes(modes=(mode,), seconds=300.0).verdict.level.label
        'sound'
        """
        found = [mode for mode in self.modes if mode.models]
        checks = [Check(mode.why, Level.NOTE if found else Level.NONE) for mode in self.modes if mode.why is not None]
        if found:
            zetas = [zeta for mode in found for zeta in mode.zetas]
            refused = Remark(BodyCheck.NO_DAMPING, {"low": min(zetas), "high": max(zetas)})
            checks += [Check(refused, Level.NOTE), Check(Remark(BodyCheck.ONE_EACH), Level.NOTE)]
        return Verdict(Remark(BodyCheck.FOUND, {"channels": len(found), "seconds": self.seconds}), tuple(checks))

    def table(self, level: Ratio = LEVEL) -> str:
        """Return the table of frequencies with intervals.

        Examples
        --------
        >>> from suspid import BodyMode, BodyModes
        >>> mode = BodyMode(channel="seat", hertz=1.2, models=((1.15, 0.02), (1.25, 0.02)), zetas=(0.2, 0.4), why=None)
        >>> print(BodyModes(modes=(mode,), seconds=300.0).table(0.68))
          channel    f [Hz]    68 % interval      zeta [1]
        ---------  --------  ---------------  ------------
             seat       1.2      1.13 … 1.27  not reported
        """
        ends = [mode.interval(level) for mode in self.modes]
        return text_table(
            {
                "channel": [mode.channel for mode in self.modes],
                "f [Hz]": [f"{mode.hertz:.3g}" if mode.models else "none" for mode in self.modes],
                f"{100 * level:g} % interval": [f"{a:.3g} … {b:.3g}" if np.isfinite(a) else "" for a, b in ends],
                "zeta [1]": ["not reported" for _ in self.modes],
            }
        )

    def __str__(self) -> str:
        return f"{self.table()}\n{self.verdict}"


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
    modes = []
    for name in names:
        rows = [(signal.values[signal.channels.index(name)], signal.step) for signal in signals]
        order = 2 if car is None else _order(car, name)
        modes.append(_mode(name, periodograms(rows, order=order, band=(BANDS[0][0], BANDS[1][1])), rng))
    return BodyModes(modes=tuple(modes), seconds=float(sum(signal.duration for signal in signals)))


def _on_body(channels: Sequence[str], car: Suspension | None) -> list[str]:
    """Return the channels that show no wheel; all, if every channel does."""
    if car is None:
        return list(channels)
    return list(body_channels(car, channels) or channels)


def _order(car: Suspension, channel: str) -> int:
    return output_weights(car, channel)[0]


def _mode(channel: str, spectra: Periodograms, rng: np.random.Generator) -> BodyMode:
    blocks = np.unique(spectra.blocks)
    if len(blocks) < FEWEST_PARTS:
        raise RecordError(
            f"{len(spectra.power)} windows of {PERIODOGRAM:g} s in {len(blocks)} parts of the drive are too few for "
            f"intervals; {FEWEST_PARTS} parts of {PERIODOGRAM / 2 * 6:g} s are needed: record a longer drive"
        )
    mean, nothing = spectra.mean, float("nan")
    worth = WORTH * len(spectra.power) / LINE_WIDTH
    every = [fitted(shape, spectra.hertz, mean) for shape in SHAPES]
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
    """Return whether frequency or damping ended at a bound: the spectrum has no peak that belongs to a mode."""
    share = (one.parameters - LOWER) / (UPPER - LOWER)
    return bool(np.any((share[2:4] < AT_BOUND_SHARE) | (share[2:4] > 1 - AT_BOUND_SHARE)))
