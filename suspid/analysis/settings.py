"""Settings: everything that `analyse` may be told, in one frozen value."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Literal, TypeAlias

from suspid.errors import InputError
from suspid.identification import Method
from suspid.reconstruction import Bounds
from suspid.units import Hertz, Kilogram, RadianPerSecond, Ratio, Second

Pairs: TypeAlias = Mapping[str, str] | tuple[tuple[str, str], ...]
Factors: TypeAlias = Mapping[str, float] | tuple[tuple[str, float], ...]


@dataclass(frozen=True, kw_only=True, slots=True)
class CarSettings:
    """How springs and dampers are reconstructed; the meaning of each is that in `suspid.reconstruct`.

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


@dataclass(frozen=True, kw_only=True, slots=True)
class Settings:
    """What `analyse` may be told about a recording; the defaults ask for nothing.

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
    time : str, optional
        Column of time.
    fs : float, optional
        Sampling rate [Hz].
    dbc : str or path, optional
        Database that decodes the raw CAN frames of an MDF file.
    start, stop : float, optional
        First and last time to use [s]. Given, no decay is searched for.
    decay : {"auto", "whole", "all"} or int
        Which decay of the recording to use: the best one where the largest motion does not come first ("auto"), the
        whole record, all decays jointly, or the one of this rank.
    modes : int, optional
        Number of modes.
    method : {"likelihood", "ridge"}
        See `suspid.identify`.
    band : (float, float), optional
        Angular frequencies between which to look [rad/s].
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
        If settings contradict each other.

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
    time: str | None = None
    fs: Hertz | None = None
    dbc: str | os.PathLike[str] | None = None
    start: Second | None = None
    stop: Second | None = None
    decay: Literal["auto", "whole", "all"] | int = "auto"
    modes: int | None = None
    method: Method = "likelihood"
    band: tuple[RadianPerSecond, RadianPerSecond] | None = None
    bandwidth: float | None = None
    candidates: tuple[float, ...] = tuple(float(n) for n in range(1, 51))
    level: Ratio = 0.95
    springs: CarSettings = field(default_factory=CarSettings)

    def __post_init__(self) -> None:
        for name in ("rename", "scale"):
            given = getattr(self, name)
            object.__setattr__(self, name, tuple(given.items() if isinstance(given, Mapping) else given))
        if self.decay not in ("auto", "whole", "all") and not (isinstance(self.decay, int) and self.decay > 0):
            raise InputError(f"decay={self.decay!r} must be 'auto', 'whole', 'all' or a rank from 1 on")
        if self.decay not in ("auto", "whole") and (self.start is not None or self.stop is not None):
            raise InputError("give either decay, or start and stop")
        if self.decay == "all" and self.method != "likelihood":
            raise InputError(
                f"decay='all' fits all decays jointly by likelihood; method={self.method!r} takes one decay at a time"
            )
        if not 0 < self.level < 1:
            raise InputError(f"level={self.level:g} must lie between 0 and 1")

    def to_dict(self) -> dict[str, object]:
        """Return the settings as plain values, for JSON.

        Examples
        --------
        >>> Settings(scale={"seat": -1.0}).to_dict()["scale"]
        {'seat': -1.0}
        """
        plain = asdict(self)
        return plain | {
            "rename": dict(self.rename),
            "scale": dict(self.scale),
            "dbc": None if self.dbc is None else os.fspath(self.dbc),
        }
