"""Power spectra of the wheels' motion, stretch by stretch, as the multitaper method estimates them.

The best estimate of the given motion from all channels, ``X = Y_g + S_g T^H R^-1 (Y_o - T Y_g)``, holds all that a
record says of it; its noise has the covariance ``S_g - S_g T^H R^-1 T S_g``. D. J. Thomson, Proc. IEEE 70 (1982)
1055-1096, for the tapers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from suspid.greybox.measured_causes import WheelProblem
from suspid.greybox.noise_levels import Levels, covariance_of
from suspid.greybox.transfers import transfer
from suspid.greybox.trials import Trial
from suspid.signals import PASSED
from suspid.units import Hertz, RealArray

TAPER_BANDWIDTH = 2.0  # half bandwidth of the tapers, in lines
TAPERS = round(2 * TAPER_BANDWIDTH) - 1  # the next one leaks
SPAN = 6  # lines to either side that the kernel of the tapers spans
MOMENTS = 96  # of a stretch at which the speed is taken


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Track:
    """Power of the motion of one wheel in the records of one logger."""

    source: int
    channel: int
    wheel: int  # coordinate
    wide: RealArray  # (wide line,): frequencies of the model [Hz]
    kernel: RealArray  # (line, wide line): what the tapers make of a spectrum
    records: NDArray[np.intp]  # (stretch,): number of the record
    times: RealArray  # (stretch,): middle [s]
    power: RealArray  # (stretch, line)
    noise: RealArray  # (line,): power of the noise of the motion's estimate
    samples: int  # of a stretch
    speeds: RealArray | None  # (stretch, moment) [m/s]
    weights: RealArray  # (moment,): of the tapers, sum 1

    @property
    def log_speed(self) -> RealArray:
        """Logarithm of the speed of each stretch, (stretch,); 0 where it is unknown."""
        known = np.ones_like(self.weights)[None] if self.speeds is None else self.speeds
        return np.asarray(np.broadcast_to(np.log(known) @ self.weights, len(self.power)), float)

    @property
    def hertz(self) -> RealArray:
        """Frequencies at which the power is compared [Hz]."""
        return np.asarray(self.wide[np.argmax(self.kernel, axis=1)])

    @property
    def spacing(self) -> Hertz:
        """Distance of the lines [Hz]."""
        return float(self.wide[1] - self.wide[0])


def tracks_of(
    problem: WheelProblem,
    z: RealArray,
    number: int,
    levels: Levels,
    trials: Sequence[Trial],
    *,
    speeds: Sequence[RealArray] | None,
    band: tuple[Hertz, Hertz],
) -> list[Track]:
    """Return the power of every given motion of one logger in a band, at the unknowns z of the suspension."""
    from scipy.signal.windows import dpss

    source = problem.sources[number]
    trial, layout, spectra = source.trial, source.layout, source.spectra
    samples = spectra.samples
    tapers = dpss(samples, TAPER_BANDWIDTH, TAPERS)
    spacing = 1 / (samples * trial.step)
    first = max(1, int(np.ceil(band[0] / spacing)))
    lines = np.arange(first, int(min(band[1], PASSED / trial.step) / spacing) + 1)
    made = transfer(
        layout, np.asarray(2j * np.pi * spacing * lines, complex), problem.physics(z, number), problem.unknowns.rows,
        mounts=problem.extras.mounts, gains=source.gains, delays=source.delays,
    )  # fmt: skip
    seen, causes = levels.spectra(source.basis)
    at = np.log(spacing * lines)
    outputs = np.exp([np.interp(at, np.log(spectra.hertz), row) for row in np.log(seen).T]).T
    back = made.T.conj().swapaxes(1, 2) * causes[:, None]
    weigh = back @ np.linalg.inv(covariance_of(made.T, outputs, causes))
    own = np.arange(len(causes))
    noise = causes - (weigh @ made.T * causes)[:, own, own].real
    cut = np.concatenate([_cut(trials[i].values, samples) for i in source.numbers], axis=1)
    cut = cut - cut.mean(axis=2, keepdims=True)
    power = np.zeros((len(causes), cut.shape[1], len(lines)))
    for taper in tapers:
        shown = np.fft.rfft(cut * taper, axis=2)[:, :, lines]
        y_o, y_g = (shown[list(which)].transpose(2, 0, 1) for which in (layout.outputs, layout.causes))
        motion = y_g + weigh @ (y_o - made.T @ y_g)
        power += np.abs(motion.transpose(1, 2, 0)) ** 2 / TAPERS
    wide = np.arange(max(1, first - SPAN), min(lines[-1] + SPAN, samples // 2) + 1)
    moments = ((np.arange(MOMENTS) + 0.5) / MOMENTS * samples).astype(int)
    weights = np.mean(tapers**2, axis=0)[moments]
    rolling = None if speeds is None else np.concatenate([_cut(speeds[i][None], samples)[0] for i in source.numbers])
    middles = [(np.arange(n) + 0.5) * samples * trial.step for n in spectra.counts]
    return [
        Track(
            source=number,
            channel=channel,
            wheel=layout.given[int(np.argmax(np.abs(layout.on_given[channel])))],
            wide=spacing * wide,
            kernel=_kernel(tapers, lines, wide),
            records=np.repeat(source.numbers, spectra.counts),
            times=np.concatenate([start + middle for start, middle in zip(source.starts, middles, strict=True)]),
            power=power[i],
            noise=noise[:, i],
            samples=samples,
            speeds=None if rolling is None else rolling[:, moments],
            weights=weights / np.sum(weights),
        )
        for i, channel in enumerate(layout.causes)
    ]


def _cut(values: RealArray, samples: int) -> RealArray:
    """Return the whole stretches of a record, (channel, stretch, sample)."""
    count = values.shape[1] // samples
    return values[:, : count * samples].reshape(len(values), count, samples)


def _kernel(tapers: RealArray, lines: np.ndarray, wide: np.ndarray) -> RealArray:
    """Return how much of the power at each line of the model the tapers show at each line."""
    apart = np.arange(SPAN + 1)
    t = np.arange(tapers.shape[1]) / tapers.shape[1]
    seen = np.exp(-2j * np.pi * apart[:, None] * t) @ tapers.T
    share = np.mean(np.abs(seen) ** 2, axis=1)
    share /= share[0] + 2 * np.sum(share[1:])
    away = np.abs(lines[:, None] - wide)
    return np.asarray(np.where(away <= SPAN, share[np.minimum(away, SPAN)], 0.0))
