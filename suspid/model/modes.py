"""Modes: natural frequencies, damping ratios, poles and shapes, exact or estimated."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from suspid.arguments import explained
from suspid.errors import InputError
from suspid.levels import LEVEL, check_level, normal_reach
from suspid.model.covariance import covariance_order, jacobian_of
from suspid.model.interval import Interval
from suspid.model.modal_checks import checked_covariance, checked_poles, checked_shapes
from suspid.model.modal_table import modal_table
from suspid.results import Result
from suspid.units import ComplexArray, RadianPerSecond, Ratio, RealArray
from suspid.values import LARGEST_SIZE, MOST_NUMBERS, SMALLEST_SIZE, frozen_complex, frozen_real


@dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)
class ModalSet(Result):
    """Modes in order of ascending natural frequency, exact or estimated.

    One entry stands for a conjugate pair (the pole in the upper half plane), for one real
    (overdamped) pole, or for one pole at zero (rigid-body motion); `kinds` says which.

    Parameters
    ----------
    poles : ndarray (mode,)
        Complex poles [rad/s]: ``-zeta wn + j wn sqrt(1 - zeta^2)``.
    shapes : ndarray (channel, mode), optional
        Complex mode shapes; any scale.
    channels : sequence of str, optional
        Names of the channels of the shapes.
    covariance : ndarray, optional
        Joint covariance of the real vector (Re, Im of each pole; then, mode by mode and channel by
        channel, Re, Im of the shapes), or of its leading part, the poles alone. None for exact modes.

    Raises
    ------
    InputError
        If sizes disagree, a value is not finite, a pole lies below the real axis, or a variance is negative.

    Examples
    --------
    >>> modes = ModalSet.from_wn_zeta([10.0, 70.0], [0.3, 0.2], wn_std=[0.1, 0.5], zeta_std=[0.01, 0.01])
    >>> print(modes)
      mode    f [Hz]    wn [rad/s]     ±    zeta [1]      ±
    ------  --------  ------------  ----  ----------  -----
         1     1.592         10.00  0.10       0.300  0.010
         2    11.141         70.00  0.50       0.200  0.010
    """

    poles: ComplexArray
    shapes: ComplexArray | None = None
    channels: Sequence[str] = ()
    covariance: RealArray | None = None

    def __post_init__(self) -> None:
        poles, channels = checked_poles(self.poles), tuple(self.channels)
        order = np.argsort(np.abs(poles), kind="stable")
        object.__setattr__(self, "poles", frozen_complex(poles[order]))
        object.__setattr__(self, "channels", channels)
        if self.shapes is not None:
            shapes = checked_shapes(self.shapes, channels, len(poles))
            if not channels:
                object.__setattr__(self, "channels", tuple(f"channel {i + 1}" for i in range(len(shapes))))
            object.__setattr__(self, "shapes", frozen_complex(shapes[:, order]))
        if self.covariance is not None:
            covariance = checked_covariance(self.covariance, len(poles), len(self.channels))
            index = covariance_order(order, len(covariance), len(poles))
            object.__setattr__(self, "covariance", frozen_real(covariance[np.ix_(index, index)]))

    @classmethod
    @explained
    def from_wn_zeta(
        cls,
        wn: Sequence[RadianPerSecond] | RealArray,
        zeta: Sequence[Ratio] | RealArray,
        *,
        wn_std: Sequence[RadianPerSecond] | RealArray | None = None,
        zeta_std: Sequence[Ratio] | RealArray | None = None,
        shapes: ComplexArray | RealArray | None = None,
        channels: Sequence[str] = (),
    ) -> ModalSet:
        """Return modes that were published, or measured elsewhere.

        Parameters
        ----------
        wn : array_like (mode,)
            Natural frequencies [rad/s], positive.
        zeta : array_like (mode,)
            Damping ratios [1], below 1 (not percent; for overdamped motion give `poles`).
        wn_std, zeta_std : array_like (mode,), optional
            Standard deviations, both or neither.
        shapes : array_like (channel, mode), optional
            Mode shapes.
        channels : sequence of str, optional
            Names of the channels.

        Examples
        --------
        >>> ModalSet.from_wn_zeta([10.0], [0.6]).poles
        array([-6.+8.j])
        """
        wn, zeta = np.atleast_1d(np.asarray(wn, float)), np.atleast_1d(np.asarray(zeta, float))
        if wn.shape != zeta.shape or wn.ndim != 1:
            raise InputError(f"wn and zeta must be vectors of one length; got {wn.shape} and {zeta.shape}")
        if not np.all((wn >= SMALLEST_SIZE) & (wn <= LARGEST_SIZE)):
            raise InputError(
                f"wn = {wn} rad/s: natural frequencies must be positive, from {SMALLEST_SIZE:g} to {LARGEST_SIZE:g}"
            )
        if not np.all(np.abs(zeta) < 1):
            raise InputError(f"zeta = {zeta}: damping ratios are ratios below 1, not percent")
        covariance = None
        if (wn_std is None) != (zeta_std is None):
            raise InputError("give both wn_std and zeta_std, or neither")
        poles = wn * (-zeta + 1j * np.sqrt(1 - zeta**2))
        if wn_std is not None and zeta_std is not None:
            spread = np.stack([np.asarray(wn_std, float), np.asarray(zeta_std, float)])
            if spread.shape != (2, len(wn)) or not np.all(np.isfinite(spread) & (spread >= 0)):
                raise InputError(f"wn_std and zeta_std must be {len(wn)} finite numbers >= 0 each; got {spread}")
            covariance = np.zeros((2 * len(wn), 2 * len(wn)))
            for i, pole in enumerate(poles):
                to_wn_zeta = np.linalg.inv(jacobian_of(pole))
                block = slice(2 * i, 2 * i + 2)
                covariance[block, block] = to_wn_zeta @ np.diag(spread[:, i] ** 2) @ to_wn_zeta.T
        return cls(
            poles=poles,
            shapes=None if shapes is None else frozen_complex(shapes),
            channels=channels,
            covariance=covariance,
        )

    def __len__(self) -> int:
        return len(self.poles)

    def __getitem__(self, index: int | slice | Sequence[int] | NDArray[np.bool_]) -> ModalSet:
        """Return some of the modes, with their shapes and their joint covariance.

        Examples
        --------
        >>> modes = ModalSet.from_wn_zeta([10.0, 70.0], [0.3, 0.2])
        >>> modes[1].wn, [mode.zeta.item() for mode in modes]
        (array([70.]), [0.3, 0.2])
        """
        if isinstance(index, int | np.integer) and not -len(self) <= index < len(self):
            raise IndexError(f"there is no mode {index}: there are {len(self)}, numbered from 0")
        given: object = index
        if isinstance(given, str):
            raise InputError(
                f"modes are chosen by number, from 0 on; {given!r} may be an attribute, such as .wn or .zeta"
            )
        kept, covariance = np.atleast_1d(np.arange(len(self))[index]), self.covariance
        if covariance is not None:
            entries = covariance_order(kept, len(covariance), len(self))
            covariance = covariance[np.ix_(entries, entries)]
        return ModalSet(
            poles=self.poles[kept],
            shapes=None if self.shapes is None else self.shapes[:, kept],
            channels=self.channels,
            covariance=covariance,
        )

    def __iter__(self) -> Iterator[ModalSet]:
        """Iterate over the modes, each a set of one."""
        return (self[k] for k in range(len(self)))

    @property
    def wn(self) -> RealArray:
        """Natural frequencies ``|pole|`` [rad/s], (mode,), ascending.

        Examples
        --------
        >>> from suspid import ModalSet
        >>> ModalSet(poles=[-3 + 4j, -1 + 10j]).wn.round(3)
        array([ 5.  , 10.05])
        """
        return np.abs(self.poles)

    @property
    def zeta(self) -> RealArray:
        """Damping ratios ``-Re(pole) / |pole|`` [1], (mode,); 1 for a stable real pole, 0 for a rigid-body pole.

        Examples
        --------
        >>> from suspid import ModalSet
        >>> ModalSet(poles=[-3 + 4j]).zeta
        array([0.6])
        """
        return -self.poles.real / np.where(self.wn > 0, self.wn, 1.0) + 0.0

    @property
    def kinds(self) -> tuple[str, ...]:
        """``"pair"``, ``"real"`` (overdamped) or ``"rigid"`` (a pole at zero), by mode.

        Examples
        --------
        >>> from suspid import ModalSet
        >>> ModalSet(poles=[0.0, -2.0, -3 + 4j]).kinds
        ('rigid', 'real', 'pair')
        """
        return tuple("rigid" if p == 0 else "pair" if p.imag else "real" for p in self.poles)

    @property
    def wn_zeta_covariance(self) -> RealArray | None:
        """Joint covariance of (wn, zeta of mode 1, wn, zeta of mode 2, …), (2 mode, 2 mode); None for exact modes.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import ModalSet
        >>> modes = ModalSet.from_wn_zeta([10.0, 70.0], [0.3, 0.2], wn_std=[0.1, 0.5], zeta_std=[0.01, 0.02])
        >>> np.sqrt(np.diag(modes.wn_zeta_covariance)).round(3)
        array([0.1 , 0.01, 0.5 , 0.02])
        """
        if self.covariance is None:
            return None
        n = 2 * len(self)
        jacobian = np.zeros((n, n))
        for i, pole in enumerate(self.poles):
            jacobian[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = jacobian_of(pole)
        return np.asarray(jacobian @ self.covariance[:n, :n] @ jacobian.T)

    @property
    def wn_std(self) -> RealArray | None:
        """Standard deviations of `wn` [rad/s], (mode,); None for exact modes.

        Examples
        --------
        >>> from suspid import ModalSet
        >>> ModalSet.from_wn_zeta([10.0], [0.3], wn_std=[0.1], zeta_std=[0.01]).wn_std.round(6)
        array([0.1])
        """
        covariance = self.wn_zeta_covariance
        return None if covariance is None else np.sqrt(np.diag(covariance)[0::2])

    @property
    def zeta_std(self) -> RealArray | None:
        """Standard deviations of `zeta` [1], (mode,); None for exact modes.

        Examples
        --------
        >>> from suspid import ModalSet
        >>> ModalSet.from_wn_zeta([10.0], [0.3], wn_std=[0.1], zeta_std=[0.01]).zeta_std.round(6)
        array([0.01])
        """
        covariance = self.wn_zeta_covariance
        return None if covariance is None else np.sqrt(np.diag(covariance)[1::2])

    def interval(self, level: Ratio = LEVEL) -> Interval:
        """Return the bounds between which wn and zeta lie with probability ``level``.

        Raises
        ------
        InputError
            If the modes are exact, or the level is not between 0 and 1.

        Examples
        --------
        >>> modes = ModalSet.from_wn_zeta([10.0], [0.3], wn_std=[0.1], zeta_std=[0.01])
        >>> modes.interval(0.95).wn.round(3)
        array([[ 9.804, 10.196]])
        """
        check_level(level)
        if self.wn_std is None or self.zeta_std is None:
            raise InputError("these modes carry no uncertainty: exact, or published without it")
        reach = normal_reach(level) * np.array([-1.0, 1.0])
        return Interval(
            level=level,
            wn=frozen_real(self.wn[:, None] + reach * self.wn_std[:, None]),
            zeta=frozen_real(self.zeta[:, None] + reach * self.zeta_std[:, None]),
        )

    def _table(self) -> Mapping[str, Sequence[object]]:
        columns: dict[str, Sequence[object]] = {
            "f_hz": (self.wn / (2 * np.pi)).tolist(),
            "wn_rad_per_s": self.wn.tolist(),
            "zeta": self.zeta.tolist(),
            "kind": self.kinds,
        }
        covariance = self.wn_zeta_covariance
        if covariance is not None:
            std = np.sqrt(np.diag(covariance))
            columns |= {"wn_std_rad_per_s": std[0::2].tolist(), "zeta_std": std[1::2].tolist()}
        return columns

    def _brief(self) -> str:
        if not len(self):
            return "no mode"
        wn, zeta = (", ".join(f"{v:.4g}" for v in row[:MOST_NUMBERS]) for row in (self.wn, self.zeta))
        more = ", …" if len(self) > MOST_NUMBERS else ""
        return f"{len(self)} mode{'s' * (len(self) > 1)}, wn = {wn}{more} rad/s, zeta = {zeta}{more}"

    def __str__(self) -> str:
        return modal_table(self)
