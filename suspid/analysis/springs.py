"""Springs and dampers in an analysis: from the modes, or fitted to the record if the modes do not determine them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from suspid.analysis.settings import CarSettings
from suspid.errors import InputError, ReconstructionError, SuspidError
from suspid.greybox import Estimate, RecordTest, estimate_by_cause, likely_causes
from suspid.model import ModalSet, Suspension
from suspid.reconstruction import Asked, ModalTest, Reconstruction, check_asked, reconstruct
from suspid.values import nearest_names
from suspid.wording import Argument
from suspid.words import Note, Remark

if TYPE_CHECKING:
    import control


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Springs:
    """What was found of springs and dampers, and what was said on the way."""

    reconstruction: Reconstruction | None = None
    estimate: Estimate | None = None
    notes: tuple[Remark, ...] = ()


def check_springs(how: CarSettings, car: Suspension) -> None:
    """Refuse what no modes of this car could be reconstructed with: an unknown name, bounds that leave nothing.

    Raises
    ------
    InputError
        If a name is unknown, settings contradict each other, or nothing is left to find.
    """
    for name in how.added_masses:
        if name not in car.coordinates:
            raise InputError(Argument("added_masses"), f": there is no mass {name!r}.{nearest_names(name, car.masses)}")
    check_asked(car, Asked(**_unknowns(how), constraints=how.constraints))


def springs_of(
    modes: ModalSet, records: Sequence[control.TimeResponseData], car: Suspension, how: CarSettings
) -> Springs:
    """Return springs and dampers from modes; where these do not settle them, from the records as well.

    The records are free decays, or motion under a road or a force that was measured. An estimate knows no constraints:
    with some, there is none.
    """
    try:
        test = ModalTest(modes=modes, added_masses=how.added_masses)
        settings = {**_unknowns(how), "constraints": how.constraints}
        found, why = reconstruct([test], car, tolerance=how.tolerance, search=how.search, **settings), None
    except (ReconstructionError, InputError) as error:
        found, why = None, error.wording
    notes = (Remark(Note.NO_SPRINGS, {"why": why}),) if why else ()
    if how.constraints or (found is not None and found.explains and not found.alternatives):
        return Springs(reconstruction=found, notes=notes)
    try:
        tests = [RecordTest(record=record, added_masses=how.added_masses) for record in records]
        # Wheels that were measured are part of a decay: as a cause they would hide the tires.
        causes = [cause for cause in likely_causes(tests, car) if not {*cause} & {*car.coordinates}]
        fitted, cause = estimate_by_cause(tests, car, causes=causes or [()], options=_unknowns(how))
    except SuspidError as error:
        return Springs(reconstruction=found, notes=(*notes, Remark(Note.NO_ESTIMATE, {"why": error.wording})))
    moved = (Remark(Note.MOVED, {"names": ", ".join(cause)}),) if cause else ()
    return Springs(reconstruction=found, estimate=fitted, notes=(*notes, Remark(Note.ESTIMATED), *moved))


def _unknowns(how: CarSettings) -> dict[str, Any]:
    """Return what is asked for and known beforehand, as arguments of `reconstruct` and `estimate`."""
    return {name: getattr(how, name) for name in ("fixed", "bounds", "ties", "nominal_std", "free_masses")}
