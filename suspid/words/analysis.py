"""What the recipe says on its way from a file to a verdict."""

from __future__ import annotations

from collections.abc import Mapping

from suspid.words.remarks import Code, Number, count


def _stands_out(n: Mapping[str, Number]) -> str:
    why = "no decay without doubts was found" if n["found"] else "no free decay was found"
    best = f" (best: {n['best']})" if n["best"] else ""
    return f"{why}{best}; the whole record is used. {n['remarks']}".rstrip()


class Note(Code):
    """What was done with a recording, in the order in which it happened."""

    CONVERTED = "converted", "channel {channel!r} was converted from {unit} to {si} (factor {factor:.6g})"
    NOT_CONVERTED = "not converted", "channel {channel!r} was not converted: {why}"
    VERTICAL = "vertical", "{found}"
    WHOLE_RECORD = "whole record", _stands_out
    DECAY_USED = (
        "decay used",
        lambda n: (
            f"the decay from {n['start']:.6g} to {n['stop']:.6g} s is used"
            + (f"; {n['others']} more were found: see --decay" if n["others"] else "")
        ),
    )
    DECAYS_USED = (
        "decays used",
        lambda n: (
            f"{count(int(str(n['number'])), 'decay')} {'is' if n['number'] == 1 else 'are'} used, from {n['starts']} s"
        ),
    )
    DECAYS_LEFT_OUT = (
        "decays left out",
        lambda n: f"{count(int(str(n['number'])), 'decay')} with doubts {'is' if n['number'] == 1 else 'are'} left out",
    )
    DECAY_DOUBT = "decay doubt", "this decay: {doubt}"
    STILL_CHANNEL = "still channel", "channel {channel!r} is constant in this decay; left out"
    NO_SPRINGS = "no springs", "springs and dampers were not found: {why}"


class RecordCheck(Code):
    """Checks of the recording that the identification cannot see."""

    DECAY = "decay", "{doubt}"
    DEFECTS = (
        "defects",
        lambda n: (
            f"{count(int(str(n['number'])), 'defect')} of the recording "
            f"{'was' if n['number'] == 1 else 'were'} found and not repaired; see the cleaning table."
        ),
    )
