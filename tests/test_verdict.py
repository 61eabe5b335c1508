"""Verdicts: every check at the edge of its rule, on identifications whose numbers are set."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from suspid import Identification, Level, Verdict, add_noise, free_decay, identify, identify_repeats
from suspid.identification.classification import LEAST_EXPLAINED, SAMPLES_EACH
from suspid.identification.considered import Considered
from suspid.identification.lines import clear_line
from suspid.identification.mode_checks import LINE_OF_OTHER_MOTION, OPEN_WN, ROUGH_WN, ROUGH_ZETA, UNKNOWN_ZETA
from suspid.identification.verdict import STILL_THERE, _late_motion, verdict_of
from suspid.model import ModalSet
from suspid.records import as_response, late_start
from suspid.signals import Signal, as_signal
from suspid.units import RealArray
from suspid.words import Check, Code, EstimateHeadline, ModeCheck, Reason, Remark, WearCheck, WearHeadline, next_steps
from suspid.words.grip import GripCheck, GripHeadline
from suspid.words.remarks import Number
from validation import cars

STEP = 0.004


@pytest.fixture(scope="module")
def found() -> Identification:
    record = free_decay(cars.PAPER, np.arange(0, 8, STEP), initial_state={"v_tire": 1.0})
    return identify(add_noise(record, snr_db=30.0, rng=np.random.default_rng(1)), candidates=[4.0])


@pytest.fixture(scope="module")
def noise() -> Identification:
    values = np.random.default_rng(4).standard_normal((1, 800))
    return identify(as_response(np.arange(800, dtype=np.float64) * 0.01, values, ["y"]), candidates=[4.0])


def said(verdict: Verdict, code: Code) -> list[Check]:
    return [check for check in verdict.checks if check.remark.code is code]


def known_to(found: Identification, *, wn: float, zeta: float) -> Identification:
    """Return the identification with 95 % intervals of mode 1 reaching these shares of its wn and zeta."""
    modes = found.modes
    assert modes.covariance is not None
    pole, half = modes.poles[0], 1.959964
    # wn = |p|, zeta = -Re p / |p|: in the frame along and across the pole the two errors are independent.
    radial = pole / abs(pole)
    across = wn * abs(pole) / half * radial
    angle = zeta * modes.zeta[0] / np.sqrt(1 - modes.zeta[0] ** 2) * abs(pole) / half * (1j * radial)
    basis = np.array([[across.real, angle.real], [across.imag, angle.imag]])
    covariance = np.array(modes.covariance) * 1e-12
    covariance[:2, :] = covariance[:, :2] = 0.0
    covariance[:2, :2] = basis @ basis.T
    changed = ModalSet(poles=modes.poles, shapes=modes.shapes, channels=modes.channels, covariance=covariance)
    return replace(found, modes=changed)


class TestPrecision:
    @pytest.mark.parametrize("factor", [0.97, 1.03])
    def test_frequency(self, found: Identification, factor: float) -> None:
        verdict = verdict_of(known_to(found, wn=ROUGH_WN * factor, zeta=1e-6))
        assert bool(said(verdict, ModeCheck.KNOWN_ROUGHLY)) is (factor > 1)
        assert bool(said(verdict, ModeCheck.KNOWN)) is (factor < 1)

    @pytest.mark.parametrize("factor", [0.97, 1.03])
    def test_damping_roughly(self, found: Identification, factor: float) -> None:
        verdict = verdict_of(known_to(found, wn=1e-6, zeta=ROUGH_ZETA * factor))
        checks = said(verdict, ModeCheck.KNOWN_ROUGHLY)
        assert bool(checks) is (factor > 1)
        for check in checks:
            assert check.level is Level.CARE
            assert check.remark.numbers["mode"] == 1

    @pytest.mark.parametrize("factor", [0.97, 1.03])
    def test_damping_unknown(self, found: Identification, factor: float) -> None:
        verdict = verdict_of(known_to(found, wn=1e-6, zeta=UNKNOWN_ZETA * factor))
        assert bool(said(verdict, ModeCheck.DAMPING_UNKNOWN)) is (factor > 1)
        assert bool(said(verdict, ModeCheck.KNOWN_ROUGHLY)) is (factor < 1)

    @pytest.mark.parametrize("over", [-0.02, 0.02])
    def test_a_mode_of_unknown_damping_in_other_motion_is_doubtful(self, found: Identification, over: float) -> None:
        vague = known_to(found, wn=1e-6, zeta=1.1 * UNKNOWN_ZETA)
        loud = replace(vague, loudness=np.full(len(vague.modes), LINE_OF_OTHER_MOTION + over))
        (check,) = said(verdict_of(loud), ModeCheck.DAMPING_UNKNOWN)
        assert check.level is (Level.DOUBTFUL if over > 0 else Level.CARE)

    @pytest.mark.parametrize(("wn", "loud"), [(0.097, 2.1), (0.103, 1.9), (0.103, 2.1)])
    def test_a_mode_of_open_frequency_in_other_motion_is_doubtful(
        self, found: Identification, wn: float, loud: float
    ) -> None:
        rough = known_to(found, wn=wn, zeta=0.1)
        checks = said(verdict_of(replace(rough, loudness=np.full(len(rough.modes), loud))), ModeCheck.KNOWN_ROUGHLY)
        doubted = wn > OPEN_WN and loud > LINE_OF_OTHER_MOTION
        assert {check.level for check in checks} == {Level.DOUBTFUL if doubted else Level.CARE}

    @pytest.mark.parametrize(
        ("spread", "doubted"),
        [
            ([0.3, 0.3, 0.3, 1e-3, 1e-3], True),
            ([0.3, 0.3, 0.2, 1e-3, 1e-3], False),  # zeta of the third is known to a half
            ([0.3, 0.3, 0.3, 1e-3, 1e-3, 1e-3], False),  # three of six are not most
            ([0.3, 0.3], False),  # heavily damped cars have two
            ([0.2, 0.2, 0.2, 0.2, 1e-3], True),  # zeta is rough, and nothing checks them
            ([0.2, 0.2, 0.2, 1e-3, 1e-3], False),  # three of five are not two thirds
        ],
    )
    def test_three_modes_and_most_of_all_that_are_hardly_known_are_doubtful(
        self, spread: list[float], monkeypatch: pytest.MonkeyPatch, *, doubted: bool
    ) -> None:
        """``spread`` is the standard deviation of each damping ratio over its value; the halves check none."""
        monkeypatch.setattr(Identification, "halves", property(lambda found: np.full(len(found.modes), np.nan)))
        wn, zeta = [40.0 * (k + 1) for k in range(len(spread))], [0.1] * len(spread)
        time = np.asarray(STEP * np.arange(1000), float)
        found = identify(as_response(time, np.exp(-time)[None] * np.cos(40 * time), ["y"]))
        std = [0.1 * share for share in spread]
        of = ModalSet.from_wn_zeta(wn, zeta, wn_std=[1e-3] * len(spread), zeta_std=std)
        shapes = np.ones((1, len(spread)), complex)
        each = ModalSet(poles=of.poles, shapes=shapes, channels=("y",), covariance=of.covariance)
        one = replace(found, modes=each, loudness=np.ones(len(wn)), forces=(), considered=())
        checks = said(verdict_of(one), ModeCheck.MOSTLY_OPEN)
        assert [check.level for check in checks] == [Level.DOUBTFUL] * doubted

    @pytest.mark.parametrize(("loud", "level"), [(9.0, Level.CARE), (11.0, Level.DOUBTFUL)])
    def test_a_quarter_that_is_left_as_other_motion_at_a_mode_is_doubtful(
        self, found: Identification, loud: float, level: Level
    ) -> None:
        """What is left in the best channel is noise, or motion at the frequency of a mode."""
        signal = as_signal(found.response)
        left = np.sqrt(0.3) * np.std(signal.values, axis=1, keepdims=True)
        noise = left * np.random.default_rng(2).standard_normal(signal.values.shape)
        residual = as_response(signal.timepts, noise, list(signal.channels))
        one = replace(found, residual=residual, loudness=np.array([1.0, loud, 1.0]))
        assert 0.6 < float(np.max(one.explained)) < 0.8
        (check,) = said(verdict_of(one), ModeCheck.LITTLE_EXPLAINED)
        assert check.level is level

    @pytest.mark.parametrize(("pairs", "real", "doubted"), [(3, 0, True), (2, 4, False), (2, 0, False)])
    def test_as_many_pairs_that_grow_as_there_are_modes_are_doubtful(
        self, found: Identification, pairs: int, real: int, *, doubted: bool
    ) -> None:
        """A real pole that grows is a drift."""
        poles = [*(0.1 + 5j * (k + 1) for k in range(pairs)), *(complex(0.1 * (k + 1)) for k in range(real))]
        grow = tuple(Considered(pole=pole, remark=Remark(Reason.GROWING), removed=True) for pole in poles)
        checks = said(verdict_of(replace(found, considered=grow)), ModeCheck.GROWING_BESIDE)
        assert [check.level for check in checks] == [Level.DOUBTFUL] * doubted
        assert all("grows within the record" in str(check) for check in checks)

    def test_figures_are_those_of_five_percent(self) -> None:
        # What a report calls roughly known: 5 % in frequency, 25 % in damping; unknown: an interval that reaches zero.
        assert (ROUGH_WN, ROUGH_ZETA, UNKNOWN_ZETA) == (0.05, 0.25, 1.0)

    def test_the_words_name_the_quantity(self, found: Identification) -> None:
        (check,) = said(verdict_of(known_to(found, wn=1e-6, zeta=0.4)), ModeCheck.KNOWN_ROUGHLY)
        assert "damping ratio is known only to 40 %" in str(check)
        assert "frequency" not in str(check)


class TestHeldUp:
    @pytest.mark.parametrize("fallen", [0.36, 0.38])
    def test_motion_that_is_largest_when_every_mode_has_fallen_is_driven(
        self, found: Identification, fallen: float
    ) -> None:
        """Of a free decay of one mode the largest motion comes before it has fallen to 1/e."""
        pairs = int(np.sum(found.modes.poles.imag > 0))
        assert pairs == 3
        # Three masses may pass a motion on: then it falls to 1/e twice before the last has it.
        delay = -pairs * np.log(fallen) / float(np.min(-found.modes.poles.real))
        time = np.arange(3000) * delay / 2000
        values = np.tile(np.where(np.arange(3000) == 2000, 2.0, np.cos(np.arange(3000))), (len(found.noise_std), 1))
        late = replace(
            found,
            response=as_response(time, values, as_signal(found.response).channels),
            loudness=np.full(len(found.modes), 2.0),
        )
        checks = [check for check in _late_motion(late) if check.level is Level.DOUBTFUL]
        assert [check.remark.code for check in checks] == ([ModeCheck.HELD_UP] if fallen < STILL_THERE else [])


class TestShare:
    @pytest.mark.parametrize("over", [-0.02, 0.02])
    def test_half_of_the_energy(self, found: Identification, over: float) -> None:
        """A residual of known energy in one channel: the share explained is one less its part."""
        signal = as_signal(found.response)
        rng = np.random.default_rng(2)
        left = rng.standard_normal(signal.values.shape)
        about = signal.values - signal.values.mean(axis=1, keepdims=True)
        wanted = (1 - LEAST_EXPLAINED - over) * np.sum(about**2, axis=1)
        wanted[1:] = 1e-6
        left *= np.sqrt(wanted / np.sum(left**2, axis=1))[:, None]
        verdict = verdict_of(replace(found, residual=as_response(signal.timepts, left, signal.channels)))
        weak = said(verdict, ModeCheck.CHANNELS_UNEXPLAINED)
        assert bool(weak) is (over < 0)
        assert bool(said(verdict, ModeCheck.BEST_EXPLAINED)) is (over < 0)
        for check in weak:
            assert "seat" in str(check)

    def test_nothing_explained_is_doubtful(self, found: Identification) -> None:
        verdict = verdict_of(replace(found, residual=found.response))
        assert verdict.level is Level.DOUBTFUL
        assert said(verdict, ModeCheck.HARDLY_EXPLAINED)


class TestResidual:
    def test_loud(self, found: Identification) -> None:
        loud = replace(found, loudness=np.array([1.0, 2.5, 1.0]))
        (check,) = said(verdict_of(loud), ModeCheck.RESIDUAL_LOUD)
        assert check.level is Level.CARE
        assert check.remark.numbers["modes"] == ("2 (2.5 times)",)
        assert not said(verdict_of(found), ModeCheck.RESIDUAL_LOUD)

    def test_shared_noise_names_the_two_channels(self, found: Identification) -> None:
        left = np.array(as_signal(found.residual).values)
        left[2] = 3.0 * left[0]
        shared = replace(found, residual=as_response(as_signal(found.residual).timepts, left, ["a", "b", "c"]))
        (check,) = said(verdict_of(shared), ModeCheck.SHARED_NOISE)
        assert (check.remark.numbers["one"], check.remark.numbers["other"]) == ("a", "c")

    def test_the_ridge_method_has_no_residual_to_judge(self, found: Identification) -> None:
        verdict = verdict_of(replace(found, method="ridge"))
        assert not said(verdict, ModeCheck.RESIDUAL_WHITE)


class TestStructure:
    """What is left must be noise: no colour, no line, not most of the motion."""

    @staticmethod
    def with_residual(found: Identification, left: RealArray) -> Verdict:
        signal = as_signal(found.residual)
        values = np.array(signal.values)
        values[1] = left * np.std(values[1]) / np.std(left)
        return verdict_of(replace(found, residual=as_response(signal.timepts, values, signal.channels)))

    @pytest.mark.parametrize("coloured", [True, False])
    def test_colour(self, found: Identification, coloured: bool) -> None:
        # A first-order autoregression has its coefficient as lag-1 correlation.
        noise = np.random.default_rng(3).standard_normal(2000)
        coefficient = 0.6 if coloured else 0.4
        left = np.zeros(2000)
        for k in range(1, 2000):
            left[k] = coefficient * left[k - 1] + noise[k]
        checks = said(self.with_residual(found, left), ModeCheck.RESIDUAL_COLOURED)
        assert bool(checks) is coloured
        assert all(check.remark.numbers["channel"] == "chassis" for check in checks)

    @pytest.mark.parametrize("much", [False, True])
    def test_colour_of_what_is_much_of_a_channel(self, found: Identification, much: bool) -> None:
        # An autoregression of 0.4 may be a sensor's filter where it is noise, and is other motion where it is much.
        noise, left = np.random.default_rng(3).standard_normal(2000), np.zeros(2000)
        for k in range(1, 2000):
            left[k] = 0.4 * left[k - 1] + noise[k]
        signal = as_signal(found.residual)
        values, response = np.array(signal.values), as_signal(found.response).values
        values[1] = left * np.std(response[1]) / np.std(left) * (0.5 if much else 0.01)
        verdict = verdict_of(replace(found, residual=as_response(signal.timepts, values, signal.channels)))
        assert bool(said(verdict, ModeCheck.RESIDUAL_COLOURED)) is much

    @pytest.mark.parametrize("multiple", [1, 2, 3, 5])
    def test_what_a_fit_leaves_of_its_mode_is_no_line(self, found: Identification, multiple: int) -> None:
        hertz = multiple * float(found.modes.poles[0].imag) / (2 * np.pi)
        hum = np.sin(2 * np.pi * hertz * STEP * np.arange(2000)) + 0.1 * np.random.default_rng(3).standard_normal(2000)
        assert said(self.with_residual(found, hum), ModeCheck.RESIDUAL_LINE)
        loud = replace(found, loudness=np.full(len(found.modes), 9.0))
        assert not said(self.with_residual(loud, hum), ModeCheck.RESIDUAL_LINE)

    def test_a_line_beside_a_high_multiple_is_one(self, found: Identification) -> None:
        """Of the sixth multiple 3 % of the mode itself are near, not of the multiple."""
        loud = replace(found, loudness=np.full(len(found.modes), 9.0))
        modes = found.modes.poles.imag / (2 * np.pi)
        hertz = 6.15 * float(modes[0])
        assert np.min(np.abs(modes[:, None] * np.arange(1, 8) - hertz)) > 0.1 * float(modes[0])
        noise = np.random.default_rng(3).standard_normal(2000)
        assert said(
            self.with_residual(loud, 9 * np.sin(2 * np.pi * hertz * STEP * np.arange(2000)) + noise),
            ModeCheck.RESIDUAL_LINE,
        )

    def test_a_line(self, found: Identification) -> None:
        noise = np.random.default_rng(3).standard_normal(2000)
        hum = 0.5 * np.sin(2 * np.pi * 31.0 * STEP * np.arange(2000))
        (check,) = said(self.with_residual(found, noise + hum), ModeCheck.RESIDUAL_LINE)
        assert check.remark.numbers["hertz"] == pytest.approx(31.0, abs=0.2)
        assert not said(self.with_residual(found, noise), ModeCheck.RESIDUAL_LINE)

    @pytest.mark.parametrize(("zeta", "dies"), [(0.0, False), (2e-4, False), (1e-3, True)])
    def test_a_line_that_dies_away_is_a_mode_that_was_not_found(
        self, found: Identification, *, zeta: float, dies: bool
    ) -> None:
        """To a fifth over the record; one that falls to three quarters is as steady as hum is."""
        omega, time = 2 * np.pi * 31.0, STEP * np.arange(2000)
        left = np.exp(-zeta * omega * time) * np.sin(omega * time)
        noise = 0.1 * np.random.default_rng(3).standard_normal(2000)
        code, other = ModeCheck.RESIDUAL_MODE, ModeCheck.RESIDUAL_LINE
        shown = self.with_residual(found, left + noise)
        assert [bool(said(shown, each)) for each in (code, other)] == [dies, not dies]

    def test_noise_shows_no_line(self) -> None:
        """At a level of 1e-6, 400 records of noise show none."""
        rng = np.random.default_rng(8)
        assert not any(clear_line(rng.standard_normal((1, 500)), 0.01) for _ in range(400))

    def test_three_quarters_explained_are_not_sound(self) -> None:
        record = free_decay(cars.PAPER, np.arange(0, 8, STEP), initial_state={"v_tire": 1.0})
        weak = identify(add_noise(record, snr_db=4.5, rng=np.random.default_rng(1)), candidates=[4.0])
        assert said(weak.verdict, ModeCheck.LITTLE_EXPLAINED)
        assert weak.verdict.level <= Level.CARE

    def test_few_cycles(self, found: Identification) -> None:
        signal = as_signal(found.response)
        count = round(2.5 * 2 * np.pi / found.modes.poles[0].imag / STEP)
        part = as_response(signal.timepts[:count], signal.values[:, :count], signal.channels)
        left = as_response(signal.timepts[:count], as_signal(found.residual).values[:, :count], signal.channels)
        (check,) = said(verdict_of(replace(found, response=part, residual=left)), ModeCheck.FEW_CYCLES)
        assert check.remark.numbers["mode"] == 1
        assert check.remark.numbers["cycles"] == pytest.approx(2.5, rel=0.01)

    def test_an_exponential_drift_is_never_sound(self) -> None:
        times = np.arange(1000, dtype=np.float64) * 0.01
        noise = 1e-3 * np.random.default_rng(9).standard_normal(1000)
        found = identify(as_response(times, (np.exp(-times) + noise)[None], ["y"]), candidates=[4.0])
        assert found.verdict.level <= Level.CARE


class TestPoles:
    def test_tones_are_notes(self, found: Identification) -> None:
        tone = Considered(pole=complex(0, 2 * np.pi * 12.5), remark=Remark(Reason.TONE), removed=True)
        (check,) = said(verdict_of(replace(found, considered=(tone, tone))), ModeCheck.STEADY_TONES)
        assert (check.level, check.remark.numbers["number"]) == (Level.NOTE, 2)
        assert "12.5" in str(check)

    def test_a_significant_pole_beyond_the_number_asked_for_is_told(self, found: Identification) -> None:
        beyond = Considered(pole=complex(-1.0, 2 * np.pi * 12.5), remark=Remark(Reason.BEYOND), removed=True)
        verdict = verdict_of(replace(found, considered=(beyond,)))
        (check,) = said(verdict, ModeCheck.DROPPED)
        assert (check.level, check.remark.numbers["number"]) == (Level.CARE, 1)
        assert "12.5 Hz" in str(check)

    def test_a_mode_that_grows_is_doubtful(self, found: Identification) -> None:
        poles = found.modes.poles.copy()
        poles[1] = -poles[1].conj()
        grown = replace(found.modes, poles=poles)
        (check,) = said(verdict_of(replace(found, modes=grown)), ModeCheck.GROWING)
        assert (check.level, check.remark.numbers["modes"]) == (Level.DOUBTFUL, (2,))

    @pytest.mark.parametrize("short", [True, False])
    def test_samples_for_each_unknown(self, found: Identification, short: bool) -> None:
        # Three pairs and an offset: seven unknowns in each channel.
        count = SAMPLES_EACH * 7 - int(short)
        signal = as_signal(found.response)
        part = as_response(signal.timepts[:count], signal.values[:, :count], signal.channels)
        left = as_response(signal.timepts[:count], as_signal(found.residual).values[:, :count], signal.channels)
        verdict = verdict_of(replace(found, response=part, residual=left, considered=()))
        few = said(verdict, ModeCheck.FEW_SAMPLES)
        assert [str(check) for check in few] == [f"Too few samples ({count}) for 7 amplitudes in each channel."] * short

    def test_a_rejected_harmonic_is_said(self, found: Identification) -> None:
        pole = Considered(
            pole=complex(-1.0, 80.0), remark=Remark(Reason.HARMONIC, {"mode": 1, "multiple": 2}), removed=True
        )
        (check,) = said(verdict_of(replace(found, considered=(pole,))), ModeCheck.HARMONICS)
        assert check.level is Level.CARE
        kept = replace(pole, removed=False)
        assert not said(verdict_of(replace(found, considered=(kept,))), ModeCheck.HARMONICS)

    def test_what_fades_without_swinging_may_be_of_the_sensor(self, found: Identification) -> None:
        real = Considered(pole=-1.0 + 0j, remark=Remark(Reason.HARMONIC, {"mode": 1, "multiple": 0}), removed=True)
        verdict = verdict_of(replace(found, considered=(real,)))
        (check,) = said(verdict, ModeCheck.MIDDLE)
        assert check.level is Level.CARE
        assert "AC-coupled sensor" in str(check)
        assert not said(verdict, ModeCheck.HARMONICS)

    @pytest.mark.parametrize(("apart", "loud", "said_so"), [(0.5, 9.0, True), (0.5, 1.0, False), (2.5, 9.0, False)])
    def test_two_modes_within_a_line_may_be_parts_of_one(self, apart: float, loud: float, *, said_so: bool) -> None:
        """Beside white noise they are two; beside a residual near them they may be one that bends."""
        poles = np.array([-1.0 + 40.0j, -0.4 + 1j * (40.0 + apart)])
        modes = ModalSet(poles=poles, shapes=np.ones((1, 2), complex), channels=("y",))
        time = np.asarray(STEP * np.arange(1000), float)
        record = as_response(time, np.real(np.exp(np.outer(time, poles)).sum(axis=1))[None], ["y"])
        one = replace(identify(record), modes=modes, loudness=np.full(2, loud), forces=(), considered=())
        checks = said(verdict_of(one), ModeCheck.PARTS)
        assert [check.level for check in checks] == [Level.DOUBTFUL] * said_so

    @pytest.mark.parametrize(
        ("rates", "apart", "shapes", "said_so"),
        [
            ((2.0, 0.4), 0.5, [[1.1, 0.1]], True),
            ((1.0, 0.4), 0.5, [[1.1, 0.1]], False),
            ((2.0, 0.4), 6.0, [[1.1, 0.1]], False),
            ((12.0, 2.0), 6.0, [[1.1, 0.1]], False),
            ((2.0, 0.4), 0.5, [[1.1, 0.1], [0.1, 1.1]], False),
            ((2.0, 0.4), 0.5, [[1.1, 0.1], [44.0, 4.05]], True),
        ],
    )
    def test_a_broad_mode_over_a_narrow_one_of_the_same_shape_may_be_one(
        self, rates: tuple[float, float], apart: float, shapes: list[list[float]], *, said_so: bool
    ) -> None:
        """White noise beside them or not; two channels have shapes that tell, unless one is the rate of the other."""
        channels = len(shapes)
        poles = np.array([-rates[0] + 40.0j, -rates[1] + 1j * (40.0 + apart)])
        names = tuple(f"y{k}" for k in range(channels))
        modes = ModalSet(poles=poles, shapes=np.asarray(shapes, complex), channels=names)
        time = np.asarray(STEP * np.arange(1000), float)
        record = as_response(time, np.real(modes.shapes @ np.exp(np.outer(poles, time))), names)
        found = replace(identify(record), modes=modes, loudness=np.ones(2), forces=(), considered=())
        one = replace(found, noise_std=np.ones(channels))
        checks = said(verdict_of(one), ModeCheck.BROAD_AND_NARROW)
        assert [check.level for check in checks] == [Level.DOUBTFUL] * said_so

    @pytest.mark.parametrize(
        ("modes", "channels", "apart", "said_so"),
        [(4, 1, 1.5, True), (3, 1, 1.5, False), (4, 2, 1.5, False), (4, 1, 5.0, False)],
    )
    def test_more_modes_in_a_row_than_channels_tell_are_a_band_of_noise(
        self, modes: int, channels: int, apart: float, *, said_so: bool
    ) -> None:
        poles = np.asarray(-0.4 + 1j * (40.0 + apart * np.arange(modes)), complex)
        names = tuple(f"y{k}" for k in range(channels))
        shapes = np.ones((channels, modes), complex)
        time = np.asarray(STEP * np.arange(1000), float)
        course = np.real(np.exp(np.outer(time, poles)).sum(axis=1))
        found = identify(as_response(time, np.tile(course, (channels, 1)), names))
        each = ModalSet(poles=poles, shapes=shapes, channels=names)
        one = replace(found, modes=each, loudness=np.ones(modes), noise_std=np.ones(channels), forces=(), considered=())
        checks = said(verdict_of(one), ModeCheck.IN_A_ROW)
        assert [check.level for check in checks] == [Level.DOUBTFUL] * said_so

    def test_modes_that_the_halves_do_not_tell_are_named(
        self, found: Identification, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        apart = np.where(np.arange(len(found.modes)) == 1, np.nan, found.halves)
        monkeypatch.setattr(Identification, "halves", property(lambda _: apart))
        (check,) = said(verdict_of(found), ModeCheck.NOT_CROSS_CHECKED)
        assert check.remark.numbers["modes"] == (2,)
        assert check.level is Level.NOTE

    @pytest.mark.parametrize(("blind", "count", "level"), [(4, 40, "doubtful"), (2, 40, "note"), (4, 1000, "note")])
    def test_many_modes_of_few_samples_that_no_half_checks(
        self, blind: int, count: int, level: str, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """Eight modes of 93 samples were care, though no half showed six of them."""
        wn = np.array([12.0, 21.0, 33.0, 47.0, 58.0])
        poles, time = (-0.02 + 1j) * wn, STEP * np.arange(1000)
        course = np.real(np.exp(np.outer(time, poles)) @ np.array([[1.0, 0.4], [0.7, -1], [1, 1], [-1, 0.3], [0.5, 1]]))
        noise = 1e-3 * np.random.default_rng(2).standard_normal(course.shape)
        found = identify(as_response(np.asarray(time, float), np.asarray((course + noise).T, float), ["a", "b"]))
        assert len(found.modes) == 5
        apart = np.where(np.arange(5) < blind, np.nan, 1.0)
        monkeypatch.setattr(Identification, "halves", property(lambda _: apart))
        signal = as_signal(found.response)
        part = as_response(signal.timepts[:count], signal.values[:, :count], signal.channels)
        (check,) = said(verdict_of(replace(found, response=part)), ModeCheck.NOT_CROSS_CHECKED)
        assert check.level.label == level


class TestNoMode:
    def test_level_and_headline(self, noise: Identification) -> None:
        assert noise.verdict.level is Level.NONE
        assert str(noise.verdict.headline) == "no mode found"
        assert said(noise.verdict, ModeCheck.NOTHING_DECAYS)

    def test_poles_outside_the_band(self, noise: Identification) -> None:
        away = Considered(pole=-1 + 30j, remark=Remark(Reason.OUTSIDE_THE_BAND), removed=True)
        (check,) = said(verdict_of(replace(noise, considered=(away,))), ModeCheck.NOT_IN_BAND)
        assert check.remark.numbers["poles"] == 1
        nyquist = replace(away, remark=Remark(Reason.NEAR_NYQUIST))
        assert not said(verdict_of(replace(noise, considered=(nyquist,))), ModeCheck.NOT_IN_BAND)

    def test_motion_that_was_removed(self, noise: Identification) -> None:
        tone = Considered(pole=30j, remark=Remark(Reason.TONE), removed=True)
        assert said(verdict_of(replace(noise, considered=(tone,))), ModeCheck.NO_FREE_DECAY)

    @pytest.mark.parametrize(("decay", "steady"), [(0.9, True), (1.1, False)])
    def test_a_line_is_steady_below_one_neper(self, noise: Identification, decay: float, steady: bool) -> None:
        signal = as_signal(noise.response)
        hum = as_response(signal.timepts, signal.values + 0.9 * np.cos(60.0 * signal.timepts), ["y"])
        line = Considered(pole=complex(-decay / signal.duration, 60.0), remark=Remark(Reason.NOT_NEEDED), removed=False)
        assert bool(said(verdict_of(replace(noise, response=hum, considered=(line,))), ModeCheck.STEADY_LINE)) is steady

    def test_what_falls_by_half_is_no_steady_line(self, noise: Identification) -> None:
        """A chime that fades, of which other parts of the fit have the decay: its strongest pole does not."""
        signal = as_signal(noise.response)
        falls = 1.0 - 0.7 * (signal.timepts - signal.timepts[0]) / signal.duration
        hum = as_response(signal.timepts, signal.values + 1.5 * falls * np.cos(60.0 * signal.timepts), ["y"])
        line = Considered(pole=60.0j, remark=Remark(Reason.NOT_NEEDED), removed=False)
        assert not said(verdict_of(replace(noise, response=hum, considered=(line,))), ModeCheck.STEADY_LINE)

    def test_a_broad_peak_is_no_line(self, noise: Identification) -> None:
        """A resonance driven by noise: its strongest pole may lie on the axis, yet the spectrum has no line."""
        drive = np.random.default_rng(7).standard_normal(800)
        times = np.arange(800, dtype=np.float64) * 0.01
        peak = np.convolve(drive, np.exp(-3.0 * times) * np.sin(60.0 * times))[:800]
        pole = Considered(pole=complex(-0.05, 60.0), remark=Remark(Reason.NOT_NEEDED), removed=False)
        driven = replace(noise, response=as_response(times, peak[None], ["y"]), considered=(pole,))
        assert not said(verdict_of(driven), ModeCheck.STEADY_LINE)


class TestLateStart:
    @pytest.mark.parametrize(("place", "late"), [(0, False), (20, False), (21, True), (700, True)])
    def test_a_fiftieth_of_the_record(self, place: int, late: bool) -> None:
        values = 0.01 * np.sin(np.arange(1000))[None]
        values[0, place] = 5.0
        signal = Signal(start=2.0, step=0.01, values=values, channels=("y",))
        assert late_start(signal) == (pytest.approx(2.0 + 0.01 * place) if late else None)


class TestRepeats:
    def test_agreement_and_disagreement(self) -> None:
        decay = as_signal(free_decay(cars.PAPER, np.arange(0, 6, STEP), initial_state={"v_tire": 1.0}))
        rng = np.random.default_rng(6)
        values = np.hstack([decay.values, decay.values]) + 1e-4 * rng.standard_normal((3, 3000))
        record = as_response(np.arange(3000, dtype=np.float64) * STEP, values, decay.channels)
        repeats = identify_repeats(record, [(0.0, 5.99), (6.0, 11.99)])
        assert said(repeats.verdict, ModeCheck.REPEATS_AGREE)
        apart = replace(repeats, consistency=tuple(replace(a, widening=2.0) for a in repeats.consistency))
        (check,) = said(apart.verdict, ModeCheck.REPEATS_DISAGREE)
        assert (check.level, check.remark.numbers["modes"]) == (Level.CARE, (1, 2, 3))
        assert apart.verdict.level is Level.CARE

    def test_decays_of_different_modes_do_not_agree(self) -> None:
        time, rng = np.arange(2000) / 200, np.random.default_rng(1)
        turns = [(2.0, 0.03), (5.0, 0.04)]
        rows = [np.exp((-zeta + 1j) * 2 * np.pi * hertz * time).real for hertz, zeta in turns]
        records = [as_response(time, row[None] + 0.01 * rng.standard_normal((1, 2000)), ["seat"]) for row in rows]
        repeats = identify_repeats(records)
        assert [agreement.held for agreement in repeats.consistency] == [(0,), (1,)]
        assert said(repeats.verdict, ModeCheck.NONE_REPEATED)
        assert not said(repeats.verdict, ModeCheck.REPEATS_AGREE)
        assert repeats.verdict.level is Level.CARE


class TestWords:
    @pytest.mark.parametrize("code", list(Reason))
    def test_every_reason_has_words(self, code: Reason) -> None:
        sizes: dict[str, Number] = {"linewidths": 0.2, "gain": 3.0, "needed": 20.0, "times": 0.4, "most": 50}
        numbers: dict[str, Number] = {**sizes, "mode": 1, "multiple": 2, "other": 2, "word": "sum"}
        assert str(Remark(code, {**numbers, "unlike": 4, "others": 5}))

    def test_the_least_check_decides(self) -> None:
        remark = Remark(Reason.TONE)
        levels = [Level.SOUND, Level.NOTE, Level.CARE, Level.DOUBTFUL, Level.NONE]
        for last, level in enumerate(levels, 1):
            verdict = Verdict(remark, tuple(Check(remark, one) for one in levels[:last]))
            assert verdict.level is (Level.SOUND if level is Level.NOTE else level)
        assert len(verdict.doubts) == 3
        assert Verdict(remark).level is Level.SOUND

    def test_the_gravest_doubt_comes_first(self) -> None:
        care, grave = Remark(Reason.TONE), Remark(ModeCheck.NOTHING_DECAYS)
        checks = (Check(care, Level.CARE), Check(grave, Level.DOUBTFUL), Check(care, Level.CARE))
        assert Verdict(care, checks).doubts == (grave, care, care)

    def test_precision_and_amplitude_keep_their_numbers_apart(self) -> None:
        """Frequency and damping, and the values at large and at small amplitude, each in its place."""
        known = str(Remark(ModeCheck.KNOWN, {"wn": 0.0002, "zeta": 0.031, "level": 0.9}))
        assert re.findall(r"[\d.]+ %", known) == ["0.02 %", "3.1 %", "90 %"]
        numbers: dict[str, Number] = {
            "mode": 1, "high_hz": 1.1, "high_zeta": 0.21, "high": 5.0, "low_hz": 1.3, "low_zeta": 0.34, "low": 0.5,
            "channel": "seat", "holds": 2.0, "high_within": 0.02, "low_within": 0.03,
        }  # fmt: skip
        said = re.findall(r"[\d.]*\d", str(Remark(ModeCheck.AMPLITUDE, numbers)))
        assert said == ["1", "1.1", "0.21", "0.02", "5", "1.3", "0.34", "0.03", "0.5", "2"]
        same = str(Remark(ModeCheck.AMPLITUDE, {**numbers, "low_hz": 1.1 + 1e-6}))
        assert same.count("Hz") == 1
        assert "zeta 0.34 ± 0.03 at 0.5, and 1.1 Hz at both" in same
        rough = str(Remark(ModeCheck.KNOWN_ROUGHLY, {"mode": 1, "zeta": 0.997}))
        assert "known only to 100 % of its value" in rough

    def test_json_holds_codes_numbers_and_sentences(self) -> None:
        remark = Remark(Reason.TOO_WEAK, {"gain": 3.0, "needed": 20.0})
        content = Verdict(remark, (Check(remark, Level.CARE),)).to_dict()
        assert content["level"] == "care"
        checks = content["checks"]
        assert isinstance(checks, list)
        assert checks[0]["numbers"] == {"gain": 3.0, "needed": 20.0}
        assert checks[0]["text"] == str(remark)


class TestNextSteps:
    @staticmethod
    def after(verdict: Verdict, *further: Verdict) -> list[str]:
        return [str(step.code) for step in next_steps(verdict, car=True, further=further)]

    def test_poor_grip_and_worn_dampers_come_first(self) -> None:
        fine = Verdict(Remark(EstimateHeadline.FOUND, {"records": 1, "parameters": 2}))
        numbers: dict[str, Number] = {
            "wheel": "front",
            "phase": 20.0,
            "limit": 35.0,
            "damper": "front",
            "loss": 0.4,
            "low": 0.3,
        }
        worn = Verdict(
            Remark(WearHeadline.DAMPERS, {"texts": ("front worn",)}),
            (Check(Remark(WearCheck.LOST, numbers), Level.CARE),),
        )
        poor = Verdict(
            Remark(GripHeadline.GRIP, {"names": ("front",)}), (Check(Remark(GripCheck.FAILS, numbers), Level.CARE),)
        )
        assert self.after(fine) == ["use"]
        assert self.after(fine, poor) == ["poor grip", "use"]
        assert self.after(fine, poor, worn) == ["look at dampers", "poor grip", "use"]


def test_many_channels_fit_a_screen() -> None:
    """Tables and sentences list the first channels and count the others; the result holds all."""
    count = 40
    rng = np.random.default_rng(1)
    record = free_decay(cars.PAPER, np.arange(0, 8, 0.02), initial_state={"v_tire": 1.0})
    motion = rng.standard_normal((count, 3)) @ as_signal(record).values
    # Three times the motion: a tenth of the energy is explained.
    found = identify(motion + 3 * np.std(motion) * rng.standard_normal(motion.shape), fs=50.0)
    assert len(found.explained) == count
    text = str(found)
    assert f"… and {count - 24} more in .details()" in text
    assert "more in" not in found.details()
    assert all(f" {name} " in found.details() for name in found.modes.channels)
    (check,) = said(found.verdict, ModeCheck.CHANNELS_UNEXPLAINED)
    assert str(check.remark).count("%") == 6
    assert " others. They carry noise" in str(check.remark)


@pytest.mark.parametrize(
    ("cycles", "noise_std", "rate", "pulse"),
    [
        (20.0, 0.01, 0.05, False),
        (2.8, 0.001, 0.05, True),
        (3.3, 0.001, 0.05, False),
        (3.3, 0.1, 0.05, True),
        (6.5, 0.1, 0.05, False),
        (6.5, 0.3, 0.05, True),
        (6.5, 0.1, 0.02, True),
        (9.0, 0.1, 1.0, True),
    ],
)
def test_a_mode_that_swings_many_times_is_no_pulse(
    cycles: float, noise_std: float, rate: float, pulse: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One channel moves alike by itself; where neither half tells the damping, a few cycles may be a pulse.

    A few are plainly seen where they decay, but not at once, and where there is hardly any noise beside them.
    """
    time = np.arange(1000) / 100
    values = np.exp(-rate * time) * np.cos(2 * np.pi * cycles / 10 * time)
    noise = noise_std * np.random.default_rng(2).standard_normal(time.size)
    one = identify(as_response(time, (values + noise)[None], ["y"]), modes=1)
    monkeypatch.setattr(Identification, "halves", property(lambda _: np.full(1, np.nan)))
    assert bool(said(verdict_of(one), ModeCheck.ONE_SHAPE)) is pulse


