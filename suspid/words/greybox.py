"""Codes and sentences: a suspension estimated from records."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from suspid.wording import Argument
from suspid.words.remarks import Code, count, in_a_row, percent, sentence

Numbers: TypeAlias = Mapping[str, Any]


def _listed(text: str) -> Callable[[Numbers], str]:
    """Return words with the names in place of ``{names}``, joined by commas."""
    return lambda numbers: text.format_map({**numbers, "names": ", ".join(numbers["names"])})


def _found(numbers: Numbers) -> str:
    records = numbers["records"]
    which = "one record" if records == 1 else f"{records} records"
    return f"{count(numbers['parameters'], 'parameter')} of the car found from {which}"


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _masses(numbers: Numbers) -> str:
    names = numbers["names"]
    one = len(names) == 1
    return (
        f"{_capital(in_a_row(names))} {'is' if one else 'are'} taken as known: springs and dampers are proportional, "
        f"and the intervals do not contain an error of {'it' if one else 'them'}."
    )


def _others(numbers: Numbers) -> str:
    number = numbers["count"]
    return f"{count(number, 'other set')} of springs and dampers fit{'s' * (number == 1)} the records as well."


def _unexplained(numbers: Numbers) -> str:
    chi_square = f"chi-square {numbers['chi_square']:.3g} at {numbers['freedom']}, mostly in {numbers['channel']}"
    if "caused" in numbers:
        said = (
            f"This car does not explain the records with any springs and dampers: a residual of "
            f"{percent(numbers['caused'])} of the motion of {numbers['follower']} is correlated with the input, "
            f"which noise is not ({chi_square}). The intervals do not allow for a wrong topology."
        )
    else:
        said = (
            f"The residual is not noise alone ({chi_square}): this car does not explain the records with any springs "
            f"and dampers, or the noise is coloured. The intervals allow for its colour, not for a wrong topology."
        )
        if "inputs" in numbers:
            one = len(numbers["inputs"]) == 1
            said += (
                f" {in_a_row(numbers['inputs'])} {'counts' if one else 'count'} as exactly known, and white noise of "
                f"{'its sensor' if one else 'their sensors'} does not explain it either."
            )
    return (
        f"{said} Estimate what may be missing as "
        f"well: mounts of dampers, gains and delays of channels ({Argument('mounts', '…')}, {Argument('gains', '…')}, "
        f"{Argument('delays', '…')}); or describe another mass."
    )


class EstimateHeadline(Code):
    """Headline of the result."""

    FOUND = "found", _found


def _not_one_car(numbers: Numbers) -> str:
    change, none = numbers["change"], "that is not zero as above"
    moved = none if change is None else f"{100 * change:+.2g} % from the value above"
    goes = f", and {numbers['share']:.2g} of the power of its residual goes" if "share" in numbers else ""
    return (
        f"The records are not of one car: fitted alone, record {numbers['record']} has {numbers['name']} "
        f"{moved}{goes} (chi-square {numbers['chi_square']:.3g} at {numbers['freedom']}). The intervals do not allow "
        f"for it. Estimate each record alone and compare."
    )


def _driven(numbers: Numbers) -> str:
    loggers = (
        " No channel is in two of the records: if they are of one test by several loggers, put them into one file, "
        "each with its column of time."
    )
    return (
        f"The motion does not decay, so this is not a free decay, and the values above are meaningless. State what "
        f"moved the car ({Argument('given', '…')}); in a drive that is the measured motion of the wheels."
        f"{loggers if numbers.get('loggers') else ''}"
    )


class EstimateCheck(Code):
    """Checks of a suspension that was estimated."""

    EXPLAINS = (
        "explains",
        "With the springs and dampers found, the car explains the records: the residual is noise (chi-square "
        "{chi_square:.3g} at {freedom}).",
    )
    ROUNDING = "rounding", "The fit agrees with the records to their rounding."
    NEARLY_EXACT = (
        "nearly exact",
        "With the springs and dampers found, the car explains the records: the residual is at most {share:.1g} of a "
        "channel's motion, less than the error of any sensor. It is not white; the intervals allow for its colour.",
    )
    UNEXPLAINED = "unexplained", _unexplained
    NOT_ONE_CAR = "not one car", _not_one_car
    NOTHING_FOLLOWS = (
        "nothing follows",
        "With the springs and dampers found, the car explains how the channels follow the given motion (chi-square "
        "{chi_square:.3g} at {freedom}).",
    )
    FOLLOWS = (
        "follows",
        "The residual of the channels follows the given motion (chi-square {chi_square:.3g} at {freedom}): the "
        "transfer is off by {error:.2%} near {hertz:.3g} Hz, so the model lacks something, such as another axle. The "
        "intervals allow for it: standard deviations are widened {wider:.1f} times, and include the changes due to "
        "gains, delays and mounts as stated. The mass that moves at a corner is not the load that it carries. "
        "Describe what is missing and measure it: for another axle, a half car with the motion of both wheels given.",
    )
    REVERSED = "reversed", _listed("With the sign of {names} reversed the car explains the records: check the sensor.")
    DEAD = (
        "dead",
        _listed(
            "{names} follows no other channel: the sensor is dead, loose or not connected, or its samples are of "
            "another drive. Check the sensor and its wiring."
        ),
    )
    APART = (
        "apart",
        _listed(
            "{names} have nothing in common: one of the sensors is dead, loose or not connected, or their samples are "
            "of different drives. Check the sensors and their wiring."
        ),
    )
    COPIED = (
        "copied",
        _listed(
            "{names} show the same motion, up to a factor: one sensor is recorded twice, or both are at one place. "
            "Check the wiring and the names of the channels."
        ),
    )
    EXCHANGED = (
        "exchanged",
        _listed("With {names} exchanged the car explains the records: check the names of the channels."),
    )
    DRIVEN = "driven", sentence(_driven)
    ONSET = (
        "onset",
        "The records begin before the free decay, at rest or still being pushed: used from {starts} s on, to where the "
        "decay ends.",
    )
    NEEDED = (
        "needed",
        _listed(
            "Estimated as well, because the records are not explained without: {names}. Where a sensor is known to be "
            "right, hold its gain at 1 and its delay at 0, and look for what the car lacks."
        ),
    )
    NOISY_INPUTS = (
        "noisy inputs",
        _listed(
            "The noise of the measured cause is part of the model, with a level found from the records: {names}. The "
            "intervals allow for it."
        ),
    )
    UNITS = (
        "units",
        _listed(
            "More than {factor:g} times larger or smaller than nominal: {names}. Check the units of the channels (1 g "
            "is 9.81 m/s2, 1 mm is 0.001 m) and the nominal values."
        ),
    )
    MASSES = "masses", _masses
    SCALE = "scale", "The force that was given sets the scale of masses, springs and dampers."
    CANCELS = (
        "cancels",
        _listed("Fixed at nominal, because they have no effect where the motion of {given} is measured: {names}."),
    )
    STILL = "still", _listed("The modes are those with {names} fixed in place.")
    BEHIND = (
        "behind",
        "The road under {rear} is that under {front}, {lag:.4g} ± {std:.2g} m later, with a coherence of "
        "{coherence:.3g}, the median over the lines. Tires and wheel masses follow from that, and hardly from the "
        "spectrum of the road.",
    )
    NOT_BEHIND = (
        "not behind",
        "The road under {rear} is not closely enough that under {front}: their coherence is {coherence:.3g}, the "
        "median over the lines; {least:g} is needed. Tires and wheel masses are those of each axle by itself. If "
        "the wheels roll in one track, check which road is behind, how far, and the speed: its unit, and whether it is "
        "late, smoothed, or in steps of a second.",
    )
    FEW_BEHIND = (
        "few behind",
        "Only {count} stretches, of which {fewest} are needed, tell whether one road is behind the other: tires and "
        "wheel masses are those of each axle by itself.",
    )
    ROAD = (
        "road model",
        _listed(
            "A model of the road determines {names} and the modes of the whole car: a power law of exponent "
            "{exponent:.2f} ± {std:.2f} with smooth departures of 30 %, its level free in every stretch. The "
            "intervals hold for such roads; springs and dampers of the suspension do not depend on it."
        ),
    )
    TIRE_DAMPING = (
        "tire damping",
        _listed(
            "Hardly told from the damper of the suspension, so known mainly beforehand, to 50 % where nothing is "
            "stated: {names}. 5 % of the damper's are 4 % of the wheel's mass."
        ),
    )
    NO_SPEED = (
        "no speed",
        sentence(
            lambda _: (
                f"The speed is not known, so neither the class of the road nor the rotation of the wheels is. An "
                f"unbalanced wheel may be mistaken for a mode of the wheel; give {Argument('speed', '…')} and "
                f"{Argument('wheel_radius', '…')}."
            )
        ),
    )
    NO_RADIUS = (
        "no radius",
        sentence(
            lambda _: (
                f"The radius of the wheels is not known, so their rotation is not either. An unbalanced wheel may be "
                f"mistaken for a mode of the wheel; give {Argument('wheel_radius', '…')}."
            )
        ),
    )
    ALTERNATIVES = "alternatives", _others
    ONE_START = "one start", "Only {count} of {starts} starts ended at this fit; another minimum may be better."
    VANISHED = "vanished", _listed("The best fit has no {names}: the topology may be wrong.")
    AT_BOUND = "at bound", _listed("At its bound: {names}.")
    BY_NOMINAL = "by nominal", _listed("Known from the nominal values alone: {names}.")
    VAGUE = "vague", _listed("Poorly determined (95 % interval wider than the value): {names}.")
    GAIN = (
        "gain",
        _listed(
            "Gains far from 1: {names}. Check the units of the channels (1 g is 9.81 m/s2) and the place of "
            "the sensors in the car file."
        ),
    )
    MISCALIBRATED = (
        "miscalibrated",
        sentence(
            lambda n: (
                f"Gains more than a tenth from 1: {', '.join(n['names'])}. Exchanged channels of two wheels, and a "
                f"damper that changed between records, look like sensors of another gain. Check the names of the "
                f"channels, estimate each of several records alone, and calibrate the sensors, or hold their "
                f"gains at 1 ({Argument('gains', '()')})."
            )
        ),
    )
    UNUSED = (
        "unused",
        _listed("Not used, because they measure nothing of the car, or a road that is not given: channels {names}."),
    )
    FOLDED = (
        "folded",
        _listed(
            "{names} are {seconds:.2g} s both, and cancel: motion above half the sampling rate may be folded into the "
            "band, as by edges of potholes and steps where a logger has no filter against aliasing. Dampers are then "
            "off by some percent. Switch on the filter of the logger, or record faster."
        ),
    )
    CHANGED = (
        "changed",
        _listed("Significantly different from nominal (5 % level for all parameters together): {names}."),
    )
    SAID = "said", "{text}"
    UNCHANGED = "unchanged", "No parameter differs significantly from nominal (5 % level for all together)."
