"""Masses that friction stops soon: they stand still for most of a record, and their swings fall along a line."""

from __future__ import annotations

import numpy as np
import pytest
from test_support import MISSING, decay, identified, stretch

from suspid import ModalSet, Settings
from suspid.analysis.held import without_held
from suspid.analysis.support import supported
from suspid.analysis.swings import shown_by_swings
from suspid.analysis.used import used_of
from suspid.records import as_response
from suspid.units import RealArray
from suspid.words import Note

STEP = 0.01


def clock(count: int) -> RealArray:
    return np.asarray(STEP * np.arange(count), float)


def rubbed(hertz: float, *, swings: int, before: float = 1.0, after: float = 2.0) -> RealArray:
    """Return the exact motion of a mass that is held at 1, let go, and stopped by friction after a number of swings.

    Each swing turns about a point on the side that it comes from, and is ``2 / swings`` smaller than the one before.
    """
    lost, turn = 1 / swings, np.arange(round(0.5 / hertz / STEP)) * STEP * 2 * np.pi * hertz
    parts, place = [np.ones(round(before / STEP))], 1.0
    for _ in range(swings // 2 * 2 - 1):
        middle = np.sign(place) * lost / 2
        parts.append(middle + (place - middle) * np.cos(turn))
        place = 2 * middle - place
    return np.concatenate([*parts, np.full(round(after / STEP), place)])


def modes(*hertz: float) -> ModalSet:
    return ModalSet.from_wn_zeta(2 * np.pi * np.array(hertz), np.full(len(hertz), 0.05))


def shown(values: RealArray, of: ModalSet) -> list[bool]:
    return list(shown_by_swings(as_response(clock(values.size), values[None], ["seat"]), of))


class TestSwings:
    def test_a_mode_that_takes_their_time_is_shown(self) -> None:
        assert shown(rubbed(1.4, swings=10), modes(1.4, 2.0)) == [True, False]

    @pytest.mark.parametrize(("before", "after"), [(0.02, 2.0), (1.0, 0.1)])
    def test_without_a_rest_before_and_after_none_is(self, before: float, after: float) -> None:
        """What is driven swings by less for some time, too."""
        values = rubbed(1.4, swings=12, before=before, after=after)
        moving = 0.3 * np.sin(2 * np.pi * 1.4 * STEP * np.arange(200))
        driven = np.concatenate([values[0] + moving, values] if before < after else [values, values[-1] + moving])
        assert shown(driven, modes(1.4)) == [False]

    def test_swings_that_grow_or_take_other_times_show_none(self) -> None:
        values = rubbed(1.4, swings=10)
        slowing = np.interp(np.linspace(0, 1, 900) ** 1.6 * (values.size - 1), np.arange(values.size), values)
        assert shown(values[::-1], modes(1.4)) == shown(slowing, modes(1.4)) == [False]

    def test_few_swings_show_none(self) -> None:
        assert shown(rubbed(1.4, swings=4), modes(1.4)) == [False]


class TestLimits:
    """What is within each limit and what is not, so that none is changed without a word."""

    @pytest.mark.parametrize(("share", "is_shown"), [(0.85, False), (0.94, True), (1.06, True), (1.15, False)])
    def test_the_time_of_the_mode(self, share: float, is_shown: bool) -> None:
        assert shown(rubbed(1.4, swings=10), modes(1.4 * share)) == [is_shown]

    @pytest.mark.parametrize(("periods", "is_shown"), [(0.15, False), (0.4, True)])
    def test_the_rest_before(self, periods: float, is_shown: bool) -> None:
        assert shown(rubbed(1.0, swings=10, before=periods), modes(1.0)) == [is_shown]

    @pytest.mark.parametrize(("periods", "is_shown"), [(0.7, False), (1.2, True)])
    def test_the_rest_after(self, periods: float, is_shown: bool) -> None:
        assert shown(rubbed(1.0, swings=10, after=periods), modes(1.0)) == [is_shown]

    @pytest.mark.parametrize(("swings", "is_shown"), [(6, False), (8, True)])
    def test_the_number_of_swings(self, swings: int, is_shown: bool) -> None:
        assert shown(rubbed(1.4, swings=swings), modes(1.4)) == [is_shown]


@pytest.mark.parametrize(("hertz", "kept"), [(1.5 * np.sqrt(1 - 0.5**2), True), (2.5, False)])
def test_a_doubted_mode_counts_if_the_record_shows_its_swings(hertz: float, kept: bool) -> None:
    found = identified(0.5)
    values = rubbed(hertz, swings=10)
    whole = as_response(clock(values.size), values[None], ["seat"])
    left = supported(found, stretch(found, (decay(0, 1.5, MISSING),), ()), Settings(), whole=whole)
    assert bool(len(left.modes)) is kept
    assert left.verdict.level <= found.verdict.level


class TestHeld:
    def rates(self, values: RealArray) -> list[str]:
        other = np.cos(0.2 * np.arange(values.size)) * np.exp(-np.arange(values.size) / 200)
        record = as_response(clock(values.size), np.stack([other, values]), ["other", "asked"])
        return list(without_held(record)[0].output_labels)

    def test_a_mass_that_friction_stops_within_a_second_is_no_command(self) -> None:
        """Sampled at 100 Hz, 7 swings of 5 Hz last 35 samples: no longer than a jump that a spline drew."""
        values = np.round(400 * rubbed(10.0, swings=8, before=2.0, after=3.0))
        assert self.rates(values) == ["other", "asked"]

    @pytest.mark.parametrize(
        ("lasts", "back", "beside", "kept"),
        [
            (32, 0, False, True),
            (58, 0, False, True),
            (70, 0, False, False),
            (32, 0.9, False, False),
            (32, 0, True, True),
        ],
    )
    def test_nor_is_one_that_turns_once_where_no_other_moves_for_longer(
        self, lasts: int, back: float, beside: bool, kept: bool
    ) -> None:
        """The other moves for less than twice as long, and it does not come back; a switch does not tell."""
        shape = 1 - np.exp(-np.arange(33) / 8) * np.cos(2 * np.pi * np.arange(33) / 30)
        jump = np.round(500 * (shape - back * np.linspace(0, 1, 33) * shape[-1]))
        values = np.concatenate([np.zeros(150), jump, np.full(300, jump[-1])])
        swings = 100 * np.sin(2 * np.pi * np.arange(400) / 10) * np.exp(-np.arange(400) / 400)
        other = np.concatenate([np.zeros(150), np.round(swings[:lasts]), np.zeros(values.size - 150 - lasts)])
        switch = np.arange(values.size) // 20 % 2 * 5.0
        names = ["other", "asked", "switch"][: 2 + beside]
        record = as_response(clock(values.size), np.stack([other, values, switch])[: 2 + beside], names)
        assert ("asked" in without_held(record)[0].output_labels) is kept

    @pytest.mark.parametrize("pulse", [[1.0], [1.0, 0.0], [1.0, -1.0, 0.0], [0.5, 1.0, -1.0, -0.5, 0.0]])
    def test_steps_and_pulses_are(self, pulse: list[float]) -> None:
        values = np.concatenate([np.zeros(150), np.repeat(pulse, 9), np.full(200, pulse[-1])])
        assert self.rates(values) == ["other"]

    @pytest.mark.parametrize("name", ["duty_cycle", "PWM 1", "Commanded Pos", "set point"])
    def test_what_is_named_as_a_command_is_one(self, name: str) -> None:
        values = np.sin(0.2 * np.arange(900)) * np.exp(-np.arange(900) / 200)
        record = as_response(clock(900), np.stack([values, values**2]), ["cart", name])
        assert list(without_held(record)[0].output_labels) == ["cart"]

    @pytest.mark.parametrize(("levels", "left"), [(2, True), (3, True), (5, False)])
    def test_what_has_a_few_values_only_is_none(self, levels: int, left: bool) -> None:
        """A sensor at rest that toggles by a step of its resolution, or a valve that is switched again and again."""
        values = np.asarray(np.random.default_rng(3).integers(0, levels, 900) * 0.017, float)
        assert self.rates(values) == (["other"] if left else ["other", "asked"])


@pytest.mark.parametrize(("levels", "kept"), [(1, ["seat"]), (2, ["seat"]), (9, ["seat", "beside"])])
def test_a_channel_that_toggles_in_a_decay_is_no_part_of_it(levels: int, kept: list[str]) -> None:
    """Before the decay it moved as well."""
    values, rng = rubbed(1.5, swings=10), np.random.default_rng(3)
    beside = rng.integers(0, levels, values.size) * 0.017
    beside[:40] = 5 * rng.standard_normal(40)
    record = as_response(clock(values.size), np.stack([values, beside]), ["seat", "beside"])
    one = decay(float(clock(values.size)[60]), float(clock(values.size)[-1]))
    used = used_of(record, (one,), one)
    assert list(used.record.output_labels) == kept
    assert [note.code for note in used.notes].count(Note.STILL_CHANNEL) == 2 - len(kept)
