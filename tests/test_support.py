"""A doubtful mode needs support besides the fit to one stretch: halves, channels, or another stretch."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.stats import binom

from suspid import Identification, Level, Settings, analyse, identify
from suspid.analysis.choice import level_of
from suspid.analysis.support import _coherent, _without, supported
from suspid.analysis.used import Used
from suspid.decays import Decay
from suspid.identification import Force, ForceKind
from suspid.records import as_response
from suspid.signals import as_signal
from suspid.words import DecayDoubt, DecayKind, Note, Number, Reason, Remark
from validation import no_decay

HERTZ = 1.5
MISSING = Remark(DecayDoubt.MODES_MISSING, {"hertz": (3.0,)})
SHORT = Remark(DecayDoubt.TOO_SHORT, {"hertz": HERTZ, "cycles": 1.5})
WHOLE: dict[str, Number] = {"found": 0, "clear": 0, "modes": 1, "best": "", "remarks": ""}


@cache
def identified(zeta: float) -> Identification:
    """Free motion of one mass: with heavy damping neither half of the record tells its mode, and a pulse is like it."""
    time = np.arange(600) / 200
    wn = 2 * np.pi * HERTZ
    values = np.exp(-zeta * wn * time) * np.cos(wn * np.sqrt(1 - zeta**2) * time)
    values = values + 0.03 * np.random.default_rng(3).standard_normal(time.size)
    return identify(as_response(time, values[None], ["seat"]))


def decay(start: float, hertz: float, *doubts: Remark) -> Decay:
    return Decay(
        start=start,
        stop=start + 3,
        rank=1,
        kind=None,
        level=30.0,
        cycles=2.0,
        strength=40.0,
        wn=np.array([2 * np.pi * hertz]),
        zeta=np.array([0.5]),
        doubts=doubts,
    )


def stretch(found: Identification, used: tuple[Decay, ...], others: tuple[Decay, ...], *notes: Remark) -> Used:
    return Used(record=found.response, decays=(*used, *others), used=used, notes=notes, identification=found)


class TestSupport:
    @pytest.mark.parametrize(
        ("others", "kept"),
        [
            ((), False),
            ((decay(5, 1.02 * HERTZ),), True),
            ((decay(5, 0.95 * HERTZ),), True),
            ((decay(5, 2 * HERTZ),), False),
            ((decay(1, HERTZ),), False),
            ((decay(5, HERTZ, MISSING),), False),
            ((decay(5, HERTZ), decay(10, 2 * HERTZ)), True),
            ((decay(5, HERTZ), decay(10, 2 * HERTZ), decay(15, 3 * HERTZ)), False),
        ],
        ids=["alone", "again", "nearly again", "another mode", "the same stretch", "driven motion", "half", "a third"],
    )
    def test_a_doubted_stretch_counts_if_another_shows_its_mode(self, others: tuple[Decay, ...], kept: bool) -> None:
        """A body that is let go again shows the same mode; a stretch does not support itself."""
        found = identified(0.5)
        assert found.verdict.level is Level.DOUBTFUL
        for doubt in (MISSING, SHORT):
            assert len(supported(found, stretch(found, (decay(0, HERTZ, doubt),), others), Settings()).modes) == kept

    def test_what_is_not_doubtful_needs_none(self) -> None:
        found = identified(0.02)
        assert found.verdict.level > Level.DOUBTFUL
        assert supported(found, stretch(found, (decay(0, HERTZ, SHORT),), ()), Settings()) is found

    def test_a_clear_decay_needs_none(self) -> None:
        found = identified(0.5)
        assert supported(found, stretch(found, (decay(0, HERTZ),), ()), Settings()) is found

    @pytest.mark.parametrize("settings", [Settings(decay=1), Settings(start=0.0), Settings(modes=1)])
    def test_what_was_asked_for_needs_none(self, settings: Settings) -> None:
        found = identified(0.5)
        assert supported(found, stretch(found, (decay(0, HERTZ, MISSING),), ()), settings) is found

    def test_the_fit_and_the_poles_stay(self) -> None:
        found = identified(0.5)
        left = supported(found, stretch(found, (decay(0, HERTZ, MISSING),), ()), Settings())
        np.testing.assert_array_equal(as_signal(left.fitted).values, as_signal(found.fitted).values)
        (pole,) = [c.pole for c in left.considered if c.remark.code is Reason.UNSUPPORTED]
        assert pole == found.modes.poles[0]
        assert left.verdict.level is Level.NONE
        assert "supports" in str(left)

    def test_one_of_many_unlike_stretches_is_one_by_chance(self) -> None:
        """Of three others, one has the mode by chance: a structure would show it in most."""
        found = identified(0.5)
        others = (decay(5, 2 * HERTZ), decay(10, 3 * HERTZ), decay(15, 4 * HERTZ), decay(20, HERTZ))
        left = supported(found, stretch(found, (decay(0, HERTZ),), others), Settings())
        assert [c.remark.code for c in left.considered][:1] == [Reason.BY_CHANCE]
        again = tuple(decay(5 * k, HERTZ) for k in range(5, 8))
        assert supported(found, stretch(found, (decay(0, HERTZ),), (*others, *again)), Settings()) is found

    def test_forces_do_not_support_one_of_many_unlike_stretches(self) -> None:
        """Halves of different size cannot check them; a linear decay that is beyond doubt is left to the user."""
        found = identified(0.02)
        others = (decay(5, 2 * HERTZ), decay(10, 3 * HERTZ), decay(15, 4 * HERTZ))
        assert supported(found, stretch(found, (decay(0, HERTZ),), others), Settings()) is found
        bent = replace(found, forces=(Force(kind=ForceKind.FRICTION, channel=0, other=None),))
        left = supported(bent, stretch(bent, (decay(0, HERTZ),), others), Settings())
        assert [c.remark.code for c in left.considered][:1] == [Reason.BY_CHANCE]
        assert supported(bent, stretch(bent, (decay(0, HERTZ),), others[:2]), Settings()) is bent


class TestLightDecays:
    @pytest.mark.parametrize(("beside", "coherent"), [(0.0, True), (0.1, False)])
    def test_three_swings_are_where_they_are_all_of_the_motion(self, beside: float, *, coherent: bool) -> None:
        """As of a wheel on a torsion bar, of which 5 s were recorded."""
        time = np.arange(2300) / 500
        values = np.exp(-0.017 * time) * np.cos(4.4 * time) + beside * np.cos(2.0 * time + 0.3 * time**2)
        noise = 0.005 * np.random.default_rng(3).standard_normal(time.size)
        found = identify(as_response(time, (values + noise)[None], ["wheel"]), modes=1)
        assert _coherent(found).tolist() == [coherent]

    @pytest.mark.parametrize(("zeta", "coherent"), [(0.0, True), (0.01, True), (0.03, False), (0.5, False)])
    def test_one_swing_over_many_cycles_is_plain_to_see(self, zeta: float, coherent: bool) -> None:
        time = np.arange(4000) / 200
        noise = 0.003 * np.random.default_rng(3).standard_normal(time.size)
        values = np.exp(-zeta * 9.42 * time) * np.cos(9.42 * time) + noise
        found = identify(as_response(time, np.stack([values, 0.1 * np.sin(60 * time)]), ["seat", "chassis"]))
        near = np.abs(found.modes.wn / 9.42 - 1) < 0.3
        assert _coherent(found)[near].tolist() == [coherent] * int(np.sum(near))

    @pytest.mark.slow
    def test_its_mode_stays_and_what_only_the_fit_shows_goes(self) -> None:
        """A pendulum that loses 12 % in 28 cycles, beside a steady tone: neither half tells its damping."""
        time, rng = np.arange(1840) / 40, np.random.default_rng(0)
        swing = 10 * np.exp(-0.0027 * time) * np.cos(3.895 * time - 0.05 * np.exp(-time / 20) + 0.3)
        values = np.outer([1.0, 0.8], swing + 0.1 * np.cos(4.268 * time)) + 0.02 * rng.standard_normal((2, time.size))
        found = analyse(as_response(time, values, ["left", "right"]))
        assert found.verdict.level is Level.CARE
        assert found.modes.wn == pytest.approx([3.895], rel=1e-3)
        assert found.modes.zeta == pytest.approx([0.0027 / 3.895], rel=0.05)
        assert Reason.UNSUPPORTED in {each.remark.code for each in found.identification.considered}


class TestWholeRecords:
    def test_a_mode_that_never_swings_is_a_pulse(self) -> None:
        """With zeta 0.65 the second half of the first cycle has exp(-pi 0.65 / 0.76) = 7 % of the first."""
        found = identified(0.65)
        left = supported(found, stretch(found, (), ()), Settings())
        assert (len(found.modes), [c.remark.code for c in left.considered][:1]) == (1, [Reason.NO_SWING])

    def test_one_that_swings_beside_it_is_not_said_to_be_damped(self) -> None:
        time = np.arange(400) / 100
        noise = 1e-2 * np.random.default_rng(1).standard_normal(time.size)
        values = np.exp(-3 * time) + 0.5 * np.exp(-0.5 * time) * np.sin(30 * time) + noise
        found = identify(as_response(time, values[None], ["seat"]))
        left = _without(found, np.ones(len(found.modes), bool), Remark(Reason.NO_SWING))
        said = {c.remark.code: c.pole.imag > 0 for c in left.considered if c.removed}
        assert said == {Reason.NO_SWING: False, Reason.UNSUPPORTED: True}

    @pytest.mark.parametrize(
        ("searched", "late", "kept"), [(True, True, False), (False, True, True), (True, False, True)]
    )
    def test_a_record_that_is_used_for_want_of_a_decay_needs_support(
        self, searched: bool, late: bool, kept: bool
    ) -> None:
        """One that moves most at its first sample may be a decay without a search; the fit is the same in each case."""
        found = identified(0.5)
        record = found.response
        if late:
            record = as_response(as_signal(record).timepts, as_signal(record).values[:, ::-1], ["seat"])
        notes = (Remark(Note.WHOLE_RECORD, WHOLE),) if searched else ()
        whole = replace(stretch(found, (), (), *notes), record=record)
        assert bool(len(supported(found, whole, Settings()).modes)) is kept

    @pytest.mark.parametrize(("beside", "kept"), [(0.1, True), (30.0, False)])
    @pytest.mark.parametrize("bent", [False, True])
    def test_what_is_a_small_part_of_the_motion_needs_support(self, beside: float, *, bent: bool, kept: bool) -> None:
        """Of many bursts of what is driven, one is like a decay by chance; forces that explain it support nothing."""
        found = identified(0.02 if bent else 0.5)
        if bent:
            found = replace(found, forces=(Force(kind=ForceKind.FRICTION, channel=0, other=None),))
        later = beside * np.sin(2 * np.pi * HERTZ * np.arange(600) / 200)
        values = np.concatenate([as_signal(found.response).values[0], later])
        whole = as_response(np.arange(1200) / 200, values[None], ["seat"])
        used = stretch(found, (decay(0, HERTZ, *((MISSING,) if bent else ())),), ())
        assert bool(len(supported(found, used, Settings(), whole=whole).modes)) is kept

    @pytest.mark.parametrize(("second", "kept"), [((1.0, 0.7), False), ((1.0, -0.7), True)])
    def test_modes_of_one_shape_need_support(self, second: tuple[float, float], kept: bool) -> None:
        """A force in one place moves all channels alike, whatever its course; modes of a structure have own shapes."""
        time, values = np.arange(600) / 200, 0.03 * np.random.default_rng(3).standard_normal((2, 600))
        for shape, wn in (((1.0, 0.7), 2 * np.pi * HERTZ), (second, 8 * np.pi)):
            values += np.outer(shape, np.exp(-0.5 * wn * time) * np.cos(wn * np.sqrt(0.75) * time))
        found = identify(as_response(time, values, ["seat", "chassis"]))
        assert (len(found.modes), found.verdict.level) == (2, Level.DOUBTFUL)
        assert bool(len(supported(found, stretch(found, (), ()), Settings()).modes)) is kept


@pytest.mark.parametrize(
    ("kind", "seed"),
    [
        ("Gaussian pulse", 1_200_004),
        ("Gaussian pulse", 1_200_019),
        ("braking", 1_200_008),
        ("engine at idle, 12 Hz", 1_200_008),
        pytest.param("speech-like modulation", 5013, marks=pytest.mark.slow),
        pytest.param("speech-like modulation", 5056, marks=pytest.mark.slow),
    ],
)
def test_forced_motion_has_no_modes(kind: str, seed: int) -> None:
    """Nothing in these records moves freely; a fit to a part of each is close."""
    time, values = no_decay.KINDS[kind](np.random.default_rng(seed))
    assert not len(analyse(as_response(time, values, [f"y{k}" for k in range(len(values))])).modes)


@pytest.mark.slow
@pytest.mark.parametrize(
    "kind", ["Gaussian pulse", "half-sine pulse", "engine at idle, 12 Hz", "speech-like modulation"]
)
def test_at_most_one_record_of_forced_motion_in_twenty_has_modes(kind: str) -> None:
    """With a share of 5 % more than the bound have some once in a thousand runs of this test."""
    records = 40
    assert sum(no_decay.outcome(kind, seed)[3] for seed in range(1_210_000, 1_210_000 + records)) <= binom.ppf(
        0.999, records, 0.05
    )


def test_real_poles_beside_tones_are_the_mean_of_driven_motion() -> None:
    """Legs of a robot that walks: its mean settles while it walks on."""
    time = np.arange(260) / 30
    walk = np.cos(2 * np.pi * 0.553 * time) + 0.3 * np.cos(2 * np.pi * 1.66 * time + 1)
    noise = 2e-3 * np.random.default_rng(1).standard_normal(time.size)
    found = analyse(as_response(time, (walk - 0.5 * np.exp(-4 * time) + noise)[None], ["leg"]))
    assert not len(found.modes)
    assert identify(as_response(time, (walk - 0.5 * np.exp(-4 * time) + noise)[None], ["leg"])).modes.kinds == ("real",)


@pytest.mark.parametrize(("kind", "level"), [(None, Level.DOUBTFUL), (DecayKind.RELEASE, Level.CARE)])
def test_what_never_swings_must_have_been_let_go(kind: DecayKind | None, level: Level) -> None:
    """The end of a pulse of force falls as a mass that creeps back does."""
    time = np.arange(400) / 100
    noise = 1e-3 * np.random.default_rng(1).standard_normal(time.size)
    found = identify(as_response(time, (np.exp(-2 * time) + noise)[None], ["seat"]))
    assert found.modes.kinds == ("real",)
    used = (replace(decay(0.0, 0.3), kind=kind),)
    assert level_of(found, used, used) is level
