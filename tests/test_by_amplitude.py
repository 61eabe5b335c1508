"""How modes of single decays are joined, from modes and tables that are known."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray

from suspid import ModalSet
from suspid.identification import AmplitudeDependence, Described, Identification, at_common_amplitudes
from suspid.identification.by_amplitude import Joined, joined, strongest
from suspid.identification.common_amplitude import overlap, pole_at

WN = np.array([10.0, 40.0])
CHANNELS = ("seat [mm]", "tire [m/s^2]")
SHAPES = np.array([[1.0, 0.5 + 0.1j], [0.2 - 0.1j, 1.0]])


def of_power(
    power: float,
    *,
    wn: float = 10.0,
    zeta: float = 0.05,
    sizes: tuple[float, ...] = (1.0, 0.8, 0.6, 0.45),
    cycles: int = 1,
) -> AmplitudeDependence:
    """Return windows of whole cycles of a mode whose damping is ``zeta`` times a power of the amplitude, exactly.

    The amplitude falls as ``da / dt = -zeta wn a^(1 + power)``; a window has the mean over its time.
    """
    size, last = np.array(sizes), 2 * np.pi * cycles / wn
    # Half a window before and after its middle in time, and the geometric mean of both ends.
    inverse = size**-power
    rate = zeta * wn * power * last / 2
    first, end = (inverse - rate) ** (-1 / power), (inverse + rate) ** (-1 / power)
    return AmplitudeDependence(
        spans=tuple((0.0, last) for _ in sizes),
        channel=CHANNELS[0],
        amplitude=np.sqrt(first * end),
        wn=np.full(size.shape, wn),
        zeta=np.log(first / end) / (wn * last),
        wn_std=np.full(size.shape, 1e-4),
        zeta_std=np.full(size.shape, 1e-5),
        holds_at=float(size[0]),
    )


def found(
    zeta: tuple[float, ...] = (0.05, 0.04),
    *,
    shapes: NDArray[np.complex128] | None = None,
    loudness: tuple[float, ...] = (1.0, 2.0),
    std: float = 1e-3,
    tables: bool = True,
    wn: NDArray[np.float64] = WN,
) -> Identification:
    count = len(zeta)
    shapes = SHAPES[:, :count] if shapes is None else shapes
    size = 2 * count * (1 + len(shapes))
    covariance = std**2 * np.eye(size)
    # The channel in whose unit a shape is has no variance.
    for mode, top in enumerate(np.argmax(np.abs(shapes), axis=0).tolist()):
        at = 2 * count + 2 * (mode * len(shapes) + top)
        covariance[at : at + 2, at : at + 2] = 0.0
    poles = wn[:count] * (-np.array(zeta) + 1j * np.sqrt(1 - np.array(zeta) ** 2))
    modes = ModalSet(poles=poles, shapes=shapes, channels=CHANNELS, covariance=covariance)
    each = tuple(of_power(-1.0, wn=float(w), zeta=z) for w, z in zip(wn, zeta, strict=False)) if tables else ()
    return cast(
        "Identification", SimpleNamespace(modes=modes, amplitude_dependence=each, loudness=np.array(loudness[:count]))
    )


def test_everything_of_a_mode_stands_in_its_place() -> None:
    both = joined([found(), found(loudness=(3.0, 1.0))])
    np.testing.assert_allclose(both.modes.wn, WN, rtol=1e-3)
    assert both.loudness.tolist() == [3.0, 2.0]
    assert [one.held for one in both.consistency] == [(0, 1), (0, 1)]
    assert [round(float(table.wn[0])) for table in both.amplitude_dependence if table is not None] == [10, 40]


@pytest.mark.parametrize("decays", [1, 2, 3, 4, 12])
def test_shapes_of_equal_decays_are_theirs(decays: int) -> None:
    """The channel of the unit has no variance: weights of four were infinite, and it became 0."""
    both = joined([found() for _ in range(decays)])
    assert both.modes.shapes is not None
    np.testing.assert_allclose(both.modes.shapes, SHAPES, atol=1e-12)
    assert both.modes.covariance is not None
    variances = np.diag(both.modes.covariance)[4:].reshape(2, 2, 2)
    np.testing.assert_allclose(variances[[0, 1], [1, 0]], 1e-6 / decays, rtol=1e-9)
    np.testing.assert_allclose(variances[[0, 1], [0, 1]], 0.0, atol=1e-20)


def test_shapes_count_by_how_well_they_are_known() -> None:
    rough = found(shapes=np.array([[1.0, 0.8 + 0.1j], [0.6 - 0.1j, 1.0]]), std=1e-1)
    both = joined([found(std=1e-3), rough])
    assert both.modes.shapes is not None
    np.testing.assert_allclose(both.modes.shapes, SHAPES, atol=1e-3)


def test_shapes_in_units_of_other_channels_are_one() -> None:
    """One decay has a shape in units of the seat, another in those of the tire."""
    one = found(zeta=(0.05,), shapes=np.array([[1.0], [0.95]]))
    other = found(zeta=(0.05,), shapes=np.array([[0.99], [1.0]]))
    both = joined([one, other])
    assert both.modes.shapes is not None
    assert both.modes.shapes[0, 0] == 1
    assert 0.95 < both.modes.shapes[1, 0].real < 1 / 0.99
    assert both.modes.covariance is not None
    variances = np.diag(both.modes.covariance)[2:]
    np.testing.assert_allclose(variances[:2], 0.0, atol=1e-20)
    # Each has one free channel, with a variance of 1e-6: that of their ratio, to first order.
    np.testing.assert_allclose(variances[2:], 0.5e-6, rtol=0.05)


def test_a_mode_of_few_decays_is_left_to_them() -> None:
    few = found(zeta=(0.05, 0.04))
    only = [found(zeta=(0.05,)) for _ in range(2)]
    assert len(joined([few, *only]).modes) == 1
    assert len(joined([few, only[0]]).modes) == 2


def test_the_order_of_the_decays_does_not_count() -> None:
    decays = [found(zeta=(0.05, 0.04)), found(zeta=(0.051,), wn=np.array([10.02])), found(zeta=(0.049, 0.041))]
    ahead, back = joined(decays), joined(decays[::-1])
    np.testing.assert_allclose(ahead.modes.poles, back.modes.poles, rtol=1e-9)


def test_the_strongest_are_those_that_most_decays_hold() -> None:
    both = joined([found(), found(zeta=(0.05,))])
    assert [len(one.held) for one in both.consistency] == [2, 1]
    kept: Joined = strongest(both, 1)
    assert kept.modes.wn[0] == pytest.approx(10.0, rel=1e-3)
    assert len(kept.consistency) == len(kept.loudness) == len(kept.amplitude_dependence) == 1


def test_decays_that_differ_have_wider_intervals() -> None:
    same, apart = joined([found(), found()]), joined([found(), found(zeta=(0.07, 0.04))])
    assert same.consistency[0].widening == 1 < apart.consistency[0].widening
    assert same.modes.zeta_std is not None
    assert apart.modes.zeta_std is not None
    assert apart.modes.zeta_std[0] > 2 * same.modes.zeta_std[0]


def test_without_tables_it_is_the_mean_with_its_scatter() -> None:
    """One of them was linear, and known a thousand times better: the other counts as much."""
    apart = joined([found(zeta=(0.02,), std=1e-6, tables=False), found(zeta=(0.08,), std=1e-3)])
    assert apart.amplitude_dependence == (None,)
    assert apart.modes.zeta[0] == pytest.approx(0.05, rel=0.02)
    assert apart.modes.zeta_std is not None
    assert apart.modes.zeta_std[0] == pytest.approx(0.03, rel=0.05)


@pytest.mark.parametrize("power", [-1.0, 1.0])
@pytest.mark.parametrize("cycles", [1, 2])
def test_a_window_is_brought_to_its_middle(power: float, cycles: int) -> None:
    """Friction and quadratic drag, of which the mean over a window is known."""
    table = of_power(power, cycles=cycles, sizes=(1.0, 0.85, 0.7))
    pole, covariance = pole_at(table, 0.8)
    assert -pole.real / abs(pole) == pytest.approx(0.05 * 0.8**power, rel=3e-3 * cycles)
    assert covariance[0, 0] > (10 * 1e-5) ** 2
    # Forces turn a motion as they damp it.
    assert covariance[1, 1] > 0.9 * covariance[0, 0]


def test_what_lies_beyond_the_windows_is_less_known() -> None:
    """To half a window beyond its middle a table reaches, along the power of the last two."""
    table = of_power(-1.0)
    least = float(np.min(table.amplitude))
    within, beyond = pole_at(table, 1.05 * least), pole_at(table, 0.9 * least)
    assert -beyond[0].real / abs(beyond[0]) == pytest.approx(0.05 / (0.9 * least), rel=0.02)
    assert beyond[1][0, 0] > 4 * within[1][0, 0]
    alone = of_power(-1.0, sizes=(0.6,))
    assert pole_at(alone, 0.6)[1][0, 0] > 4 * pole_at(table, 0.6)[1][0, 0]


def test_ranges_reach_to_the_ends_of_the_windows() -> None:
    low, high = of_power(-1.0, sizes=(0.5, 0.4)), of_power(-1.0, sizes=(1.0, 0.6))
    gap = np.min(high.amplitude) / np.max(low.amplitude)
    middle = overlap([low, high])
    assert middle is not None
    assert gap > 1
    assert np.max(low.amplitude) < middle < np.min(high.amplitude)
    assert overlap([of_power(-1.0, zeta=0.01, sizes=(0.1, 0.08)), high]) is None
    assert overlap([None, high]) is None


def test_windows_of_many_decays_are_no_slopes() -> None:
    """Of two windows a thousandth apart, the difference is noise."""
    one = of_power(-1.0)
    sizes = np.concatenate([one.amplitude, one.amplitude * 1.001])
    noise = 1e-3 * np.array([1, -1, 1, -1, -1, 1, -1, 1])
    pooled: Any = AmplitudeDependence(
        spans=one.spans * 2,
        channel=one.channel,
        amplitude=sizes,
        wn=np.tile(one.wn, 2) + 10 * noise,
        zeta=np.tile(one.zeta, 2) + noise,
        wn_std=np.tile(one.wn_std, 2),
        zeta_std=np.full(8, 1e-3),
        holds_at=0.7,
    )
    covariance = pole_at(pooled, 0.7)[1]
    assert covariance[0, 0] < 4 * (10 * 1e-3) ** 2
    assert covariance[1, 1] < 4 * (10 * 1e-3) ** 2


def test_compared_poles_have_nothing_to_do_with_others() -> None:
    one, other = found(), found(zeta=(0.05, 0.04))
    assert one.modes.covariance is not None
    covariance = one.modes.covariance.copy()
    covariance[0, 2] = covariance[2, 0] = 5e-7
    modes = ModalSet(poles=one.modes.poles, shapes=SHAPES, channels=CHANNELS, covariance=covariance)
    tables = [of_power(-1.0, wn=float(w)) for w in WN]
    moved, _, remarks = at_common_amplitudes(
        Described(modes=modes, tables=tables), Described(modes=other.modes, tables=tables)
    )
    assert len(remarks) == 2
    assert moved.covariance is not None
    assert moved.covariance[0, 2] == 0
    assert np.all(np.linalg.eigvalsh(moved.covariance) > -1e-18)
