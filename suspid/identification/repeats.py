"""The result of `identify_repeats`: the modes that several decays share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from suspid.identification.identification import Identification
from suspid.identification.joint_fit import Agreement
from suspid.identification.nonlinear import AmplitudeDependence
from suspid.identification.repeats_verdict import verdict_of_repeats
from suspid.identification.tables import tables_of_repeats
from suspid.model import ModalSet
from suspid.results import Result
from suspid.units import RealArray, Second
from suspid.words import Verdict


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Repeats(Result):
    """Result of `identify_repeats`.

    Parameters
    ----------
    spans : tuple of (float, float)
        First and last time of each decay [s].
    each : tuple of Identification
        Each decay by itself.
    modes : ModalSet
        The modes of all decays jointly, with the joint covariance of poles and shapes.
    consistency : tuple of Agreement
        For each mode, whether the repeats agree on it.
    loudness : ndarray (mode,)
        Power of the residual near each mode over that of the noise, see `Identification.loudness`.
    noise_std : ndarray (repeat, channel)
        Standard deviation of the noise in each repeat and channel, in the unit of the channel.
    amplitude_dependence : tuple of AmplitudeDependence or None
        Of decays that are not linear, how each mode depends on its amplitude, in the windows of all decays; it holds at
        the middle of the amplitudes that all of them met. None where they met none in common. Empty if they are linear.
    names : tuple of str
        What the records are called; empty for decays of one recording.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import as_record, identify_repeats
    >>> t = np.arange(600) / 100
    >>> values = np.exp(-2 * (t % 3)) * np.cos(20 * (t % 3)) + 1e-3 * np.random.default_rng(1).standard_normal(t.size)
    >>> found = identify_repeats(as_record(values, timepts=t), [(0, 2.99), (3, 5.99)])
    >>> found.modes.zeta.round(2), len(found.each), found.spans
    (array([0.1]), 2, ((0.0, 2.99), (3.0, 5.99)))
    """

    spans: tuple[tuple[Second, Second], ...]
    each: tuple[Identification, ...]
    modes: ModalSet
    consistency: tuple[Agreement, ...]
    loudness: RealArray
    noise_std: RealArray
    amplitude_dependence: tuple[AmplitudeDependence | None, ...] = ()
    names: tuple[str, ...] = ()

    @cached_property
    def verdict(self) -> Verdict:
        """How far the joint modes can be trusted, with every check and its numbers.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, identify_repeats
        >>> t = np.arange(600) / 100
        >>> noise = 1e-3 * np.random.default_rng(1).standard_normal(t.size)
        >>> record = as_record(np.exp(-2 * (t % 3)) * np.cos(20 * (t % 3)) + noise, timepts=t)
        >>> identify_repeats(record, [(0, 2.99), (3, 5.99)]).verdict.level.label
        'sound'
        """
        return verdict_of_repeats(self)

    def _table(self) -> Mapping[str, Sequence[object]]:
        return self.modes._table()

    def _brief(self) -> str:
        return f"{self.modes._brief()}; {len(self.each)} decays"

    def __str__(self) -> str:
        return f"{tables_of_repeats(self)}\n\n{self.verdict}"
