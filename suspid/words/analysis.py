"""Codes and sentences: from a file to a verdict."""

from __future__ import annotations

from collections.abc import Mapping

from suspid.wording import Argument, moment
from suspid.words.io import rates_of_units
from suspid.words.remarks import MOST_LISTED, Code, Number, count, in_a_row, sentence


def _stands_out(n: Mapping[str, Number]) -> str:
    if n["found"] and not n["clear"]:
        return f"no clear decay was found, the best is {n['best']}; the whole record is used"
    if n["found"] and not n["modes"]:
        return f"no mode is significant, neither in the best decay ({n['best']}) nor in the whole record"
    if n["surer"]:
        return f"the whole record is used: it shows the modes of the best decay in it ({n['best']}) with fewer doubts"
    if n["found"]:
        return f"the whole record is used: the fit explains it as well as the best decay in it ({n['best']})"
    lacking = "no stretch stands out as a free decay" if n["modes"] else "no free decay was found"
    return f"{lacking}; the whole record is used. {n['remarks']}".rstrip()


def _tests(n: Mapping[str, Number]) -> str:
    names = n["tests"]
    assert isinstance(names, tuple)
    more = f" and {len(names) - MOST_LISTED} others" if len(names) > MOST_LISTED else ""
    return f"file contains {len(names)} tests, {', '.join(repr(name) for name in names[:MOST_LISTED])}{more}"


def _named(n: Mapping[str, Number]) -> str:
    names = n["names"]
    assert isinstance(names, tuple)
    return f"{'channels' if len(names) > 1 else 'channel'} {in_a_row([repr(name) for name in names])}"


def _by_mode(n: Mapping[str, Number]) -> str:
    modes, times = n["modes"], n["times"]
    assert isinstance(modes, tuple)
    assert isinstance(times, tuple)
    many = len(modes) > 1
    named = f"modes {in_a_row([str(mode) for mode in modes])} are" if many else f"mode {modes[0]} are"
    return f"{named} {in_a_row([f'{factor:.2g}' for factor in times])}"


def _channels(n: Mapping[str, Number]) -> str:
    names = n["names"]
    assert isinstance(names, tuple)
    return f"{_named(n)} {'are' if len(names) > 1 else 'is'}"


def _as_one(n: Mapping[str, Number]) -> str:
    """Say since when two channels move as one."""
    return (
        f"{n['first']!r} and {n['second']!r} move as one from {moment(float(str(n['time'])))} s on, and did not before"
    )


def _after_changes(n: Mapping[str, Number]) -> str:
    return f"what follows {count(int(str(n['number'])), 'change')} of {_named(n)} is used"


def _largest_motion(n: Mapping[str, Number]) -> str:
    along = "largest motion: {explained:.1%} along an axis {apart_deg:.2f} deg from up; ".format_map(n)
    return along + ("they agree" if n["agree"] else "they do not agree, the motion is not mainly vertical")


