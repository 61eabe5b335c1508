"""Settings of a fleet's run as plain values, for workers and manifest."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Literal

from suspid.analysis import CarSettings, Settings, check_springs
from suspid.errors import InputError
from suspid.fleet.manifest import environment
from suspid.fleet.tables import DECAYS, Layout, drives_layout
from suspid.greybox import DriveLimits, Led, behind_of, wheels_of
from suspid.model import Suspension, car_from_toml
from suspid.units import Metre, Second
from suspid.wording import Argument


@dataclass(frozen=True, kw_only=True, slots=True)
class DriveJob:
    """What is asked of drives, as in `analyse_drive`."""

    limits: DriveLimits = field(default_factory=DriveLimits)
    way: Mapping[str, str | None] = field(default_factory=dict)
    road: Literal["iso8608"] | None = None
    wheel_radius: Metre | None = None
    behind: Led = field(default_factory=dict)
    # Where vehicles and dates come from, for the manifest; each record has its own.
    vehicles: str = "names"


@dataclass(frozen=True, kw_only=True, slots=True)
class Job:
    """What is done with every record."""

    settings: Settings = field(default_factory=Settings)
    # The car as TOML: python-control's models cannot be pickled, and the manifest holds text.
    car: str | None = None
    time_limit: Second | None = None
    # None: the records are free decays.
    drive: DriveJob | None = None
    # What arguments are called in the reasons of failures, where a command asks; no part of what decides the results.
    options: Mapping[str, str] | None = None
    # Versions of the client, which those of every worker must equal.
    environment: Mapping[str, str] = field(default_factory=environment)

    @property
    def layout(self) -> Layout:
        """The tables that the records leave rows of."""
        if self.drive is None:
            return DECAYS
        return drives_layout(None if self.car is None else car_from_toml(self.car))

    def to_dict(self) -> dict[str, object]:
        """Return what decides the results, for the manifest."""
        return {
            **({} if self.drive is None else {"drives": asdict(self.drive)}),
            "settings": self.settings.to_dict(),
            "car": self.car,
            "time_limit": self.time_limit,
            "environment": dict(self.environment),
        }


def check_job(job: Job, car: Suspension | None) -> None:
    """Refuse at once what would be every record's failure."""
    settings = job.settings
    if job.time_limit is not None and not job.time_limit > 0:
        raise InputError(f"time_limit={job.time_limit} s must be positive")
    if car is None:
        if settings.springs != CarSettings():
            raise InputError("settings.springs needs a car")
        return
    if job.drive is None:
        check_springs(settings.springs, car)


def check_drive(job: Job, drive: DriveJob, car: Suspension | None) -> None:
    """Refuse at once what would be the failure of every drive."""
    settings, how = job.settings, job.settings.springs
    unused = {
        "springs.added_masses": how.added_masses, "springs.tolerance": how.tolerance,
        "springs.constraints": how.constraints, "modes": settings.modes, "band_hz": settings.band_hz,
        "vertical": settings.vertical,
    }  # fmt: skip
    for name, value in unused.items():
        if value:
            raise InputError(f"settings.{name} does not apply to drives; leave it out")
    for name, given in (("wheel_radius", drive.wheel_radius is not None), ("behind", bool(drive.behind))):
        if drive.road is None and given:
            raise InputError(
                Argument(name), " belongs to a model of the road: give ", Argument("road", '"iso8608"'), " too"
            )
    if drive.road is not None and (car is None or not wheels_of(car)):
        raise InputError("road needs a car with wheels: give car")
    if car is not None:
        behind_of(drive.behind, car)