@pytest.mark.parametrize(
    ("hertz", "zeta", "named"),
    [(2.0, 0.007, True), (3.0, 0.006, True), (2.03, 0.007, False), (2.0, 0.02, False), (4.0, 0.007, False)],
)
def test_a_mode_at_twice_or_three_times_another_calls_for_care(hertz: float, zeta: float, named: bool) -> None:
    """A pendulum of 1 Hz by two axes: its pull along the string has twice the frequency, and is the larger."""
    time, rng = np.arange(1500) / 50, np.random.default_rng(3)
    across = np.exp(-0.007 * 2 * np.pi * time) * np.cos(2 * np.pi * time)
    along = 2 * np.exp(-zeta * 2 * np.pi * hertz * time) * np.cos(2 * np.pi * hertz * time + 1)
    values = np.array([across + 0.1 * along, along]) + 0.05 * rng.standard_normal((2, time.size))
    found = identify(as_response(time, values, ["across", "along"]))
    assert len(found.modes) == 2
    checks = said(found.verdict, ModeCheck.MULTIPLE)
    assert [check.remark.numbers["multiple"] for check in checks] == ([round(hertz)] if named else [])
    assert all(check.level is Level.CARE for check in checks)


@pytest.mark.parametrize(("hertz", "named"), [(2.0, True), (2.3, False)])
def test_a_vague_mode_near_the_double_of_another_may_be_none(hertz: float, named: bool) -> None:
    """A pendulum on a film: of what it moves up and down the damping is hardly known."""
    time, rng = np.arange(300) / 30, np.random.default_rng(4)
    across = np.exp(-0.03 * 2 * np.pi * time) * np.cos(2 * np.pi * time)
    along = 0.15 * np.exp(-0.08 * 2 * np.pi * hertz * time) * np.cos(2 * np.pi * hertz * time + 1)
    values = np.array([across, along]) + 0.04 * rng.standard_normal((2, time.size))
    found = identify(as_response(time, values, ["across", "along"]))
    assert len(found.modes) == 2
    assert found.modes.zeta_std is not None
    assert 1.96 * found.modes.zeta_std[1] > 0.25 * found.modes.zeta[1]
    assert bool(said(found.verdict, ModeCheck.MULTIPLE)) is named


@pytest.mark.parametrize(("rates", "level"), [((3.0,), Level.CARE), ((2.0, 9.0), Level.DOUBTFUL)])
def test_several_real_poles_alone_are_doubtful(rates: tuple[float, ...], level: Level) -> None:
    """Two exponentials follow any slow fall, as that of a circuit whose resistor is not quite one."""
    time = np.arange(600) / 100
    falls = np.sum(np.exp(-np.outer(rates, time)), axis=0)
    noise = 1e-3 * np.random.default_rng(1).standard_normal(time.size)
    found = identify(as_response(time, (falls + noise)[None], ["voltage"]))
    assert len(found.modes) == len(rates)
    (check,) = [check for check in found.verdict.checks if check.remark.code is ModeCheck.REAL_ONLY]
    assert check.level is level
