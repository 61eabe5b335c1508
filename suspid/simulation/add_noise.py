"""White noise of a given signal-to-noise ratio."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.arguments import explained
from suspid.errors import InputError
from suspid.records import as_response, inputs_of
from suspid.signals import as_signal
from suspid.units import Decibel

if TYPE_CHECKING:
    import control


@explained
def add_noise(
    response: control.TimeResponseData, *, snr_db: Decibel, rng: np.random.Generator
) -> control.TimeResponseData:
    """Return the response with white Gaussian noise on every channel; inputs stay as they are.

    Parameters
    ----------
    response : control.TimeResponseData
        The clean response.
    snr_db : float
        ``10 log10(mean power over the record / noise variance)`` in every channel [dB].
    rng : numpy.random.Generator
        Source of the noise.

    Raises
    ------
    InputError
        If the response is not a usable record, or a channel is zero throughout, so that no noise has that ratio.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import free_decay, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> clean = free_decay(car, np.arange(0, 3, 0.01), impulse="road")
    >>> noisy = add_noise(clean, snr_db=20.0, rng=np.random.default_rng(1))
    >>> float(np.std(noisy.y - clean.y) / np.sqrt(np.mean(clean.y**2))) < 0.2
    True
    """
    signal = as_signal(response)
    if not isinstance(rng, np.random.Generator):
        raise InputError(f"{rng=} is not a random generator; pass np.random.default_rng(seed)")
    if not np.isfinite(snr_db):
        raise InputError(f"{snr_db=} dB must be finite")
    power = np.mean(signal.values**2, axis=1)
    silent = [name for name, p in zip(signal.channels, power, strict=True) if p == 0]
    if silent:
        raise InputError(f"channel {silent[0]!r} is zero throughout: it cannot have an SNR of {snr_db:g} dB")
    std = np.sqrt(power * 10 ** (-snr_db / 10))
    noisy = signal.values + std[:, None] * rng.standard_normal(signal.values.shape)
    return as_response(
        np.asarray(response.time), noisy, signal.channels, title=f"{snr_db:g} dB", inputs=inputs_of(response)
    )
