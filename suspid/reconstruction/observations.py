"""Modes of one or several tests of one suspension: checks, and conversion to equations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from suspid.errors import InputError
from suspid.model import ModalSet, Suspension, added_masses, check_plain, output_weights
from suspid.reconstruction.equations import Observed, all_poles, spectral_nodes
from suspid.units import ComplexArray, Kilogram, RealArray
from suspid.values import nearest_names
from suspid.wording import Argument
from suspid.words import ReconstructionNote, Remark

FEW_DIGITS = 8  # significant digits of printed numbers, at most; computed ones have 15 to 17


@dataclass(frozen=True, kw_only=True, slots=True)
class ModalTest:
    """The modes of a suspension in one test, perhaps with known masses added.

    Parameters
    ----------
    modes : ModalSet
        The modes in that test.
    added_masses : mapping of str to float
        Mass [kg] (or moment of inertia [kg m2]) added at each coordinate, such as a driver or a bag of sand.

    Raises
    ------
    InputError
        If the modes are no `ModalSet`, or an added mass is not a finite number >= 0.

    Examples
    --------
    >>> from suspid import eigenmodes, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> loaded = car.with_parameters(masses={"chassis": 475})
    >>> ModalTest(modes=eigenmodes(loaded), added_masses={"chassis": 75.0}).added_masses
    {'chassis': 75.0}
    """

    modes: ModalSet
    added_masses: Mapping[str, Kilogram] = field(default_factory=dict)

    def __post_init__(self) -> None:
        modes: object = self.modes
        if not isinstance(modes, ModalSet):
            hint = "; take its .modes" if hasattr(modes, "modes") else ""
            raise InputError(f"a ModalTest needs a ModalSet, not {type(modes).__name__}{hint}")
        object.__setattr__(self, "added_masses", added_masses(self.added_masses))


def modal_tests(modes: object, suspension: object) -> tuple[ModalTest, ...]:
    """Return the modes as tests, checked against the suspension."""
    given = [modes] if isinstance(modes, ModalSet | ModalTest) or not isinstance(modes, Sequence) else list(modes)
    tests = []
    for one in given:
        if not isinstance(one, ModalSet | ModalTest):
            hint = "; take its .modes" if hasattr(one, "modes") else ""
            raise InputError(
                f"reconstruct needs a ModalSet here, or a sequence of ModalTest, not {type(one).__name__}{hint}"
            )
        tests.append(one if isinstance(one, ModalTest) else ModalTest(modes=one))
    if not tests:
        raise InputError("there is no test; give a ModalSet, or a sequence of ModalTest")
    if not isinstance(suspension, Suspension):
        hint = "; take its .suspension" if hasattr(suspension, "suspension") else ""
        raise InputError(f"reconstruct needs a Suspension here, not {type(suspension).__name__}{hint}")
    check_plain(suspension, "reconstruct")
    for test in tests:
        for name in test.added_masses:
            if name not in suspension.coordinates:
                raise InputError(
                    Argument("added_masses"), f": there is no mass {name!r}.{nearest_names(name, suspension.masses)}"
                )
    weighted = [test.modes.covariance is not None for test in tests]
    if any(weighted) and not all(weighted):
        raise InputError(
            f"test {weighted.index(False) + 1} has no covariance and test {weighted.index(True) + 1} has one; "
            f"they cannot be weighted against each other: give all tests one, or none"
        )
    return tuple(tests)


def observe(test: ModalTest, suspension: Suspension) -> tuple[Observed, list[Remark]]:
    """Return the equations of one test, and remarks on them."""
    modes, n = test.modes, len(suspension.coordinates)
    total = len(all_poles(modes.poles))
    if total > 2 * n:
        raise InputError(
            f"the modes have {total} poles (a pair counts twice), but {n} masses have {2 * n}; "
            f"leave out modes that are not the suspension's, or identify no more than {n} (",
            Argument("modes", str(n)),
            ")",
        )
    moving = modes.poles != 0
    poles = modes.poles[moving]
    if not len(modes):
        raise InputError("there is no mode, and springs and dampers follow from modes")
    if not len(poles):
        raise InputError(
            f"all {len(modes)} modes have a pole at zero, which does not depend on k and c; give others too"
        )
    real = poles.imag == 0
    shapes, orders, weights, notes = _usable_shapes(modes, suspension, moving)
    poles_alone = modes.covariance is not None and (shapes is None or len(modes.covariance) == 2 * len(modes))
    nodes, target, spacing = spectral_nodes(poles, real, int(np.sum(~moving)), n)
    seen = Observed(
        poles=poles,
        rigid=int(np.sum(~moving)),
        real=real,
        shapes=shapes,
        orders=orders,
        weights=weights,
        added=np.array([test.added_masses.get(c, 0.0) for c in suspension.coordinates]),
        whiten=None if modes.covariance is None else _whitening(modes, moving, None if poles_alone else shapes, orders),
        poles_alone=poles_alone,
        nodes=nodes,
        target=target,
        spacing=spacing,
    )
    return seen, notes


def printed(modes: ModalSet) -> bool:
    """Return whether the modes were printed: all frequencies and damping ratios, or all poles, are of few digits.

    Numbers of few digits were measured or rounded; a computed number has few digits by chance once in millions.

    Examples
    --------
    >>> printed(ModalSet.from_wn_zeta([21.2686, 50.0925], [0.007905, 0.025293]))
    True
    >>> printed(ModalSet.from_wn_zeta([450**0.5, 2500**0.5], [0.007905, 0.025293]))
    False
    """
    moving = modes.poles != 0
    wn, zeta, poles = modes.wn[moving], modes.zeta[moving], modes.poles[moving]
    hertz = poles / (2 * np.pi)
    forms = [(wn, zeta), (wn / (2 * np.pi), zeta), (poles.imag, poles.real), (hertz.imag, hertz.real)]
    return any(_few_digits(np.concatenate(form)) for form in forms)


def _few_digits(values: RealArray) -> bool:
    """Return whether all values are decimal numbers of few digits, up to the rounding of a few operations."""
    short = np.array([float(f"{value:.{FEW_DIGITS - 1}e}") for value in values])
    return bool(np.all(np.abs(values - short) <= 1e-14 * np.abs(values)))


def unweighted(seen: Observed) -> Observed:
    """Return the equations without the covariance."""
    return replace(seen, whiten=None, poles_alone=False)


def _usable_shapes(
    modes: ModalSet, suspension: Suspension, moving: NDArray[np.bool_]
) -> tuple[ComplexArray | None, NDArray[np.intp], RealArray, list[Remark]]:
    """Return the usable shapes with orders and weights of their channels, and remarks on why they are not used."""
    nothing = None, np.zeros(0, int), np.zeros((0, len(suspension.coordinates)))
    if modes.shapes is None:
        return *nothing, []
    channels = list(modes.channels)
    selections = []
    for channel in channels:
        try:
            selections.append(output_weights(suspension, channel))
        except InputError:
            return *nothing, [Remark(ReconstructionNote.CHANNEL_UNKNOWN, {"channel": channel})]
    twice = [c for c in channels if channels.count(c) > 1]
    if twice:
        return *nothing, [Remark(ReconstructionNote.CHANNEL_TWICE, {"channel": twice[0]})]
    if len(channels) < 2:
        return *nothing, [Remark(ReconstructionNote.ONE_CHANNEL)]
    orders, weights = np.array([s[0] for s in selections]), np.array([s[1] for s in selections])
    # Velocities over the frequency, accelerations over its square: of the size of displacements.
    shapes = modes.shapes[:, moving] / modes.wn[moving] ** orders[:, None]
    for i, shape in enumerate(shapes.T):
        largest = shape[np.argmax(np.abs(shape))]
        if not np.all(np.isfinite(shape)) or largest == 0:
            raise InputError(f"mode {i + 1} has the shape {shape}, which is zero or not finite; leave the mode out")
        shapes[:, i] = shape / largest
    real = modes.poles[moving].imag == 0
    return np.where(real, shapes.real, shapes), orders, weights, []


def _whitening(
    modes: ModalSet, moving: NDArray[np.bool_], shapes: ComplexArray | None, orders: NDArray[np.intp]
) -> RealArray:
    """Return the inverse root of the covariance of what `sensitivities` returns.

    The scale of a shape is arbitrary: one component carries no information, and its variance may be zero. Ratios to
    the largest component avoid that.
    """
    assert modes.covariance is not None
    if not np.all(np.isfinite(modes.covariance)):
        raise InputError("the covariance of the modes is not finite; give modes without it, or a finite one")
    index, channels = np.flatnonzero(moving), len(modes.channels)
    # First-order map from (poles, then shapes mode by mode) to relative poles, then shapes over their reference.
    change = np.zeros((len(index) * (1 + (channels - 1) * (shapes is not None)), len(modes.covariance) // 2), complex)
    change[np.arange(len(index)), index] = 1 / np.abs(modes.poles[index])
    row = len(index)
    real = list(modes.poles[index].imag == 0)
    if shapes is not None and modes.shapes is not None:
        for i, m in enumerate(index):
            largest = int(np.argmax(np.abs(shapes[:, i])))
            at, first = modes.shapes[largest, m], len(modes) + m * channels
            for c in set(range(channels)) - {largest}:
                unit = modes.wn[m] ** float(orders[largest] - orders[c])
                change[row, [first + c, first + largest]] = unit / at, -unit * modes.shapes[c, m] / at**2
                row += 1
                real.append(real[i])
    spread = np.empty((2 * len(change), len(modes.covariance)))
    spread[: len(change), 0::2], spread[: len(change), 1::2] = change.real, -change.imag
    spread[len(change) :, 0::2], spread[len(change) :, 1::2] = change.imag, change.real
    # In the order of the residual: of the poles, then of the shapes, the real parts before the imaginary ones.
    shown = np.concatenate([np.ones(len(change), bool), ~np.array(real)])
    is_pole = np.tile(np.arange(len(change)) < len(index), 2)
    order = np.concatenate([np.flatnonzero(shown & is_pole), np.flatnonzero(shown & ~is_pole)])
    covariance = spread[order] @ modes.covariance @ spread[order].T
    # A variance of zero counts as the accuracy of an eigenvalue solver.
    std = np.sqrt(np.diag(covariance) + 1e-24)
    values, vectors = np.linalg.eigh(covariance / np.outer(std, std))
    return np.asarray((vectors / np.sqrt(np.maximum(values, 1e-10))).T / std)
