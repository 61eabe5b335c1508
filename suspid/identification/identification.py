"""The result of `identify`, and all that is needed to judge it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np

from suspid.cleaning import derivative_orders
from suspid.errors import IdentificationError
from suspid.identification.considered import Considered
from suspid.identification.halves import disagreement
from suspid.identification.noise import lag_one
from suspid.identification.nonlinear import AmplitudeDependence, Force
from suspid.identification.parts import poles_of
from suspid.identification.steps import FourSteps
from suspid.identification.tables import tables_of
from suspid.identification.verdict import verdict_of
from suspid.model import ModalSet
from suspid.results import Result
from suspid.samples import AsResponse, held
from suspid.signals import as_signal
from suspid.units import ComplexArray, RealArray
from suspid.values import frozen_real, samples_in_words
from suspid.wavelets import BandwidthSearch, Ridge, Scalogram, SkeletonFit, fit_skeleton
from suspid.words import Verdict

if TYPE_CHECKING:
    import control


Method = Literal["likelihood", "ridge"]


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Identification(Result):
    """Result of `identify`, with all that is needed to check it.

    Parameters
    ----------
    response : control.TimeResponseData
        The record.
    method : {"likelihood", "ridge"}
        How it was identified.
    modes : ModalSet
        The modes, with their uncertainty.
    fitted : control.TimeResponseData
        The motion that was found (with offset, tones and drift), as it fits the record.
    residual : control.TimeResponseData
        The record less `fitted`.
    noise_std : ndarray (channel,)
        Standard deviation of the noise, in the unit of each channel.
    loudness : ndarray (mode,)
        Power of the residual near each mode over that of the noise [1]. Where it is above 1 the covariance
        of the mode is widened by it, or by the square of `halves` if that is more. Ones for method "ridge".
    considered : tuple of Considered
        Rejected poles, and why each is not a mode.
    steps : FourSteps
        The wavelet's view of the record.
    amplitude_dependence : tuple of AmplitudeDependence
        How each mode depends on its amplitude; empty if the decay is linear.
    forces : tuple of Force
        The forces, other than linear ones, with which the decay was fitted.

    Examples
    --------
    >>> from suspid import as_record, identify
    >>> t = np.arange(400) / 100
    >>> noise = 1e-3 * np.random.default_rng(1).standard_normal(t.size)
    >>> found = identify(as_record(np.exp(-t) * np.cos(20 * t) + noise, timepts=t, channels=["seat"]))
    >>> found.modes.zeta.round(3), found.method
    (array([0.05]), 'likelihood')
    >>> bool(found.explained[0] > 0.999), found.residual.outputs.shape
    (True, (400,))
    """

    response: control.TimeResponseData = AsResponse("response")  # noqa: RUF009 - no default
    method: Method
    modes: ModalSet
    fitted: control.TimeResponseData = AsResponse("fitted")  # noqa: RUF009 - no default
    residual: control.TimeResponseData = AsResponse("residual")  # noqa: RUF009 - no default
    noise_std: RealArray
    loudness: RealArray
    considered: tuple[Considered, ...]
    steps: FourSteps
    amplitude_dependence: tuple[AmplitudeDependence, ...] = ()
    forces: tuple[Force, ...] = ()

    @property
    def bandwidth_search(self) -> BandwidthSearch | None:
        """Entropy against bandwidth; None if the bandwidth was given.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, identify
        >>> t = np.arange(0, 4, 0.01)
        >>> decay = as_record(np.exp(-t) * np.cos(20 * t), timepts=t)
        >>> identify(decay, method="ridge", modes=1, bandwidth=8.0).bandwidth_search is None
        True
        >>> search = identify(decay, method="ridge", modes=1, candidates=[4.0, 8.0, 16.0]).bandwidth_search
        >>> search.best
        8.0
        """
        return self.steps.search

    @property
    def scalogram(self) -> Scalogram:
        """The transform of the record less its mean.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, identify
        >>> t = np.arange(0, 4, 0.01)
        >>> decay = as_record(np.exp(-t) * np.cos(20 * t), timepts=t)
        >>> found = identify(decay, method="ridge", modes=1, bandwidth=8.0)
        >>> found.scalogram.wavelet.bandwidth
        8.0
        """
        return self.steps.scalogram

    @property
    def ridges(self) -> tuple[Ridge, ...]:
        """The significant ridges, each with its own wavelet, skeleton and window; perhaps none.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, identify
        >>> t = np.arange(0, 4, 0.01)
        >>> decay = as_record(np.exp(-t) * np.cos(20 * t), timepts=t)
        >>> found = identify(decay, method="ridge", modes=1, bandwidth=8.0)
        >>> [round(ridge.omega) for ridge in found.ridges]
        [20]
        """
        try:
            return self.steps.ridges
        except IdentificationError:
            return ()

    @property
    def lines(self) -> tuple[SkeletonFit, ...]:
        """The lines through log modulus and phase of each ridge.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, identify
        >>> t = np.arange(0, 4, 0.01)
        >>> decay = as_record(np.exp(-t) * np.cos(20 * t), timepts=t)
        >>> found = identify(decay, method="ridge", modes=1, bandwidth=8.0)
        >>> [complex(np.round(line.pole, 2)) for line in found.lines]
        [(-1+20j)]
        """
        return tuple(fit_skeleton(ridge) for ridge in self.ridges)

    @cached_property
    def explained(self) -> RealArray:
        """Share of each channel's energy about its mean that the fit explains [1], (channel,).

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, identify
        >>> t = np.arange(0, 4, 0.01)
        >>> found = identify(as_record(np.exp(-t) * np.cos(20 * t), timepts=t), modes=1)
        >>> found.explained.round(6)
        array([1.])
        """
        signal, left = as_signal(held(self, "response")).values, as_signal(held(self, "residual")).values
        energy = np.sum((signal - signal.mean(axis=1, keepdims=True)) ** 2, axis=1)
        return frozen_real(1 - np.sum(left**2, axis=1) / np.where(energy > 0, energy, 1.0))

    @property
    def whiteness(self) -> RealArray:
        """Correlation of each channel's residual with itself one sample later [1], (channel,): 0 for white noise.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, identify
        >>> t = np.arange(400) / 100
        >>> noise = 1e-3 * np.random.default_rng(1).standard_normal(t.size)
        >>> found = identify(as_record(np.exp(-t) * np.cos(20 * t) + noise, timepts=t, channels=["seat"]))
        >>> bool(abs(found.whiteness[0]) < 0.2)
        True
        """
        return lag_one(as_signal(held(self, "residual")).values)

    @property
    def collinearity(self) -> RealArray:
        """Modal phase collinearity [1], (mode,): 1 if all channels move in phase or in antiphase, 0 if they circle.

        Velocities and accelerations, by the units or words in the names of channels, are compared as displacements.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import eigenmodes, free_decay, identify, quarter_car
        >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
        ...                   tire_stiffness=200e3, chassis_damping=1500)
        >>> found = identify(free_decay(car, np.arange(0, 4, 0.01), initial_state={"v_tire": 1.0}))
        >>> [round(value, 2) for value in found.collinearity.tolist()]
        [0.99, 0.99]
        """
        assert self.modes.shapes is not None
        shapes = as_displacements(self.modes)
        re, im = shapes.real, shapes.imag
        xx, yy, xy = np.sum(re**2, axis=0), np.sum(im**2, axis=0), np.sum(re * im, axis=0)
        total = np.where(xx + yy > 0, xx + yy, 1.0)
        return np.asarray(((xx - yy) ** 2 + 4 * xy**2) / total**2)

    @cached_property
    def halves(self) -> RealArray:
        """How far the two halves of the decay disagree on each mode [1], (mode,), in their standard deviations.

        The record is cut where half of what it says of the mode's pole lies before, and all poles are fitted to
        each part alone, starting from `modes`. The figure is the distance of the two poles over its standard
        deviation in the noise, root mean square of real and imaginary part: about 1 for a linear decay. It is
        NaN for a real pole, where a part does not hold the mode, and for modes that depend on their amplitude.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, identify
        >>> t = np.arange(400) / 100
        >>> noise = 1e-3 * np.random.default_rng(1).standard_normal(t.size)
        >>> found = identify(as_record(np.exp(-t) * np.cos(20 * t) + noise, timepts=t, channels=["seat"]))
        >>> bool(found.halves[0] < 3)
        True
        """
        if self.forces:
            return frozen_real(np.full(len(self.modes), np.nan))
        signal = as_signal(held(self, "response"))
        pair = self.modes.poles.imag > 0
        poles = poles_of(self, signal.step)
        place = np.cumsum(pair) - 1
        return frozen_real(
            [
                disagreement(signal.values, poles, int(place[mode]), self.noise_std) if pair[mode] else np.nan
                for mode in range(len(self.modes))
            ]
        )

    @cached_property
    def verdict(self) -> Verdict:
        """How far the modes can be trusted, with every check and its numbers.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, identify
        >>> t = np.arange(400) / 100
        >>> noise = 1e-3 * np.random.default_rng(1).standard_normal(t.size)
        >>> found = identify(as_record(np.exp(-t) * np.cos(20 * t) + noise, timepts=t, channels=["seat"]))
        >>> found.verdict.level.label
        'sound'
        """
        return verdict_of(self)

    def _table(self) -> Mapping[str, Sequence[object]]:
        return self.modes._table()

    def _brief(self) -> str:
        signal = as_signal(held(self, "response"))
        return f"{self.modes._brief()}; {samples_in_words(signal.timepts, signal.channels)}"

    def __str__(self) -> str:
        return f"{tables_of(self)}\n\n{self.verdict}"

    def details(self) -> str:
        """Return the tables with all amplitudes, channels and rejected poles, and the verdict.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import identify
        >>> t = np.arange(0, 3, 0.01)
        >>> print(identify((t, np.exp(-t) * np.cos(20 * t))).details().splitlines()[-1])
        Verdict: 1 mode found: sound. Every check that could be made was passed.
        """
        return f"{tables_of(self, whole=True)}\n\n{self.verdict}"


def as_displacements(modes: ModalSet) -> ComplexArray:
    """Return shapes whose velocities and accelerations are divided by the pole and its square, where names say so."""
    shapes = np.asarray(modes.shapes, complex)
    orders = derivative_orders(modes.channels)
    # One quantity and channels that say nothing are taken to be alike.
    if len(set(orders) - {None}) < 2 or not np.all(modes.poles):
        return shapes
    return np.asarray(shapes / modes.poles ** np.array([order or 0 for order in orders])[:, None])
