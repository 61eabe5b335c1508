"""Identify the modes of a free decay."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from suspid.arguments import explained
from suspid.cleaning import RecordLike, as_record, clipped_run
from suspid.errors import IdentificationError, InputError, RecordError
from suspid.identification.by_likelihood import Forces, by_likelihood
from suspid.identification.by_ridges import by_ridges
from suspid.identification.identification import Identification, Method
from suspid.identification.steps import FourSteps
from suspid.levels import FEWEST_SAMPLES, ROUNDING
from suspid.signals import Signal, as_signal
from suspid.threads import in_one_thread
from suspid.units import Hertz, RealArray, angular
from suspid.values import check_count
from suspid.wavelets import BANDWIDTHS, row_band
from suspid.wording import Argument

if TYPE_CHECKING:
    import control


@explained
@in_one_thread
def identify(
    response: RecordLike,
    *,
    fs: Hertz | None = None,
    modes: int | None = None,
    method: Method = "likelihood",
    band_hz: tuple[Hertz, Hertz] | None = None,
    bandwidth: float | None = None,
    candidates: Iterable[float] = BANDWIDTHS,
) -> Identification:
    """Identify the modes of a free decay.

    "likelihood" fits damped exponentials to all channels jointly, by maximum likelihood: common poles, and in each
    channel amplitudes, an offset and white noise of unknown level. Poles are added while BIC decreases, up to 50 pairs.
    Tones, drifts and traces are fitted but are not modes. The covariance is the Cramér-Rao bound at the estimate,
    widened where the residual is not white noise.

    Where the residual of the linear fit indicates nonlinearity, and no ``band_hz`` is given, friction, drag, and
    cubic and bilinear springs and dampers are fitted as well. They are kept if they explain more than a further pole
    would; with ``modes`` given, if they explain more than their parameters cost. Then ``.forces`` names them,
    ``.modes`` are those of the equivalent linear system over the record, and ``.amplitude_dependence`` has each natural
    frequency and damping ratio over the amplitude.

    "ridge" is the wavelet method of the paper: the bandwidth N of least entropy, the transform, its ridges and
    skeletons, and lines through log modulus and phase. N / 2, N / 4 and N / 8 are tried as well; each ridge keeps the
    bandwidth that leaves its pole the smallest standard deviation. The damping must be light.

    Parameters
    ----------
    response : control.TimeResponseData, or what `as_record` takes
        A free decay from its first sample on, uniformly sampled; all channels are used together.
    fs : float, optional
        Sampling rate [Hz] of samples that come without a time.
    modes : int, optional
        Number of modes: the strongest of those that the record supports. Poles close to them in frequency are then left
        out, and the others are fitted again. Default: all modes.
    method : {"likelihood", "ridge"}
        See above.
    band_hz : (float, float), optional
        Frequency range [Hz]. Default: all; for the ridges from four
        cycles in the record to 0.9 of the Nyquist frequency.
    bandwidth : float, optional
        N of the wavelet. Default: that of least entropy among ``candidates``. With "likelihood" both are for the
        scalogram and the skeletons of ``.steps`` alone.
    candidates : iterable of float
        Bandwidths among which to choose.

    Returns
    -------
    Identification
        Modes with uncertainty, with all that is needed to check them. Without ``modes`` there may be no mode at all;
        the verdict says why.

    Raises
    ------
    IdentificationError
        If fewer modes than requested are significant; ``.found`` has those found.
    RecordError, InputError
        If the record or a setting cannot be used.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import add_noise, free_decay, quarter_car
    >>> car = quarter_car(seat_mass=200, chassis_mass=200, tire_mass=200,
    ...                   seat_stiffness=200e3, chassis_stiffness=400e3, tire_stiffness=800e3,
    ...                   seat_damping=300, chassis_damping=200, tire_damping=100)
    >>> record = free_decay(car, np.arange(0, 10, 0.002), initial_state={"v_tire": 1.0})
    >>> identify(record).modes.wn.round(4)
    array([21.2737, 50.1386, 83.8549])
    >>> noisy = add_noise(record, snr_db=20.0, rng=np.random.default_rng(1))
    >>> len(identify(noisy).modes)
    3
    """
    if method not in ("likelihood", "ridge"):
        raise InputError(Argument("method", repr(method)), " is unknown; the methods are 'likelihood' and 'ridge'")
    check_count("modes", modes)
    among = tuple(float(n) for n in candidates)
    chosen = among != tuple(map(float, BANDWIDTHS))
    if bandwidth is not None and chosen:
        raise InputError(
            Argument("candidates"), " are not used with ", Argument("bandwidth", f"{bandwidth:g}"), "; leave out one"
        )
    response = as_record(response, fs=fs)
    band = angular(band_hz)
    signal, steps = _steps(response, band, count=modes, bandwidth=bandwidth, candidates=among, chosen=chosen)
    if method == "ridge":
        return by_ridges(response, signal, steps)
    forces = Forces.SOUGHT if band is None else Forces.IGNORED
    return by_likelihood(response, signal, steps.signal.values, steps, band, forces=forces)


def identify_linear(response: control.TimeResponseData, *, strict: bool = False) -> Identification:
    """Identify the modes of a free decay by its linear fit alone: friction and other forces are not looked for.

    With ``strict``, a record whose fit gives reason to look for them is refused.
    """
    signal, steps = _steps(response, None)
    forces = Forces.REFUSED if strict else Forces.IGNORED
    return by_likelihood(response, signal, steps.signal.values, steps, None, forces=forces)


def _steps(
    response: control.TimeResponseData,
    band: tuple[float, float] | None,
    *,
    count: int | None = None,
    bandwidth: float | None = None,
    candidates: tuple[float, ...] = tuple(map(float, BANDWIDTHS)),
    chosen: bool = False,
) -> tuple[Signal, FourSteps]:
    """Return the signal of a record and the wavelet steps on its deviation from the mean."""
    signal = as_signal(response, least=FEWEST_SAMPLES)
    return signal, FourSteps(
        signal=replace(signal, values=_centred(signal)),
        count=count,
        band=row_band(signal, band),
        bandwidth=bandwidth,
        candidates=candidates,
        chosen=chosen,
    )


def _centred(signal: Signal) -> RealArray:
    """Return the samples less their means, or refuse channels that are constant or clipped."""
    # Sums depend on how samples stand in memory.
    in_rows = signal.values.strides[1] == signal.values.itemsize
    values = signal.values if in_rows else np.ascontiguousarray(signal.values)
    centred = values - values.mean(axis=1, keepdims=True)
    for name, samples, about in zip(signal.channels, signal.values, centred, strict=True):
        if not max(about.max(), -about.min()) > ROUNDING * max(samples.max(), -samples.min()):
            raise IdentificationError(f"channel {name!r} is constant: it contains no decay; leave it out")
    _check_clipping(signal)
    return np.asarray(centred)


def _check_clipping(signal: Signal) -> None:
    """Refuse a channel that stays at its largest or smallest value while it is moving fast."""
    for name, samples in zip(signal.channels, signal.values, strict=True):
        for largest, word in ((True, "largest"), (False, "smallest")):
            run = clipped_run(samples, largest=largest)
            if run is not None:
                first, count = run
                limit, time = samples[first], signal.timepts
                at = np.flatnonzero(samples == limit)
                behind = len(samples) - 1 - int(at[-1])
                enough = (
                    f"start the record after t = {time[at[-1]]:g} s"
                    if behind >= FEWEST_SAMPLES
                    else ("record it again with a larger range")
                )
                raise RecordError(
                    f"channel {name!r} is clipped: {len(at)} samples are at its {word} value {limit:g}, {count} of "
                    f"them consecutive from t = {time[first]:g} s; {enough}, or leave the channel out"
                )
