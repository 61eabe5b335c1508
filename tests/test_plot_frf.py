"""Frequency responses of a record beside those of the fit."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from suspid import (
    Estimate,
    InputError,
    add_noise,
    as_record,
    eigenmodes,
    estimate,
    free_decay,
    identify,
    plot_estimate,
    plot_frf,
    plot_spectra,
    quarter_car,
    read_estimate,
    report,
    road_profile,
    simulate,
    statespace,
)
from suspid.reporting import estimate_to_dict
from suspid.reporting.frf import responses

CAR = quarter_car(
    chassis_mass=400, tire_mass=40, chassis_stiffness=20e3, tire_stiffness=200e3, chassis_damping=1500, tire_damping=50
)
OUTPUTS = ["tire_acceleration", "chassis_acceleration"]


def driven(given: str, *, noise_db: float, seconds: float) -> Estimate:
    rng, time = np.random.default_rng(3), np.arange(0, seconds, 0.005)
    heights = road_profile(20 * time, roughness="C", rng=rng)
    record = simulate(CAR, time, {"road": heights}, outputs=OUTPUTS, interpolation="cubic")
    return estimate(add_noise(record, snr_db=noise_db, rng=rng), CAR, given=[given], fixed=["tire.damping"])


@pytest.fixture(scope="module")
def rig() -> Estimate:
    return driven("road", noise_db=60.0, seconds=30)


@pytest.fixture(scope="module")
def drive() -> Estimate:
    return driven("wheels", noise_db=15.0, seconds=120)


class TestView:
    """Spectra end where there is nothing but noise."""

    def test_a_decay_is_shown_up_to_its_modes_and_an_estimate_too(self) -> None:
        car = quarter_car(
            chassis_mass=400, tire_mass=40, chassis_stiffness=20e3, tire_stiffness=200e3, chassis_damping=300
        )
        decay = free_decay(car, np.arange(0, 4, 0.0005), initial_state={"v_tire": 1.0})
        record = add_noise(decay, snr_db=30.0, rng=np.random.default_rng(1))
        highest = float(eigenmodes(car).wn[-1]) / (2 * np.pi)
        for found in (identify(record), estimate(record, car, fixed=["tire.damping"])):
            axes = Figure().subplots(2)
            plot_spectra(found, axes=axes)
            for ax in axes:
                low, high = ax.get_xlim()
                assert 0 < low <= 2.0
                # Half the sampling rate is 1000 Hz.
                assert 2 * highest < high < 4 * highest

    def test_a_line_above_the_modes_stays_in_view(self) -> None:
        t = np.arange(0, 10, 0.002)
        noise = 1e-3 * np.random.default_rng(2).standard_normal(t.size)
        record = as_record(np.exp(-t) * np.cos(20 * t) + 0.01 * np.cos(700 * t + 5 * np.sin(t)) + noise, timepts=t)
        found = identify(record, modes=1)
        ax = Figure().subplots()
        plot_spectra(found, axes=[ax])
        assert 110 < ax.get_xlim()[1] < 150

    def test_a_drive_is_shown_in_the_band_that_was_fitted(self, drive: Estimate) -> None:
        """Beyond it the residual holds nothing, and the fit would be the record."""
        axes = Figure().subplots(2)
        plot_spectra(drive, axes=axes)
        assert drive.band_hz is not None
        for ax in axes:
            low, high = ax.get_xlim()
            assert drive.band_hz[0] <= low < high <= drive.band_hz[1] * (1 + 1e-9)
            labels = [tick.get_text() for tick in ax.get_xticklabels()]
            assert {"1", "10"} <= set(labels)
            assert not any("$" in label for label in labels)

    def test_gains_have_their_units(self, rig: Estimate, drive: Estimate) -> None:
        for found, unit in ((rig, "(m/s²)/m"), (drive, "1")):
            axes = Figure().subplots(2, len(responses(found)), squeeze=False)
            plot_frf(found, axes=axes)
            assert {ax.get_ylabel() for ax in axes[0]} == {f"gain [{unit}]"}


class TestTransferFunction:
    def test_record_and_fit_follow_the_transfer_function_from_the_road(self, rig: Estimate) -> None:
        system = statespace(CAR, outputs=OUTPUTS)
        for name, frf in responses(rig).items():
            kept = (frf.hertz > 3) & (frf.hertz < 15)
            s = 2j * np.pi * frf.hertz[kept]
            # The inputs are the road and its rate.
            exact = np.array([system(one)[OUTPUTS.index(name)] @ [1, one] for one in s])
            for got in (frf.record[kept], frf.fit[kept]):
                # The window blurs 0.4 Hz.
                np.testing.assert_allclose(got, exact, rtol=0.05)

    def test_noise_of_the_wheel_does_not_lower_the_gain_of_the_record(self, drive: Estimate) -> None:
        frf = responses(drive)["chassis_acceleration"]
        near = (frf.hertz > 0.8) & (frf.hertz < 5)
        s = 2j * np.pi * frf.hertz[near]
        exact = (20e3 + 1500 * s) / (400 * s**2 + 1500 * s + 20e3)
        weight = frf.std[near] ** -2
        off = np.average(np.log(np.abs(frf.record[near] / exact)), weights=weight)
        # The noise alone would lower it by 0.1.
        assert off == pytest.approx(0.0, abs=0.03)

    def test_the_error_of_the_gain_is_the_one_that_is_stated(self, drive: Estimate) -> None:
        """Its squares over the stated variance have mean 1, also where most of the wheel's spectrum is noise.

        That is below 5 Hz, where 62 values know the mean to 0.25; all know it to 0.1. The variance of ln H is
        (1 - c) / 2nc + (q / (p - q))^2 / n, with coherence c, spectrum p of the cause, noise q in it, n averages.
        """
        frf = responses(drive)["chassis_acceleration"]
        s = 2j * np.pi * frf.hertz
        exact = (20e3 + 1500 * s) / (400 * s**2 + 1500 * s + 20e3)
        squares = (np.log(np.abs(frf.record / exact)) / frf.std) ** 2
        assert np.mean(squares[(frf.hertz > 0.8) & (frf.hertz < 5)]) == pytest.approx(1.0, abs=0.5)
        assert np.mean(squares[(frf.hertz > 0.8) & (frf.hertz < 30)]) == pytest.approx(1.0, abs=0.2)

    def test_the_band_is_as_wide_upwards_as_downwards(self, drive: Estimate) -> None:
        """On a logarithmic axis: the product of its ends is the square of the gain."""
        axes = Figure().subplots(2, 1, squeeze=False)
        plot_frf(drive, axes=axes)
        frf = responses(drive)["chassis_acceleration"]
        corners = np.asarray(axes[0, 0].collections[0].get_paths()[0].vertices)
        for hertz, gain in zip(frf.hertz[::20], np.abs(frf.record[::20]), strict=True):
            ends = corners[corners[:, 0] == hertz, 1]
            assert ends.min() * ends.max() == pytest.approx(gain**2, rel=1e-9)

    def test_where_all_frequencies_were_used_it_ends_above_the_modes(self, rig: Estimate) -> None:
        highest = float(rig.modes.wn[-1]) / (2 * np.pi)
        hertz = responses(rig)["chassis_acceleration"].hertz
        # Half the sampling rate is 100 Hz.
        assert 2 * highest < hertz[-1] < 3 * highest < 100

    def test_it_stays_in_the_band_that_was_used(self, drive: Estimate) -> None:
        assert drive.band_hz is not None
        hertz = responses(drive)["chassis_acceleration"].hertz
        assert drive.band_hz[0] <= hertz[0] < hertz[-1] <= drive.band_hz[1]


class TestCauses:
    def test_they_are_roads_or_the_channels_of_the_wheels(self, rig: Estimate, drive: Estimate) -> None:
        assert rig.causes == (("road",),)
        assert drive.causes == (("tire_acceleration",),)
        assert rig.fitted[0].input_labels == ["road"]

    def test_a_free_decay_has_none(self) -> None:
        decay = free_decay(CAR, np.arange(0, 2, 0.005), initial_state={"v_tire": 1.0})
        with pytest.raises(InputError, match=r"record 0 is a free decay.*plot_spectra"):
            plot_frf(estimate(decay, CAR), axes=Figure().subplots(2, 2))

    def test_what_is_not_there_is_named(self, rig: Estimate) -> None:
        axes = Figure().subplots(2, 2)
        with pytest.raises(InputError, match="there is no channel 'raod'"):
            plot_frf(rig, axes=axes, cause="raod")
        with pytest.raises(InputError, match="contains 1 record;"):
            plot_frf(rig, axes=axes, record=3)

    def test_an_estimate_that_was_read_has_no_record_to_draw(self, rig: Estimate, tmp_path: Path) -> None:
        path = tmp_path / "found.json"
        path.write_text(json.dumps(estimate_to_dict(rig)), encoding="utf-8")
        with pytest.raises(InputError, match="read from JSON contains none"):
            plot_frf(read_estimate(path), axes=Figure().subplots(2, 2))
        with pytest.raises(InputError, match="read from JSON contains none"):
            plot_spectra(read_estimate(path), axes=Figure().subplots(2))
        assert len(plot_estimate(read_estimate(path), Figure()).axes) == 1


def test_the_page_draws_gain_and_phase_of_every_channel_that_is_moved(drive: Estimate) -> None:
    assert report(drive).count("Phase of the frequency response") == 1


@pytest.mark.slow
def test_the_page_says_what_numbers_are(rig: Estimate, drive: Estimate) -> None:
    """Every noise has the unit of its channel; gain and delay of sensors are explained where there are any."""
    for found in (rig, drive):
        page = report(found)
        for name in OUTPUTS:
            row = page.split(f"<div>{name}</div></td>")[-1].split("</tr>")[0]
            assert "m/s²" in row
        assert ("delay: of a sensor" in page) == any(name.endswith(".delay") for name in found.parameters)