class Note(Code):
    """What was done with a recording, in the order in which it happened."""

    CONVERTED = "converted", "channel {channel!r} was converted from {unit} to {si} (factor {factor:.6g})"
    NOT_CONVERTED = "not converted", "channel {channel!r} was not converted: {why}"
    VERTICAL = (
        "vertical",
        "up: {axes}, by {by}; {tilt_deg:.2f} ± {std_deg:.2g} deg off {nearest}; {explained:.1%} of the motion is along "
        "it",
    )
    GRAVITY = "gravity", "gravity: {gravity:.4g} {unit}, subtracted"
    NO_GRAVITY = (
        "no gravity",
        "gravity: not measured (the mean of the three channels is {gravity:.4g}); up may be down",
    )
    LARGEST_MOTION = "largest motion", _largest_motion
    WHOLE_RECORD = "whole record", _stands_out
    SOUGHT_WITHIN = (
        "sought within",
        "no mode is beyond doubt from the first sample of the part that was asked for on; a decay is sought within it",
    )
    OUTSIDE = (
        "outside",
        sentence(
            lambda n: (
                f"the record lasts from {moment(float(str(n['first'])))} to {moment(float(str(n['last'])))} s; "
                f"{Argument('start')} or {Argument('stop')} is outside of it"
            )
        ),
    )
    DECAY_USED = (
        "decay used",
        sentence(
            lambda n: (
                f"the decay from {moment(float(str(n['start'])))} to {moment(float(str(n['stop'])))} s is used"
                + (
                    f"; {n['others']} more {'was' if n['others'] == 1 else 'were'} found: see {Argument('decay')}"
                    if n["others"]
                    else ""
                )
            )
        ),
    )
    BETWEEN_RESTS = (
        "between rests",
        sentence(
            lambda n: (
                f"no stretch is a free decay of its own; the motion between two rests is used, from "
                f"{moment(float(str(n['start'])))} to {moment(float(str(n['stop'])))} s"
            )
        ),
    )
    FROM_RELEASE = (
        "from release",
        sentence(
            lambda n: (
                f"no stretch is a free decay of its own; all of the motion is used, from its release at "
                f"{moment(float(str(n['start'])))} s on"
            )
        ),
    )
    UNTIL_LOCKED = (
        "until locked",
        sentence(
            lambda n: (
                f"the motion from {moment(float(str(n['start'])))} to {moment(float(str(n['stop'])))} s is used: after "
                f"that a channel rests or two move as one, as where friction locks a strut"
            )
        ),
    )
    AFTER_LOCK = (
        "after lock",
        sentence(_as_one),
    )
    LARGEST_USED = (
        "largest used",
        sentence(
            lambda n: (
                f"no stretch is a free decay beyond doubt; the largest motion is used, from "
                f"{moment(float(str(n['start'])))} to {moment(float(str(n['stop'])))} s"
            )
        ),
    )
    COMMANDED = "commanded", sentence(_after_changes)
    DECAYS_USED = (
        "decays used",
        sentence(
            lambda n: (
                f"{count(int(str(n['number'])), 'decay')} {'is' if n['number'] == 1 else 'are'} used, "
                f"from {n['starts']} s"
            )
        ),
    )
    DECAYS_LEFT_OUT = (
        "decays left out",
        sentence(
            lambda n: (
                f"{count(int(str(n['number'])), 'decay')} with doubts {'is' if n['number'] == 1 else 'are'} left out"
            )
        ),
    )
    DECAY_DOUBT = "decay doubt", "this decay: {doubt}"
    WIDENED = (
        "widened",
        sentence(
            lambda n: (
                f"the background excites modes during the decay: the intervals of {_by_mode(n)} times as wide as in "
                f"white noise"
            )
        ),
    )
    LARGER_ELSEWHERE = (
        "larger elsewhere",
        sentence(
            lambda n: (
                f"elsewhere the record moves {float(str(n['times'])):.0f} times as much (rms), most about "
                f"{moment(float(str(n['time'])))} s: {Argument('start')} and {Argument('stop')} choose another part"
            )
        ),
    )
    HELD_CHANNEL = (
        "held channel",
        "channel {channel!r} is a command or a force, not a motion: constant except for jumps ({jumps}); left out; "
        "name the channels to use it",
    )
    BLOW_CHANNEL = (
        "blow channel",
        "channel {channel!r} measures blows ({blows}), not a motion: short pulses that push one way; left out; name "
        "the channels to use it",
    )
    CLIPPED_CHANNEL = (
        "clipped channel",
        "channel {channel!r} is clipped in the part that is used; left out; name the channels to use it",
    )
    IDLE_CHANNEL = (
        "idle channel",
        "channel {channel!r} has the same noise whether others move or not; left out; name the channels to use it",
    )
    COMMAND_CHANNEL = (
        "command channel",
        "channel {channel!r} is named as a command, not as a measurement; left out; name the channels to use it",
    )
    COPIED_CHANNEL = (
        "copied channel",
        "channel {channel!r} is {source!r} but for a factor and an offset, not another measurement; left out; name the "
        "channels to use it",
    )
    DERIVED_CHANNEL = (
        "derived channel",
        "channel {channel!r} is the computed derivative of {source!r}, not a measurement; left out; name the "
        "channels to use it",
    )
    INTEGRATED_CHANNEL = (
        "integrated channel",
        "channel {channel!r} is the computed integral of {source!r}, not a measurement; left out; name the channels "
        "to use it",
    )
    FEWER_CHANNELS = (
        "fewer channels",
        sentence(
            lambda n: (
                f"{_channels(n)} left out: with all channels the result is less clear; name the channels to use them"
            )
        ),
    )
    MEANS = (
        "means",
        "means over {size} samples are used, {rate:.6g} Hz: with all samples there is no clear result",
    )
    STILL_CHANNEL = "still channel", "channel {channel!r} stands still in this decay; left out"
    ONE_OF_TESTS = (
        "one of tests",
        sentence(
            lambda n: (
                f"the {_tests(n)}; {n['used']!r} is used: choose with {Argument('test')}, or join them with "
                f"{Argument('test', repr('all'))}"
            )
        ),
    )
    RESAMPLED = (
        "resampled",
        "{name} was resampled from {rate:.7g} to {onto:.7g} Hz, the rate of the first record; error below {error:.1e} "
        "of the motion",
    )
    NO_SPRINGS = "no springs", "springs and dampers were not found from the modes: {why}"
    ESTIMATED = "estimated", "the modes alone do not determine springs and dampers; they are fitted to the record "
    "itself"
    MOVED = "moved", "taken as the cause of the motion, instead of a free decay: {names}"
    NO_ESTIMATE = "no estimate", "springs and dampers were not found from the record itself: {why}"


