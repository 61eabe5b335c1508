"""Records of rides as commands read them: channels with their units in brackets, and cars in place of records."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from suspid.analysis import Settings, read
from suspid.cleaning import to_si
from suspid.cli.output import in_the_file
from suspid.errors import InputError
from suspid.io import bare_name, bracketed_unit
from suspid.performance import ACCELERATIONS
from suspid.records import cut, like
from suspid.samples import held
from suspid.signals import as_signal
from suspid.words import DAMAGE, Check, Code, Defect, Level, Note, Number, Remark

if TYPE_CHECKING:
    from suspid.cleaning import Cleaned
    from suspid.greybox import Estimate
    from suspid.model import Suspension
    from suspid.recordings import Recording

# Files that describe or hold a car; all others are records.
OF_CARS = (".toml", ".json")
# Factors below this are calibrations, of sensors that are off by a tenth at most; others convert the unit once more.
MOST_CALIBRATION = 1.1
# What cleaning makes of neighbours; peaks between them are lost.
INTERPOLATED = (Defect.MISSING, Defect.IRREGULAR_STAMPS, Defect.SLOWER_CLOCK, Defect.SHIFTED_CLOCK)
# Share of samples up to which that is no matter: the rms of a record changes by half of it.
MOST_INTERPOLATED = 0.01
IN_SI = (*ACCELERATIONS, "m")
NO_USE = "--linearise has no use: the car has neither friction nor curves"


def record_of(source: Path, settings: Settings, said: list[str]) -> tuple[Any, tuple[Check, ...]]:
    """Return the stretch of a record that the settings ask for, and what its defects say against its figures.

    What was done to it is added to what is said.
    """
    opened = read(source, settings)
    said += damage_of(opened.recording)
    said += map(str, [*opened.cleaned.findings, *opened.notes])
    record = held(opened.cleaned, "record")
    signal = as_signal(record)
    units = {one.numbers["channel"]: str(one.numbers["unit"]) for one in opened.notes if one.code is Note.CONVERTED}
    called = {bare_name(new): bare_name(old) for old, new in dict(settings.rename).items()}
    before = {bare_name(str(name)): unit for name, unit in units.items()}
    names = [
        _with_unit(name, unit, before.get(called.get(bare_name(name), bare_name(name)), ""), settings)
        for name, unit in zip(signal.channels, opened.cleaned.units, strict=True)
    ]
    if len(set(names)) == len(names) and tuple(names) != signal.channels:
        title = str(getattr(record, "title", None) or "")
        record = like(record, signal.timepts, signal.values, names, title=title)
    return cut(record, start=settings.start, stop=settings.stop), tuple(doubts_of(opened.cleaned))


def doubts_of(cleaned: Cleaned) -> Iterator[Check]:
    """Yield what cleaning left as it is, its repairs that change figures, and a clock that was overridden."""
    samples = len(held(cleaned, "record").time)
    for finding in cleaned.findings:
        if finding.kind is Defect.CLIPPED:
            continue  # A ride says itself what is clipped.
        made = finding.kind in INTERPOLATED and finding.samples > MOST_INTERPOLATED * samples
        if made or finding.check.level < Level.NOTE:
            yield Check(finding.check.remark, Level.CARE)


def damage_of(recording: Recording | None) -> list[str]:
    """Return what a file has lost, and what was guessed of its time, a sentence each."""
    everything = () if recording is None else recording.left_out
    return [in_the_file(name, why) for name, why in everything if why.code in DAMAGE]


def _with_unit(name: str, unit: str, before: str, settings: Settings) -> str:
    """Return a channel's name with its unit in brackets; without one if a factor has made it SI.

    ``before`` is its unit in the file, where that was converted.
    """
    by = _scale(name, settings)
    file_unit = before or unit or bracketed_unit(name)
    factor, si = _known(file_unit)
    if by is not None and factor != 1 and not 1 / MOST_CALIBRATION < abs(by) < MOST_CALIBRATION and si in IN_SI:
        raise InputError(
            f"--scale: channel {name!r} is converted from {file_unit} to {si} already; leave the factor out, or give "
            f"its sign alone"
        )
    stated = unit or bracketed_unit(name)
    if by is not None and si not in IN_SI:
        # A factor on what is none of acceleration and travel, such as volts, makes it SI.
        return bare_name(name)
    return f"{bare_name(name)} [{stated}]" if stated else name


def _known(unit: str) -> tuple[float, str]:
    """Return the factor of a unit and its SI unit; 1 and none of what is not known."""
    try:
        factor, si = to_si(1.0, unit)
    except InputError:
        return 1.0, ""
    return float(factor), si


def _scale(name: str, settings: Settings) -> float | None:
    """Return the factor that the command line gives a channel, by its name in the file."""
    old = next((old for old, new in dict(settings.rename).items() if new == name), name)
    return next((by for one, by in dict(settings.scale).items() if bare_name(one) == bare_name(old)), None)


def linear_car_of(
    source: Path, amplitude: float | None, code: Code, said: list[str]
) -> tuple[Suspension | Estimate, tuple[Check, ...]]:
    """Return the car of a file, linear if an amplitude of velocity is given, and a check that says at what."""
    from suspid.model import Suspension

    car = car_of(source)
    if not isinstance(car, Suspension):
        said += [NO_USE] * (amplitude is not None)
        return car, ()
    linear, numbers = made_linear(car, amplitude, said)
    return linear, (Check(Remark(code, numbers), Level.NOTE),) if numbers else ()


def made_linear(
    car: Suspension, amplitude: float | None, said: list[str]
) -> tuple[Suspension, Mapping[str, Number] | None]:
    """Return a car, linear if an amplitude of velocity is given, and which dampers it has in place of what was not."""
    if amplitude is None:
        return car, None
    if car.linear:
        said.append(NO_USE)
        return car, None
    linear = car.linearised(amplitude)
    made = {new.name: new.damping for old, new in zip(car.struts, linear.struts, strict=True) if not old.linear}
    return linear, {"amplitude": amplitude, "names": (*made,), "damping": (*made.values(),)}


def car_of(source: Path) -> Suspension | Estimate:
    """Return the car of a description, or the estimate of its JSON.

    Raises
    ------
    InputError
        If the file is neither.
    """
    if source.suffix.lower() == ".json":
        from suspid.reporting import read_estimate

        return read_estimate(source)
    from suspid.model import read_car

    try:
        return read_car(source)
    except InputError as error:
        if source.suffix.lower() in OF_CARS or not source.is_file():
            raise
        raise InputError(
            f"this is not a car: give a description (.toml, such as examples/car.toml) or the JSON of suspid "
            f"estimate; as a description it {error.message}"
        ) from None
