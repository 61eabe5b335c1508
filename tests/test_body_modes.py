"""Frequencies of a body alone: bodies on random roads, made line by line from their transfer."""

from __future__ import annotations

import numpy as np
import pytest

from suspid import InputError, RecordError, body_modes, quarter_car
from suspid.greybox.body_spectra import PERIODOGRAM, Shape, fitted, log_spectrum, periodograms
from suspid.records import as_response
from suspid.units import RealArray
from suspid.words.drives import BodyCheck

STEP = 0.02


def ride(
    seed: int, *, hertz: float = 1.4, zeta: float = 0.3, exponent: float = 2.0, seconds: float = 900.0, order: int = 2
) -> RealArray:
    """Return the body of one mass on a strut, over a road of slope ``-exponent``: the stated derivative."""
    rng = np.random.default_rng(seed)
    count = round(seconds / STEP)
    f = np.fft.rfftfreq(count, STEP)[1:]
    r = f / hertz
    transfer = (1 + 2j * zeta * r) / (1 - r**2 + 2j * zeta * r)
    size = f ** (-exponent / 2) * (2 * np.pi * f) ** order * (f > 0.1) * (f < 20)
    lines = size * transfer * (rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size))
    made = np.fft.irfft(np.concatenate([[0.0], lines]), count)
    return np.asarray(made / np.std(made))


def noise(seed: int) -> RealArray:
    """Return noise with a smooth spectrum, such as a body that is not suspended."""
    rng = np.random.default_rng(seed)
    f = np.fft.rfftfreq(45000, STEP)[1:]
    lines = f ** (0.4 - 0.3 * np.log(f)) * (rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size))
    return np.asarray(np.fft.irfft(np.concatenate([[0.0], lines]), 45000))


def record(values: RealArray, name: str = "body") -> object:
    return as_response(np.asarray(STEP * np.arange(values.size), float), values[None], [name])


@pytest.mark.parametrize("exponent", [1.6, *(pytest.param(more, marks=pytest.mark.slow) for more in (2.0, 2.5))])
@pytest.mark.parametrize("zeta", [0.2, 0.4])
def test_the_interval_holds_the_natural_frequency(exponent: float, zeta: float) -> None:
    held = []
    for seed in range(4):
        (mode,) = body_modes([record(ride(seed, zeta=zeta, exponent=exponent))])
        low, high = mode.interval(0.95)
        held.append(low < 1.4 < high)
        assert 0.01 < (high - low) / 1.4 < 0.5
    # With a probability of 95 %, two of four are left out once in 80 times.
    assert sum(held) >= 3


def test_a_model_fits_its_own_spectrum() -> None:
    shape = Shape(bent=True, numerator=True, band=(0.5, 6.0))
    f = np.arange(1, 90) / PERIODOGRAM
    true = np.array([1.7, 0.2, np.log(1.3), 0.25, 0.7])
    found = fitted(shape, f, 3.0 * np.exp(log_spectrum(true, f)))
    assert found.parameters == pytest.approx(true, abs=1e-3)


def test_without_a_resonance_there_is_no_mode() -> None:
    for seed in range(3):
        found = body_modes([record(noise(seed))])
        assert not found[0].models
        assert found[0].why is not None
        assert found[0].why.code in (BodyCheck.NO_RESONANCE, BodyCheck.NOT_DETERMINED)
        assert found.verdict.level.label == "none"


def test_neither_scale_nor_kind_of_sensor_matters() -> None:
    car = quarter_car(
        chassis_mass=400, tire_mass=40, chassis_stiffness=20e3, tire_stiffness=200e3, chassis_damping=1500
    )
    a = body_modes([record(ride(7), "chassis_acceleration")], car=car)[0]
    b = body_modes([record(100 * ride(7), "chassis_acceleration")], car=car)[0]
    v = body_modes([record(ride(7, order=1), "chassis_velocity")], car=car)[0]
    assert a.hertz == pytest.approx(b.hertz, rel=1e-6)
    assert a.hertz == pytest.approx(v.hertz, rel=0.02)


def test_levels_of_stretches_do_not_matter() -> None:
    """Twice the road on half of the drive, in stretches."""
    whole = ride(8)
    halves = [record(whole[:22500]), record(2 * whole[22500:])]
    same = [record(whole[:22500]), record(whole[22500:])]
    assert body_modes(halves)[0].hertz == pytest.approx(body_modes(same)[0].hertz, rel=1e-6)


def test_damping_is_nowhere_in_the_text() -> None:
    text = str(body_modes([record(ride(9))]))
    assert "not reported" in text


def test_what_is_too_little_is_refused() -> None:
    with pytest.raises(RecordError, match="record a longer drive"):
        body_modes([record(ride(1, seconds=60.0))])
    with pytest.raises(InputError, match="no stretch"):
        body_modes([])
    with pytest.raises(InputError, match="'wheel'"):
        body_modes([record(ride(1))], channels=["wheel"])


def test_a_periodogram_of_white_noise_is_flat() -> None:
    values = np.random.default_rng(3).standard_normal(500_000)
    made = periodograms([(values, STEP)], order=2, band=(0.5, 6.0))
    assert made.mean == pytest.approx(np.ones(made.hertz.size), abs=0.2)


@pytest.mark.parametrize("rate", [10.0, 8.0])
def test_a_slow_record_is_used_up_to_what_its_rate_passes(rate: float) -> None:
    """The bands end at 0.4 times the rate: the mode below is found, and the same record kept slower is refused."""
    whole = ride(11)
    f = np.fft.rfftfreq(whole.size, STEP)
    count = round(whole.size * STEP * rate)
    lines = np.fft.rfft(whole)[: count // 2 + 1] * (f[: count // 2 + 1] < 0.4 * rate)
    slow = np.fft.irfft(lines, count)
    (mode,) = body_modes([as_response(np.arange(count) / rate, slow[None], ["body"])])
    low, high = mode.interval(0.99)
    assert low < 1.4 < high
    with pytest.raises(RecordError, match=r"7 Hz is too slow .* record with 7.5 Hz at least"):
        body_modes([as_response(np.arange(count) / 7, slow[None], ["body"])])
