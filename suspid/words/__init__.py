"""What the library can say about a result: codes, and the words for each.

A `Code` is a member of an enumeration with its sentence; a `Remark` is a code with its numbers, and ``str(remark)``
is the sentence. A `Check` is a remark with its weight, a `Verdict` a level with its checks. Text, HTML and JSON take
their words from here; code elsewhere compares codes and never reads a sentence. To say something new, add a member
to the enumeration of its subject. Each subject is one module.
"""

from suspid.words.analysis import Note, RecordCheck
from suspid.words.cleaning import AS_MISSING, Cleaning, Defect, dead
from suspid.words.decays import DecayDoubt, DecayKind, DecayRemark
from suspid.words.fleet import Failure, FleetCheck, FleetHeadline, Step
from suspid.words.greybox import EstimateCheck, EstimateHeadline
from suspid.words.identification import AmplitudeRemark, Headline, ModeCheck
from suspid.words.io import ASIDE, DAMAGE, OTHER_LENGTHS, LeftOut, rates_of_units
from suspid.words.next_steps import NextStep, next_steps
from suspid.words.reasons import Reason
from suspid.words.reconstruction import ReconstructionCheck, ReconstructionHeadline, ReconstructionNote, Suspect
from suspid.words.remarks import MOST_LISTED, MOST_NAMED, Code, Number, Remark, amount, count, in_a_row, percent
from suspid.words.verdicts import Check, Level, Verdict, label_in_words
from suspid.words.wear import DamperState, TrendCheck, TrendHeadline, WearCheck, WearHeadline

__all__ = [
    "ASIDE",
    "AS_MISSING",
    "DAMAGE",
    "MOST_LISTED",
    "MOST_NAMED",
    "OTHER_LENGTHS",
    "AmplitudeRemark",
    "Check",
    "Cleaning",
    "Code",
    "DamperState",
    "DecayDoubt",
    "DecayKind",
    "DecayRemark",
    "Defect",
    "EstimateCheck",
    "EstimateHeadline",
    "Failure",
    "FleetCheck",
    "FleetHeadline",
    "Headline",
    "LeftOut",
    "Level",
    "ModeCheck",
    "NextStep",
    "Note",
    "Number",
    "Reason",
    "ReconstructionCheck",
    "ReconstructionHeadline",
    "ReconstructionNote",
    "RecordCheck",
    "Remark",
    "Step",
    "Suspect",
    "TrendCheck",
    "TrendHeadline",
    "Verdict",
    "WearCheck",
    "WearHeadline",
    "amount",
    "count",
    "dead",
    "in_a_row",
    "label_in_words",
    "next_steps",
    "percent",
    "rates_of_units",
]
