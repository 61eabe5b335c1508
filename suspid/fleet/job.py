"""What a fleet's run does with every record, as plain values that travel to workers and into the manifest."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from suspid.analysis import CarSettings, Settings, check_springs
from suspid.errors import InputError
from suspid.fleet.manifest import environment
from suspid.model import Suspension
from suspid.units import Second


@dataclass(frozen=True, kw_only=True, slots=True)
class Job:
    """What is done with every record."""

    settings: Settings = field(default_factory=Settings)
    # The car as TOML: python-control's models cannot be pickled, and the manifest holds text.
    car: str | None = None
    time_limit: Second | None = None
    # Versions of the client, which those of every worker must equal.
    environment: Mapping[str, str] = field(default_factory=environment)

    def to_dict(self) -> dict[str, object]:
        """Return what decides the results, for the manifest."""
        return {
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
            raise InputError("settings.springs is of use only with a car")
        return
    check_springs(settings.springs, car)
