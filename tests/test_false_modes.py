"""Motion that is no free decay has no modes; decays beside it keep theirs."""

import dataclasses

import numpy as np
import pytest
from numpy.typing import ArrayLike

from suspid import Identification, analyse, identify
from suspid.identification.by_likelihood import _fewer
from suspid.identification.noise import noise_of
from suspid.identification.pulses import one_shape
from suspid.identification.selection import select
from suspid.records import as_response
from suspid.units import RealArray
from suspid.words import Level, Reason
from validation import no_decay

TIME = np.arange(1500) / 200.0
RNG = np.random.default_rng


def found(values: ArrayLike, seed: int, noise: float) -> Identification:
    record = np.atleast_2d(values)
    record = record + noise * RNG(seed).standard_normal(record.shape)
    return identify(as_response(TIME, record, [f"y{k}" for k in range(len(record))]))


def line(hertz: float, wander: float, seed: int) -> RealArray:
    """A turning part whose speed wanders by a share, with a memory of a second."""
    drawn, share = RNG(seed).standard_normal(len(TIME)), np.exp(-TIME[1])
    speed = np.zeros(len(TIME))
    for k in range(1, len(TIME)):
        speed[k] = share * speed[k - 1] + np.sqrt(1 - share**2) * drawn[k]
    phase = 2 * np.pi * hertz * np.cumsum(1 + wander * speed) * TIME[1]
    return np.array([np.cos(phase), 0.6 * np.cos(phase + 1.0)])


class TestLines:
    @pytest.mark.parametrize("seed", range(6))
    def test_a_line_that_wanders_is_no_mode(self, seed: int) -> None:
        assert not len(found(line(12.0, 0.01, seed), seed, 0.2).modes)

    @pytest.mark.parametrize("hertz", [11.0, 11.7, 12.4])
    def test_a_mode_beside_hum_is_one(self, hertz: float) -> None:
        wn = 2 * np.pi * 12.0
        decay = np.exp(-0.01 * wn * TIME) * np.cos(wn * TIME)
        hum = 0.2 * np.cos(2 * np.pi * hertz * TIME + 1.0)
        modes = found([decay + hum, 0.7 * decay - hum], 1, 0.02).modes
        np.testing.assert_allclose(modes.wn, [wn], rtol=1e-3)
        np.testing.assert_allclose(modes.zeta, [0.01], rtol=0.05)


class TestBeginnings:
    @pytest.mark.parametrize("seed", [1, 2, 3])
    def test_a_push_of_any_shape_at_the_beginning_is_no_mode(self, seed: int) -> None:
        """An oscillator under a smooth force of random shape for 1.2 s, then free; its acceleration at 20 Hz."""
        step, wn, zeta = 1 / 640, 2 * np.pi * 0.3, 0.05
        time, rng = np.arange(0, 22, step), RNG(seed)
        waves = np.sin(2 * np.pi * rng.uniform(1, 8, (8, 1)) * time + rng.uniform(0, 2 * np.pi, (8, 1)))
        force = 0.02 * np.sum(waves, axis=0) * np.clip(1 - time / 1.2, 0, None)
        ringing = np.exp(wn * (-zeta + 1j * np.sqrt(1 - zeta**2)) * time)
        # Duhamel: the speed of a mass is its force, convolved with the derivative of the impulse response.
        answer = np.real(ringing) - zeta / np.sqrt(1 - zeta**2) * np.imag(ringing)
        speed = np.convolve(force, answer)[: len(time)] * step
        motion = np.real(ringing) + np.gradient(speed, step)
        values = motion[::32] + 0.002 * rng.standard_normal(440)
        modes = identify(as_response(np.arange(440) / 20, values[None], ["mass"])).modes
        assert len(modes) == 1
        (ends,) = modes.interval(0.9999).wn
        assert ends[0] < wn < ends[1]
        np.testing.assert_allclose(modes.zeta, [zeta], rtol=0.01)

    def test_a_few_samples_of_anything_are_no_modes(self) -> None:
        """Forty samples of coloured noise are followed exactly by thirteen pairs."""
        for seed in range(4):
            values = np.convolve(RNG(seed).standard_normal(60), np.exp(-np.arange(8) / 3), "valid")[:40]
            assert len(identify(as_response(np.arange(40) / 500, values[None], ["beam"])).modes) < 3


