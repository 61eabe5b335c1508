"""Settings: all options of `analyse` in one frozen value."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, TypeAlias, get_args

from suspid.analysis import fields
from suspid.errors import InputError
from suspid.identification import Method
from suspid.levels import LEVEL
from suspid.reconstruction import Bounds
from suspid.units import Hertz, Kilogram, Ratio, Second
from suspid.wavelets import BANDWIDTHS
from suspid.wording import Argument

Pairs: TypeAlias = Mapping[str, str] | tuple[tuple[str, str], ...]
Factors: TypeAlias = Mapping[str, float] | tuple[tuple[str, float], ...]


@dataclass(frozen=True, kw_only=True, slots=True)
class CarSettings:
    """How springs and dampers are reconstructed; the meaning of each is that in `suspid.reconstruct`.

    Raises
    ------
    InputError
        If a value is of the wrong type or cannot be meant; the message names it and says what to give.

    Examples
    --------
    >>> CarSettings(fixed=("seat",), nominal_std=0.1).fixed
    ('seat',)
    """

    fixed: tuple[str, ...] = ()
    bounds: Bounds = field(default_factory=dict)
    ties: tuple[tuple[str, ...], ...] = ()
    nominal_std: Ratio | Mapping[str, Ratio] | None = None
    free_masses: tuple[str, ...] = ()
    added_masses: Mapping[str, Kilogram] = field(default_factory=dict)
    tolerance: Ratio | None = None
    search: bool = True
    constraints: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name, check in SPRING_FIELDS.items():
            object.__setattr__(self, name, check(name, getattr(self, name)))

    def to_dict(self) -> dict[str, object]:
        """Return the settings as plain values, for JSON.

        Examples
        --------
        >>> CarSettings(added_masses={"seat": 75}).to_dict()["added_masses"]
        {'seat': 75.0}
        """
        return {name: _plain(getattr(self, name)) for name in SPRING_FIELDS}


@dataclass(frozen=True, kw_only=True, slots=True)
class Settings:
    """Options of `analyse`; the defaults need no information about the recording.

    Parameters
    ----------
    channels, without : tuple of str
        Channels to use (None: all), and channels to leave out.
    rename, scale : mapping
        New names and factors by channel.
    vertical : (str, str, str), optional
        Three axes of a tilted accelerometer; their vertical replaces them.
    si : bool
        Convert channels to SI by the units that the file states.
    test : str, optional
        Which of several tests in the file, or "all" to join them. Default: the first, with a doubt.
    time : str, optional
        Column of time.
    fs : float, optional
        Sampling rate [Hz].
    dbc : str or path, optional
        Database that decodes the raw CAN frames of an MDF file.
    start, stop : float, optional
        First and last time to use [s]. From a first one on, a decay is searched for only where none begins there; a
        last one alone does not say where it begins.
    decay : {"auto", "whole", "all"} or int
        Which decay of the recording to use: the best one where the largest motion does not come first ("auto"), the
        whole record, all decays jointly, or the one of this rank.
    modes : int, optional
        Number of modes.
    method : {"likelihood", "ridge"}
        See `suspid.identify`.
    band_hz : (float, float), optional
        Frequency range [Hz].
    bandwidth : float, optional
        Bandwidth N of the wavelet [1].
    candidates : tuple of float
        Bandwidths among which the one of least entropy is chosen [1].
    level : float
        Probability of the intervals [1].
    springs : CarSettings
        How springs and dampers are reconstructed.

    Raises
    ------
    InputError
        If a value is of the wrong type or cannot be meant, or settings contradict each other; the message names the
        setting and says what to give.

    Examples
    --------
    >>> Settings(channels=("seat",), modes=2).modes
    2
    """

    channels: tuple[str, ...] | None = None
    without: tuple[str, ...] = ()
    rename: Pairs = ()
    scale: Factors = ()
    vertical: tuple[str, str, str] | None = None
    si: bool = False
    test: str | None = None
    time: str | None = None
    fs: Hertz | None = None
    dbc: str | os.PathLike[str] | None = None
    start: Second | None = None
    stop: Second | None = None
    decay: Literal["auto", "whole", "all"] | int = "auto"
    modes: int | None = None
    method: Method = "likelihood"
    band_hz: tuple[Hertz, Hertz] | None = None
    bandwidth: float | None = None
    candidates: tuple[float, ...] = tuple(float(n) for n in BANDWIDTHS)
    level: Ratio = LEVEL
    springs: CarSettings = field(default_factory=CarSettings)

    def __post_init__(self) -> None:
        for name, check in SETTING_FIELDS.items():
            object.__setattr__(self, name, check(name, getattr(self, name)))
        if self.start is not None and self.stop is not None and not self.start < self.stop:
            raise InputError(
                Argument("start", f"{self.start:g}"), " s must lie before ", Argument("stop", f"{self.stop:g}"), " s"
            )
        if self.decay not in ("auto", "whole") and (self.start is not None or self.stop is not None):
            raise InputError("give either ", Argument("decay"), ", or ", Argument("start"), " and ", Argument("stop"))
        if self.decay == "all" and self.method != "likelihood":
            raise InputError(
                Argument("decay", "'all'"),
                " fits all decays jointly by likelihood; ",
                Argument("method", repr(self.method)),
                " takes one decay at a time",
            )

    def to_dict(self) -> dict[str, object]:
        """Return the settings as plain values, for JSON.

        Examples
        --------
        >>> Settings(scale={"seat": -1.0}).to_dict()["scale"]
        {'seat': -1.0}
        """
        return {name: _plain(getattr(self, name)) for name in SETTING_FIELDS}


def _plain(value: object) -> object:
    """Return a value of a setting in types that JSON knows."""
    if isinstance(value, CarSettings):
        return value.to_dict()
    if isinstance(value, Mapping):
        return dict(value)
    return os.fspath(value) if isinstance(value, os.PathLike) else value


def _decay(name: str, value: object) -> str | int:
    if isinstance(value, str) and value in ("auto", "whole", "all"):
        return value
    try:
        return fields.rank(name, value)
    except InputError:
        raise fields.wrong(name, value, "must be 'auto', 'whole', 'all' or a rank from 1 on") from None


def _method(name: str, value: object) -> str:
    if not isinstance(value, str) or value not in get_args(Method):
        raise fields.wrong(name, value, f"is unknown; the methods are {', '.join(get_args(Method))}")
    return value


def _springs(name: str, value: object) -> CarSettings:
    if not isinstance(value, CarSettings):
        raise fields.wrong(name, value, "give CarSettings, such as CarSettings(fixed=('tire.damping',))")
    return value


# How each setting is checked, in the order of the fields.
SPRING_FIELDS: Mapping[str, fields.Check] = {
    "fixed": fields.names,
    "bounds": fields.bounds,
    "ties": fields.groups,
    "nominal_std": fields.none_or(fields.relative_stds),
    "free_masses": fields.names,
    "added_masses": fields.masses,
    "tolerance": fields.none_or(fields.positive),
    "search": fields.flag,
    "constraints": fields.texts,
}
SETTING_FIELDS: Mapping[str, fields.Check] = {
    "channels": fields.none_or(fields.some_names),
    "without": fields.names,
    "rename": fields.new_names,
    "scale": fields.factors,
    "vertical": fields.none_or(fields.axes),
    "si": fields.flag,
    "test": fields.none_or(fields.text),
    "time": fields.none_or(fields.text),
    "fs": fields.none_or(fields.positive),
    "dbc": fields.none_or(fields.path),
    "start": fields.none_or(fields.number),
    "stop": fields.none_or(fields.number),
    "decay": _decay,
    "modes": fields.none_or(fields.rank),
    "method": _method,
    "band_hz": fields.none_or(fields.limits),
    "bandwidth": fields.none_or(fields.positive),
    "candidates": fields.numbers_above_zero,
    "level": fields.probability,
    "springs": _springs,
}
