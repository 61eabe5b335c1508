"""What to do next, after the checks of a verdict."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from suspid.wording import Argument, AtCommandLine
from suspid.words.analysis import Note, RecordCheck
from suspid.words.drives import DriveRemark
from suspid.words.greybox import EstimateCheck
from suspid.words.grip import GripCheck
from suspid.words.identification import ModeCheck
from suspid.words.reconstruction import ReconstructionCheck
from suspid.words.remarks import Code, Remark, sentence
from suspid.words.verdicts import Verdict
from suspid.words.wear import WearCheck


class NextStep(Code):
    """What to do next."""

    LIMITS_MISSED = (
        "limits missed",
        sentence(lambda n: f"Change what is outside the limits: {', '.join(n['names'])}."),
    )
    LIMITS_OPEN = (
        "limits open",
        sentence(
            lambda n: f"Not known to be within the limits: {', '.join(n['names'])}; the table of limits says why."
        ),
    )
    USE = "use", "No check speaks against these values: use them with their intervals."
    RECORD_A_DECAY = (
        "record a decay",
        "Record a free decay: displace what swings and release it (a car: push the body down, or let the wheels drop "
        "off a kerb, with the engine off), and record until the motion has died away. `suspid drive` takes everyday "
        "driving.",
    )
    RECORD_LONGER = "record longer", "Record until the motion has died away in the noise."
    WHICH_PART = (
        "which part",
        sentence(
            lambda _: (
                f"Look at the decays found, and choose one with {Argument('decay', 'N')}, or a stretch with "
                f"{Argument('start')} and {Argument('stop')}."
            )
        ),
    )
    CHOOSE_TEST = (
        "choose test",
        sentence(
            lambda _: (
                f"Choose one of the tests in the file with {Argument('test', 'NAME')}, or join them with "
                f"{Argument('test', repr('all'))}."
            )
        ),
    )
    LEAVE_OUT = "leave out", "Leave out the test that does not belong to the others, or find out what was different."
    REPEAT = (
        "repeat",
        "Repeat the test and join the files (suspid report FILE FILE…): the intervals shrink with the root of their "
        "number.",
    )
    TWO_AMPLITUDES = (
        "two amplitudes",
        "Repeat the test at half the amplitude: values that change with it indicate friction, or a nonlinear spring "
        "or damper.",
    )
    CHANNELS = (
        "channels",
        sentence(
            lambda _: (
                f"Look at the channels in their table; leave out those that show other motion ({Argument('without')})."
            )
        ),
    )
    QUIET = "quiet", "Switch off rotating machines (engine, fans), or leave out the stretch in which they run."
    CLEANING = "cleaning", "Look at the defects in the cleaning table, and record again what was clipped or lost."
    ADD_MASS = (
        "add mass",
        "This test does not determine all springs and dampers. Test again with a known mass added and reconstruct "
        "from both tests, or put a sensor on another mass.",
    )
    RENAME = (
        "rename",
        sentence(
            lambda _: (
                f"Name the channels by what they measure on the car, such as by its masses"
                f"{AtCommandLine('rename', 'OLD=NEW')}: the shapes of the modes then count too."
            )
        ),
    )
    CHECK_CAR = (
        "check car",
        "Check the masses and the topology in the car file, and the names and units of the channels. Masses and "
        "gains that would explain the modes are listed with the springs and dampers.",
    )
    LET_FREE = (
        "let free",
        "Check the topology, the bounds and the fixed parameters: the values named in the verdict depend on them.",
    )
    WRITE_CAR = (
        "write car",
        "Springs and dampers differ from nominal: if the masses are right, use the values found.",
    )
    LOOK_AT_DAMPERS = (
        "look at dampers",
        "Inspect the worn dampers (leaks, bushings). Confirm the wear by another drive or on a test bench before "
        "replacing them.",
    )
    POOR_GRIP = (
        "poor grip",
        "The grip of a wheel is not above the limit of test benches: check its damper and tire.",
    )
    DRIVE_AGAIN = (
        "drive again",
        "Drive again after some weeks, and compare with this result: a continuing loss shows in the trend.",
    )
    KEEP = (
        "keep",
        sentence(
            lambda _: (
                f"Keep this result as JSON for the next drive ({Argument('before')}): wear is detected much better "
                f"against an earlier drive than against nominal values."
            )
        ),
    )
    USE_CURVES = (
        "use curves",
        "For a damper that is not viscous, use its curve and the stiffness found with it, not its c.",
    )
    RECORD_WAY = (
        "record way",
        sentence(
            lambda _: (
                f"Record speed (CAN or GPS) and lateral acceleration or yaw rate, or name their channels "
                f"({Argument('speed')}, {Argument('lateral')})."
            )
        ),
    )
    MEASURE_WHEELS = (
        "measure wheels",
        "Measure the acceleration of each wheel as well: springs, dampers and damping need it.",
    )
    GIVE_CAR = (
        "give car",
        sentence(lambda _: f"Give the masses and nominal struts ({Argument('car')}) to find springs and dampers."),
    )


# What follows from each check that speaks against a result, or is worth a note.
AFTER: dict[Code, NextStep] = {
    ModeCheck.NOTHING_DECAYS: NextStep.RECORD_A_DECAY,
    ModeCheck.NO_FREE_DECAY: NextStep.RECORD_A_DECAY,
    ModeCheck.STEADY_LINE: NextStep.RECORD_A_DECAY,
    ModeCheck.GROWING: NextStep.RECORD_A_DECAY,
    ModeCheck.HARDLY_EXPLAINED: NextStep.WHICH_PART,
    ModeCheck.LATE_MOTION: NextStep.WHICH_PART,
    ModeCheck.HELD_UP: NextStep.WHICH_PART,
    RecordCheck.DECAY: NextStep.WHICH_PART,
    RecordCheck.NEVER_SWINGS: NextStep.WHICH_PART,
    RecordCheck.DIED_BEFORE: NextStep.WHICH_PART,
    RecordCheck.LARGEST_USED: NextStep.WHICH_PART,
    RecordCheck.AFTER_LOCK: NextStep.WHICH_PART,
    RecordCheck.FALLS_LATE: NextStep.WHICH_PART,
    RecordCheck.RUNS_DOWN: NextStep.WHICH_PART,
    ModeCheck.FEW_CYCLES: NextStep.RECORD_LONGER,
    ModeCheck.FEW_SAMPLES: NextStep.RECORD_LONGER,
    ModeCheck.NOT_CROSS_CHECKED: NextStep.RECORD_LONGER,
    ModeCheck.HALVES_DISAGREE: NextStep.TWO_AMPLITUDES,
    ModeCheck.HARMONICS: NextStep.TWO_AMPLITUDES,
    ModeCheck.MIDDLE: NextStep.TWO_AMPLITUDES,
    ModeCheck.STANDS_STILL: NextStep.TWO_AMPLITUDES,
    ModeCheck.REPEATS_DISAGREE: NextStep.TWO_AMPLITUDES,
    ModeCheck.UNRESOLVED: NextStep.TWO_AMPLITUDES,
    ModeCheck.PARTS: NextStep.TWO_AMPLITUDES,
    ModeCheck.BROAD_AND_NARROW: NextStep.TWO_AMPLITUDES,
    ModeCheck.BEATS: NextStep.TWO_AMPLITUDES,
    ModeCheck.FLASH: NextStep.WHICH_PART,
    ModeCheck.PULSE_TRAIN: NextStep.WHICH_PART,
    ModeCheck.IN_A_ROW: NextStep.QUIET,
    ModeCheck.BEGUN_TONES: NextStep.WHICH_PART,
    ModeCheck.GROWING_BESIDE: NextStep.WHICH_PART,
    ModeCheck.CHANNELS_UNEXPLAINED: NextStep.CHANNELS,
    ModeCheck.SHARED_NOISE: NextStep.CHANNELS,
    ModeCheck.OUT_OF_PHASE: NextStep.CHANNELS,
    ModeCheck.MULTIPLE: NextStep.CHANNELS,
    ModeCheck.RESIDUAL_LINE: NextStep.QUIET,
    ModeCheck.RESIDUAL_MODE: NextStep.WHICH_PART,
    ModeCheck.STEADY_TONES: NextStep.QUIET,
    ModeCheck.FADING_TONES: NextStep.RECORD_LONGER,
    ModeCheck.DAMPING_UNKNOWN: NextStep.REPEAT,
    ModeCheck.KNOWN_ROUGHLY: NextStep.REPEAT,
    RecordCheck.ONE_OF_TESTS: NextStep.CHOOSE_TEST,
    RecordCheck.NO_SHARED_MODE: NextStep.LEAVE_OUT,
    RecordCheck.SHARES_NO_MODE: NextStep.LEAVE_OUT,
    RecordCheck.ODD_TEST: NextStep.LEAVE_OUT,
    RecordCheck.DEFECTS: NextStep.CLEANING,
    ReconstructionCheck.ALTERNATIVES: NextStep.ADD_MASS,
    ReconstructionCheck.NEAR_MISS: NextStep.ADD_MASS,
    ReconstructionCheck.BY_NOMINAL: NextStep.ADD_MASS,
    EstimateCheck.ALTERNATIVES: NextStep.ADD_MASS,
    EstimateCheck.BY_NOMINAL: NextStep.ADD_MASS,
    Note.NO_SPRINGS: NextStep.ADD_MASS,
    ReconstructionCheck.CHANNEL_UNKNOWN: NextStep.RENAME,
    ReconstructionCheck.UNEXPLAINED: NextStep.CHECK_CAR,
    ReconstructionCheck.OTHER_UNITS: NextStep.CHECK_CAR,
    EstimateCheck.NOT_ONE_CAR: NextStep.LEAVE_OUT,
    EstimateCheck.UNEXPLAINED: NextStep.CHECK_CAR,
    EstimateCheck.FOLLOWS: NextStep.CHECK_CAR,
    ReconstructionCheck.VANISHED: NextStep.LET_FREE,
    ReconstructionCheck.AT_BOUND: NextStep.LET_FREE,
    ReconstructionCheck.ACTIVE: NextStep.LET_FREE,
    EstimateCheck.VANISHED: NextStep.LET_FREE,
    EstimateCheck.AT_BOUND: NextStep.LET_FREE,
    ReconstructionCheck.VAGUE: NextStep.REPEAT,
    EstimateCheck.VAGUE: NextStep.REPEAT,
    ReconstructionCheck.CHANGED: NextStep.WRITE_CAR,
    EstimateCheck.CHANGED: NextStep.WRITE_CAR,
    WearCheck.LOST: NextStep.LOOK_AT_DAMPERS,
    WearCheck.PHASE_FAILS: NextStep.LOOK_AT_DAMPERS,
    GripCheck.FAILS: NextStep.POOR_GRIP,
    GripCheck.NEAR: NextStep.POOR_GRIP,
    WearCheck.SOME: NextStep.DRIVE_AGAIN,
    WearCheck.WIDE: NextStep.KEEP,
    WearCheck.SPRING: NextStep.KEEP,
    WearCheck.BENT: NextStep.KEEP,
    DriveRemark.BENT: NextStep.USE_CURVES,
    DriveRemark.BY_CURVES: NextStep.USE_CURVES,
    DriveRemark.BRAKING_UNKNOWN: NextStep.RECORD_WAY,
    DriveRemark.CORNERING_UNKNOWN: NextStep.RECORD_WAY,
    DriveRemark.NO_WHEELS: NextStep.MEASURE_WHEELS,
}


def next_steps(verdict: Verdict, *, car: bool, further: Sequence[Verdict] = ()) -> tuple[Remark, ...]:
    """Return what to do next, the gravest first; ``car`` says whether one was given.

    ``further`` are verdicts on what a result means, such as wear and grip: what follows from their doubts comes first.

    Examples
    --------
    >>> from suspid.words import Headline
    >>> [str(step.code) for step in next_steps(Verdict(Remark(Headline.MODES, {"modes": 2})), car=False)]
    ['use', 'give car']
    """
    return tuple(Remark(step) for step in dict.fromkeys(_steps(verdict, car=car, further=further)))


def _steps(verdict: Verdict, *, car: bool, further: Sequence[Verdict]) -> Iterator[NextStep]:
    meant = [remark for one in further for remark in one.doubts]
    yield from sorted((AFTER[remark.code] for remark in meant if remark.code in AFTER), key=list(NextStep).index)
    if not verdict.doubts:
        yield NextStep.USE
    steps = [AFTER[remark.code] for remark in (*verdict.doubts, *verdict.notes) if remark.code in AFTER]
    # Sensors that are there and have other names come before further ones.
    if NextStep.RENAME in steps:
        steps = [NextStep.RENAME if step is NextStep.ADD_MASS else step for step in steps]
    yield from steps
    if not car:
        yield NextStep.GIVE_CAR