class RecordCheck(Code):
    """Checks of the recording that the identification cannot see."""

    DECAY = "decay", sentence(lambda n: f"{str(n['doubt'])[:1].upper()}{str(n['doubt'])[1:]}.")
    NOT_REPEATED = (
        "not repeated",
        "{unlike} of the {others} other stretches that look like decays show none of these modes: the recording may be "
        "driven throughout, and this stretch may look like a decay by chance.",
    )
    DIED_BEFORE = (
        "died before",
        sentence(
            lambda n: (
                f"The decay that begins at {moment(n['start'])} s, of which this one is the end, looks as if it had "
                f"{'a mode' if n['number'] == 1 else 'modes'} at {n['hertz']} Hz beside these: what is fast dies first."
                if n["number"]
                else f"It is the end of a far larger motion, from {moment(n['start'])} s on, which no fit follows: "
                f"what is fast dies first, and may be missing."
            )
        ),
    )
    NEVER_SWINGS = (
        "never swings",
        "Nothing swings in the stretch that is used, and no hold or step before it was seen: the end of a pulse looks "
        "the same.",
    )
    FALLS_LATE = (
        "falls late",
        "The swings fall more later on than at first, or grow again, as dampers and friction do not let them: what "
        "drives the motion may still act, or two close modes beat.",
    )
    RUNS_DOWN = (
        "runs down",
        "The swings take longer and longer until the end, not only where they are large: a machine that runs down does "
        "so, and what has play.",
    )
    COMMANDED = (
        "commanded",
        sentence(
            lambda n: (
                f"W{_after_changes(n)[1:]}, about where it settles: what is between a command and the motion, "
                f"as a drive or a controller, is part of the modes."
            )
        ),
    )
    AFTER_LOCK = (
        "after lock",
        sentence(
            lambda n: (
                f"{_as_one(n)}: friction may hold one to the other, or a mode has died; what is found is of both as "
                f"one."
            )
        ),
    )
    LARGEST_USED = (
        "largest used",
        "No stretch is a free decay beyond doubt. The largest motion is used, which shows the same modes from several "
        "starts on.",
    )
    OF_START = (
        "of start",
        "Motion that dies soon after the release, at {hertz} Hz, is not among the modes: a force that ends looks the "
        "same as modes that are damped heavily.",
    )
    LARGER_ELSEWHERE = (
        "larger elsewhere",
        sentence(
            lambda n: (
                f"Before the decay that is used, about {moment(n['time'])} s, the record moves {n['times']:.0f} times "
                f"as much (rms): the decay is the end of another motion, as of what goes on where friction has stopped "
                f"the rest."
                if n["follows"]
                else f"Elsewhere the record moves {n['times']:.0f} times as much (rms), most about "
                f"{moment(n['time'])} s: what is found holds for small motion."
            )
        ),
    )
    ONE_OF_TESTS = "one of tests", sentence(lambda n: f"The {_tests(n)}; this is {n['used']!r} alone.")
    FEWER_CHANNELS = (
        "fewer channels",
        sentence(
            lambda n: (
                f"{_channels(n)[:1].upper()}{_channels(n)[1:]} left out: with all channels the result is less clear. "
                f"See whether they measure the motion of the same structure."
            )
        ),
    )
    MEANS = (
        "means",
        "Means over {size} samples are used: with all samples there is no clear result. Compare the fit with the "
        "record.",
    )
    NO_SHARED_MODE = "no shared mode", "{tests} share no mode: they do not seem to be tests of one structure."
    SHARES_NO_MODE = (
        "shares no mode",
        "{test} shares no mode with the others within their noise: it does not seem to be a test of the same "
        "structure. Leave it out.",
    )
    NOT_IN_ALL = "not in all", "Mode {mode} is significant in {held}, not in {not_in}."
    ODD_TEST = (
        "odd test",
        "{test} disagrees with the others on mode {mode}: chi-square {apart:.0f}, without it {without:.0f}. Leave it "
        "out, or find out what was different.",
    )
    IN_TEST = "in test", "{test}: {what}"
    GUESSED_UNIT = (
        "guessed unit",
        sentence(
            lambda n: (
                f"The {n['name']} is not stated. It is taken as {n['unit']}: as seconds, steps of {n['step']:.4g} are "
                f"too slow for a suspension. If it is {' or '.join(n['others']) or 'another unit, or no time'}, all "
                f"frequencies are wrong by the same factor. Give {rates_of_units(n)}."
            )
        ),
    )
    ODD_UNIT = (
        "odd unit",
        sentence(
            lambda n: (
                f"The {n['name']} makes the record {n['length']:.2g} s long: no logger of a suspension is so fast. "
                f"If it is another, all frequencies are wrong by the same factor. Give {Argument('fs')} if it is."
            )
        ),
    )
    SLOW_SAMPLES = (
        "slow samples",
        sentence(
            lambda n: (
                f"The samples are {n['step']:.4g} s apart by the time of the file, too slow for a suspension. If its "
                f"unit is ms, or it counts the rows, all frequencies are wrong by the same factor. Give "
                f"{Argument('fs')}: {n['rate']:.6g} if it is ms."
            )
        ),
    )
    DEFECTS = (
        "defects",
        sentence(
            lambda n: (
                f"{count(int(str(n['number'])), 'defect')} of the recording "
                f"{'was' if n['number'] == 1 else 'were'} found and not repaired: {in_a_row(n['kinds'])}."
            )
        ),
    )
