"""Codes and sentences: defects of a recording, what was done about each, and the verdict on the record."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeAlias, cast

from suspid.wording import Argument, moment, when
from suspid.words.remarks import Code, Number, Words, amount, count, in_a_row, percent, sentence

Numbers: TypeAlias = Mapping[str, Number]
# The end of what is said of samples that a file has and that are not believed.
AS_MISSING = "; treated as missing"
# Error of a channel, as a share of its motion, above which most of that is noise or faster than the stamps follow.
MOSTLY_FASTER = 0.5


def place(numbers: Numbers) -> str:
    """Return channel and time of a defect.

    Examples
    --------
    >>> place({"channel": "seat", "start": 1.5, "stop": 2.0}), place({"channel": "", "start": 1.0, "stop": 1.0})
    ("channel 'seat' from 1.5 to 2 s", 'at 1 s')
    """
    start, stop = _number(numbers, "start"), _number(numbers, "stop")
    channel = f"channel {numbers['channel']!r} " if numbers["channel"] else ""
    return channel + when(start, stop)


def _number(numbers: Numbers, name: str) -> float:
    return cast("float", numbers[name])


def _count(numbers: Numbers, noun: str, name: str = "samples") -> str:
    return count(cast("int", numbers[name]), noun)


def _rounded_stamps(numbers: Numbers) -> str:
    if "rate_std" in numbers:
        return (
            "time stamps are rounded to {resolution:.2g} s; the uniform clock that rounds to all of them runs at "
            "{rate:.8g} ± {rate_std:.1g} Hz and replaces them; samples unchanged"
        ).format_map(numbers)
    return (
        "time stamps lie up to {off:.2g} s ({plain} samples) off the stated {rate:.9g} Hz; the uniform clock of that "
        "rate replaces them; samples unchanged"
    ).format_map({**numbers, "plain": _plain(_number(numbers, "off_samples"))})


def _overridden_stamps(numbers: Numbers) -> str:
    text = f"the stated rate of {numbers['rate']:.9g} Hz replaces the time column"
    column = _number(numbers, "stamps_rate")
    if column != column:
        return f"{text}, which states none"
    percent = 100 * abs(column / _number(numbers, "rate") - 1)
    apart = _number(numbers, "apart")
    off = f" ({_plain(percent)} % off)" if percent >= 0.01 else ""
    ends = f" and ends {abs(apart):.3g} s {'later' if apart > 0 else 'earlier'}" if apart else ""
    missing = (
        f"; by the time column, {_count(numbers, 'row', 'missing')} are missing; leave {Argument('fs')} out to keep "
        f"their places"
        if numbers.get("missing")
        else ""
    )
    return f"{text}, which states {column:.9g} Hz{off}{ends}{missing}"


def _plain(number: float) -> str:
    """Return a number to two digits or more, without an exponent unless it is huge.

    Examples
    --------
    >>> _plain(100.0), _plain(2.345), _plain(0.012)
    ('100', '2.3', '0.012')
    """
    return f"{number:.0f}" if 10 <= number < 1e6 else f"{number:.2g}"


def _jittering_stamps(numbers: Numbers) -> str:
    # Four standard deviations beyond 1, the share says nothing.
    told = 4 * _number(numbers, "followed_std") < 1
    follow = (
        "do not follow them (share {followed:.2f} ± {followed_std:.2g})"
        if told
        else "do not show whether the stamps are right"
    )
    return (
        "time stamps lie {rms:.2g} s rms, at most {largest:.2g} s, off a uniform clock of {rate:.7g} Hz; the samples "
        f"{follow}; uniform sampling assumed, samples unchanged"
    ).format_map(numbers) + (
        f"; if the stamps are right, the error is {percent(_number(numbers, 'error'))} of the motion (rms, with noise)"
    )


def _irregular_stamps(numbers: Numbers) -> str:
    why = f"time stamps lie up to {_plain(_number(numbers, 'largest'))} samples off any uniform clock"
    if "followed" in numbers:
        why += " and the samples follow them (share {followed:.2f} ± {followed_std:.2g})"
    text = f"{why}; interpolated (cubic spline) onto {{rate:.7g}} Hz".format_map(numbers)
    if "faithful_below" in numbers:
        text += f"; error below 1 % up to {numbers['faithful_below']:.2g} Hz, {_over_all(numbers)}"
    if numbers.get("dropped"):
        text += f"; {_count(numbers, 'near-duplicate time stamp', 'dropped')} dropped"
    return text


def _over_all(numbers: Numbers) -> str:
    """Return the error of interpolation over all frequencies, for the channels whose motion is not mostly faster."""
    most, least = _number(numbers, "error"), float(cast("float", numbers.get("least", numbers["error"])))
    if not most > MOSTLY_FASTER:
        return f"at most {percent(most)} of the motion over all frequencies (rms, with noise)"
    if not least <= MOSTLY_FASTER:
        return "but most of the record is faster: noise, or motion that the stamps do not follow"
    return (
        f"over all frequencies {percent(least)} of the motion in {numbers['slowest']!r} (rms, with noise); most "
        f"of some other channel is faster: noise, or motion that the stamps do not follow"
    )


def _set_back(numbers: Numbers) -> str:
    again = cast("int", numbers["samples"]) > 1
    often = f" {numbers['samples']} times, the first time" if again else ""
    return (
        f"the clock was set back{often} by {{back:.3g}} s ({{back_samples:.2g}} samples) after row {{row}} and runs on "
        f"at the same pace; samples taken as evenly spaced across it, the later stamps moved on by as much"
    ).format_map(numbers)


def _gappy_channel(numbers: Numbers) -> str:
    if "share" in numbers:
        return (
            f"{{samples}} of {{rows}} samples missing, {amount(_number(numbers, 'share'))} %, of which at most "
            "{most:.0f} % are filled; left out, since other channels have fewer"
        ).format_map(numbers)
    return (
        "{samples} of {rows} samples missing, in gaps too long to fill; left out, since other channels have none; "
        "name it to use the part of the record where it is complete"
    ).format_map(numbers)


def _spikes(numbers: Numbers) -> str:
    if "off" in numbers:
        where = "{off:.4g} or more off the samples beside them, which a smooth motion goes through"
    else:
        where = "beyond {least:.4g}, while {share:g} % of all are within {within:.4g}"
    return f"{numbers['samples']} single samples {where.format_map(numbers)}{AS_MISSING}"


def _sentinel(numbers: Numbers) -> str:
    what = _count(numbers, "sample")
    if "value" in numbers:
        where = "equal to {value:.6g}, far from all others ({low:.4g} to {high:.4g})".format_map(numbers)
    else:
        where = "infinite or above {limit:g}".format_map(numbers)
    return f"{what} {where}{AS_MISSING}"


def _dropout(numbers: Numbers) -> str:
    value = "zero" if numbers["zero"] else "one value"
    runs = _count(numbers, "run", "runs")
    return f"{runs} of exactly {value}, up to {numbers['longest']} samples long, ended by a jump{AS_MISSING}"


def _missing(numbers: Numbers) -> str:
    gaps = f"{_count(numbers, 'sample')} missing in {_count(numbers, 'gap', 'gaps')} of up to {numbers['longest']}"
    share = f" ({percent(_number(numbers, 'share'))} of the rms motion)" if "share" in numbers else ""
    return f"{gaps}; interpolated, error {numbers['error']:.2g} rms{share}"


def _clipped(numbers: Numbers) -> str:
    limit = "largest" if numbers["largest"] else "smallest"
    since, last = (moment(_number(numbers, name)) for name in ("longest_start", "last"))
    # Where it is clipped again and again, little is left behind the last of these samples.
    way_out = "record it again with a larger range" if numbers.get("throughout") else f"use it after {last} s only"
    return (
        f"{_count(numbers, 'sample')} at the {limit} value {numbers['value']:.6g}, {numbers['longest']} of them in a "
        f"row from {since} s: clipped; {way_out}, or leave the channel out"
    )


def _dead_channel(numbers: Numbers) -> str:
    return f"{dead(numbers)}; left out"


def dead(numbers: Numbers) -> str:
    """Return why a channel contains no motion.

    Examples
    --------
    >>> dead({"constant": 4.2}), dead({"finite": 3, "samples": 2000})
    ('constant at 4.2', '3 numbers in 2000 samples')
    """
    if "huge" in numbers:
        return (
            f"{numbers['huge']} of {_count(numbers, 'sample')} exceed {numbers['limit']:g}, too large for a motion: "
            f"check unit and scale"
        )
    if "finite" in numbers:
        return f"{_count(numbers, 'number', 'finite')} in {_count(numbers, 'sample')}"
    return f"constant at {numbers['constant']:g}{' after the repairs' if numbers.get('repaired') else ''}"


def _names(numbers: Numbers) -> str:
    return in_a_row([repr(name) for name in cast("tuple[str, ...]", numbers["channels"])])


def _slower_clock(numbers: Numbers) -> str:
    if "error" in numbers:
        return f"{_names(numbers)} at {numbers['rate']:.6g} Hz; {_interpolated(numbers)}"
    return (
        f"{_names(numbers)} at {numbers['rate']:.6g} Hz, the others at {numbers['onto']:.6g} Hz; left out; name them "
        f"to interpolate them"
    )


def _shifted_clock(numbers: Numbers) -> str:
    return f"{_names(numbers)} sampled at other times than the other channels; {_interpolated(numbers)}"


def _interpolated(numbers: Numbers) -> str:
    error = percent(_number(numbers, "error"))
    return f"interpolated onto {numbers['onto']:.6g} Hz, error at most {error} of the motion (rms)"


def _cut(numbers: Numbers) -> str:
    why = "samples are missing there or next to it" if numbers["missing"] else "not all channels were recorded there"
    first, last = _number(numbers, "first"), _number(numbers, "last")
    return f"{_count(numbers, 'sample')} at the ends cut off ({why}); {moment(first)} to {moment(last)} s kept"


def _placed(words: Words) -> Callable[[Numbers], str]:
    """Return words that begin with the place of the defect where the numbers hold it."""

    def say(numbers: Numbers) -> str:
        text = words.format_map(numbers) if isinstance(words, str) else words(numbers)
        return f"{place(numbers)}: {text}" if "channel" in numbers else text

    return say


class Defect(Code):
    """A defect of a recording that cleaning has repaired, or seen and left alone.

    Where the numbers of a remark hold ``channel``, ``start`` and ``stop`` [s], its sentence begins with them.

    Examples
    --------
    >>> from suspid.words import Remark
    >>> numbers = {"drift": 0.4}
    >>> print(Remark(Defect.DRIFT, numbers))
    drifts by 0.4 over the record, more than its other motion; left as it is
    >>> str(Remark(Defect.DRIFT, {**numbers, "channel": "seat", "start": 0.0, "stop": 9.0}))[:30]
    "channel 'seat' from 0 to 9 s: "
    """

    def __new__(cls, value: str, words: Words) -> Defect:
        """Make a member whose words can begin with the place."""
        member = object.__new__(cls)
        member._value_ = value
        member.words = _placed(words)
        return member

    ROUNDED_STAMPS = "rounded stamps", _rounded_stamps
    OVERRIDDEN_STAMPS = "overridden stamps", _overridden_stamps
    JITTERING_STAMPS = "jittering stamps", _jittering_stamps
    IRREGULAR_STAMPS = "irregular stamps", _irregular_stamps
    ON_CHANGE = (
        "written on change",
        "each row is one count of {count:.4g} from the last: written when the count changes, not evenly; interpolated "
        "at {rate:.6g} Hz between the boundaries of the counts, about half a count off at most; counts that change "
        "later on the way back, as those of gears with play, are not told",
    )
    ONE_OF_EACH = (
        "one of each",
        "each sample stands in {rows} rows: the sensor is slower than the logger; one of each is used, at "
        "{rate:.6g} Hz",
    )
    PACKETS = (
        "packets",
        "rows came in {packets} packets of about {rows:.0f}, each with one time stamp; uniform sampling at {rate:.6g} "
        "± {rate_std:.1g} Hz assumed, samples unchanged",
    )
    AMBIGUOUS_STAMPS = (
        "ambiguous stamps",
        "time stamps fit a clock of {rate:.7g} Hz that was rounded as well as one of {other_rate:.7g} Hz with "
        "{missing} rows missing; the samples do not show which (share followed {followed:.2f} ± {followed_std:.2g}); "
        "{assumed:.7g} Hz assumed; compare it with the rate set in the logger",
    )
    MISSING_ROWS = (
        "missing rows",
        sentence(lambda n: f"{n['samples']} of {n['rows']} rows missing, in {_count(n, 'place', 'places')}"),
    )
    STOPPED_CLOCK = (
        "stopped clock",
        sentence(
            lambda n: (
                f"the clock stopped: {_count(n, 'row')} at the end repeat its last stamp; left out. "
                f"{Argument('time', 'none')} and {Argument('fs')} keep them, if the rows are regular"
            )
        ),
    )
    NO_STAMP = "no stamp", sentence(lambda n: f"{_count(n, 'row')} without a time stamp dropped")
    REPEATED_ROWS = (
        "repeated rows",
        sentence(lambda n: f"{_count(n, 'row')} repeat time stamp and samples of a row before; dropped"),
    )
    TIED_STAMPS = (
        "tied stamps",
        sentence(
            lambda n: (
                f"{_count(n, 'time stamp')} equal the one before, with other samples; the rows are set "
                f"{_number(n, 'apart'):.2g} s apart, less than the last digit"
            )
        ),
    )
    SWAPPED_ROWS = "swapped rows", sentence(lambda n: f"{_count(n, 'row')} out of time order; sorted by time stamp")
    WRONG_STAMPS = (
        "wrong stamps",
        sentence(
            lambda n: (
                f"{_count(n, 'time stamp')} inconsistent with all others, the first {moment(_number(n, 'first'))} s; "
                + (
                    "rows left out"
                    if n.get("left_out")
                    else "replaced by the time that follows from the order of the rows"
                )
            )
        ),
    )
    SET_BACK = "set back clock", _set_back
    SENTINEL = "sentinel", _sentinel
    SPIKES = "spikes", _spikes
    WRAPPED = (
        "wrapped",
        sentence(
            lambda n: f"wraps round at {n['turn']:.6g}, {_count(n, 'time')}; continued beyond, as the motion goes on"
        ),
    )
    DROPOUT = "dropout", _dropout
    STOPPED = (
        "stopped",
        sentence(
            lambda n: (
                f"{_count(n, 'sample')} of exactly {n['value']:.6g} to the end, with none of the noise before: the "
                f"sensor or its logger has stopped{AS_MISSING}"
            )
        ),
    )
    MISSING = "missing", _missing
    CLIPPED = "clipped", _clipped
    HELD_SAMPLES = (
        "held samples",
        "each value is repeated for {repeats:.0f} samples: the file has a higher rate than the sensor; left as it is",
    )
    DRIFT = "drift", "drifts by {drift:.3g} over the record, more than its other motion; left as it is"
    OFFSET = "offset", "mean level {level:.4g}, range of motion {range:.3g}; left as it is"
    DEAD_CHANNEL = "dead channel", _dead_channel
    GAPPY_CHANNEL = "gaps", _gappy_channel
    SLOWER_CLOCK = "slower clock", _slower_clock
    SHIFTED_CLOCK = "shifted clock", _shifted_clock
    CUT = "cut", _cut


class Cleaning(Code):
    """What cleaning made of a recording, in a line."""

    UNCHANGED = "unchanged", "no defect found, record unchanged"
    REPAIRED = (
        "repaired",
        sentence(lambda n: f"{_count(n, 'defect', 'repaired')} repaired, {n['left']} left as found"),
    )
