"""Channels on a clock of their own, beside known roads and forces: where their delays are looked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from suspid.greybox.trials import Trial
from suspid.units import Hertz, Ratio, RealArray, Second

# Agreement of the nominal car with a record at some lag, over that at any other, from which the lag is believed: a
# periodic motion agrees at many.
CLEARLY_BEST: Ratio = 2.0
LONGEST_LAG: Ratio = 0.25  # lag, over a record, that is looked for: the rest must still be worth a fit
# Periods of the end of the band by which a delay may be off where its fit begins: of one period, it is found from none.
DELAY_REACH = 2.0
MOST_MARGIN: Ratio = 0.05  # of a record, to either side, that is given up where no channel is seen to be late


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Clocks:
    """Where the delays of the channels of one test are looked for."""

    about: RealArray  # (channel,) [s]
    reach: Second  # to either side
    margin: int  # samples of the inputs that are needed beside those of the channels


def clear_lag(score: RealArray, count: int, period: float, *, apart: float | None = None) -> int:
    """Return the lag [samples] of the best score of lags 0, 1, … and …, -1 of records of ``count`` samples.

    0 if that is within a period, or no better than others, which are ``apart`` by a period unless more is stated.

    Examples
    --------
    >>> score = np.ones(100)
    >>> score[20] = 5.0
    >>> clear_lag(score, 90, 3.0), clear_lag(score, 90, 30.0), clear_lag(np.ones(100), 90, 3.0)
    (20, 0, 0)
    """
    lags = np.fft.fftfreq(len(score), 1 / len(score)).astype(int)
    looked = np.abs(lags) <= LONGEST_LAG * count
    best = int(lags[looked][np.argmax(score[looked])])
    others = looked & (np.abs(lags - best) > (period if apart is None else apart))
    clear = score[best] > CLEARLY_BEST * np.max(score[others], initial=0.0)
    return best if clear and abs(best) > period else 0


def clocks_of(trial: Trial, expected: RealArray, late: Sequence[int], highest: Hertz) -> Clocks:
    """Return where the delays of channels are looked for, given what the nominal car shows (channel, sample).

    ``late`` are the channels whose delay is unknown, ``highest`` is the end of the band of the car.
    """
    period = 1 / (highest * trial.step)
    lags = np.zeros(len(trial.channels))
    for channel in late:
        shown, seen = (
            np.fft.rfft(row - np.mean(row), 2 * trial.count) for row in (expected[channel], trial.values[channel])
        )
        common = seen * shown.conj()
        common[np.fft.rfftfreq(2 * trial.count, trial.step) > highest] = 0
        # All lines that show something count alike: by their power a resonance would, which agrees at many lags.
        common /= np.abs(common) + np.median(np.abs(common[common != 0])) + np.finfo(float).tiny
        score = np.fft.irfft(common, 2 * trial.count) ** 2
        lags[channel] = clear_lag(score, trial.count, period, apart=DELAY_REACH * period)
    reach = int(np.clip(DELAY_REACH * period, 1, max(1.0, MOST_MARGIN * trial.count)))
    return Clocks(
        about=lags * trial.step,
        reach=reach * trial.step,
        margin=reach + 1 + int(np.max(np.abs(lags), initial=0)),
    )
