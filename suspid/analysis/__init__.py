"""The recipe: read, clean, find the decays, identify, judge."""

from suspid.analysis.checks import LEAST_EXPLAINED, as_sentence
from suspid.analysis.judgement import Judgement, judge

__all__ = ["LEAST_EXPLAINED", "Judgement", "as_sentence", "judge"]