class TestSquares:
    @pytest.mark.parametrize("zeta", [0.03, 0.125])
    def test_the_energies_of_a_mass_have_no_modes_of_their_own(self, zeta: float) -> None:
        wn = 2.0
        pole, time = wn * (-zeta + 1j * np.sqrt(1 - zeta**2)), np.arange(0, 30, 0.1)
        place, speed = np.real(np.exp(pole * time)), np.real(pole * np.exp(pole * time))
        record = np.array([place, speed, speed**2 / 2, wn**2 * place**2 / 2])
        record += 1e-4 * RNG(1).standard_normal(record.shape)
        found = identify(as_response(time, record, ["x", "v", "kinetic", "potential"]))
        np.testing.assert_allclose(found.modes.wn, [wn], rtol=1e-4)
        assert [c.remark.code for c in found.considered].count(Reason.HARMONIC) == 2


class TestUnknown:
    @pytest.mark.parametrize(("widened", "modes"), [(1.0, 2), (1e12, 0)])
    def test_a_pole_whose_frequency_may_be_zero_is_no_mode(self, widened: float, modes: int) -> None:
        record = np.exp(-TIME) * np.cos(20 * TIME) + np.exp(-2 * TIME) * np.cos(55 * TIME)
        centred = (record + 1e-3 * RNG(1).standard_normal(TIME.size))[None]
        centred -= centred.mean()
        selection = select(centred, noise=noise_of(centred))
        found = identify(as_response(TIME, centred, ["y"])).modes
        assert found.covariance is not None
        known = dataclasses.replace(found, covariance=widened * found.covariance)
        fewer = _fewer(selection, known, known)
        assert len(fewer.modes) == modes
        assert (Reason.UNKNOWN in fewer.reasons) == (not modes)


class TestPulses:
    @pytest.mark.parametrize(
        ("at", "width"), [(1.0, 0.1), (1.0, 0.3), pytest.param(3.0, 0.1, marks=pytest.mark.slow), (3.0, 0.3)]
    )
    def test_a_pulse_without_ringing_has_no_mode(self, width: float, at: float) -> None:
        pulse = np.exp(-(((TIME - at * width) / width) ** 2) / 2)
        assert not len(found([pulse, -0.4 * pulse], 3, 0.01).modes)

    @pytest.mark.parametrize("zeta", [0.2, 0.5])
    def test_a_heavily_damped_decay_has_modes(self, zeta: float) -> None:
        wn = 2 * np.pi * np.array([1.3, 11.0])
        poles = wn * (-zeta + 1j * np.sqrt(1 - zeta**2))
        decay = np.real(np.exp(np.outer(poles, TIME))).T @ np.array([1.0, 0.5])
        modes = found(decay, 4, 0.003).modes
        np.testing.assert_allclose(modes.wn, wn, rtol=0.05)

    def test_one_shape_is_that_of_a_multiple(self) -> None:
        motion = np.sin(3 * TIME)
        assert one_shape(np.array([motion, -2 * motion]), np.array([0.1, 0.1]), 4)
        assert not one_shape(np.array([motion, np.cos(3 * TIME)]), np.array([0.1, 0.1]), 4)


@pytest.mark.slow
def test_a_stop_is_looked_through_without_a_word_of_numpy() -> None:
    """Steps of a fit with forces overflow on this one; warnings are errors here."""
    time, values = no_decay.braking(np.random.default_rng(760_025))
    found = analyse(as_response(time, values, [f"y{k}" for k in range(len(values))]))
    assert not len(found.modes) or found.verdict.level <= Level.DOUBTFUL


@pytest.mark.slow
def test_pairs_that_few_samples_leave_room_for_are_no_decay() -> None:
    """Sixteen pairs and more follow a hundred samples of a syllable, and the best of many candidates begins with it."""
    assert not no_decay.outcome("speech-like modulation", 760012)[2]
