"""What chi-square, degrees of freedom, widening and verdict of a reconstruction have to obey."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import chdtri, ndtr

from suspid import ModalSet, Strut, Suspension, eigenmodes
from suspid.levels import UNLIKELY, beyond_chance, normal_reach
from suspid.reconstruction.reconstruct import Reconstruction, reconstruct
from suspid.words import Level, ReconstructionCheck, ReconstructionNote, Remark, Suspect
from validation.cars import HATCHBACK, PAPER, SALOON
from validation.springs import nominal, with_noise


def plain(seed: int, car: Suspension = PAPER) -> ModalSet:
    return with_noise(eigenmodes(car), np.random.default_rng(seed), spread=1e-3)


def scaled(modes: ModalSet, factor: float) -> ModalSet:
    """Return the modes with their covariance times a factor: chi-square is divided by it."""
    assert modes.covariance is not None
    return replace(modes, covariance=factor * modes.covariance)


def remark(found: Reconstruction, code: object) -> Remark:
    (one,) = (r for r in found.remarks if r.code is code)
    return one


def checks(found: Reconstruction) -> dict[object, Level]:
    return {check.remark.code: check.level for check in found.verdict.checks}


def with_sky() -> Suspension:
    """Return a car with a strut that the topology of PAPER lacks."""
    sky = Strut(name="sky", stiffness=2000, damping=30, arms={"seat": 1, "sky": -1})
    return Suspension(masses=PAPER.masses, struts=[*PAPER.struts, sky])


def on_its_bound() -> ModalSet:
    """Return modes of a car without tire damping that a negative damper would fit better."""
    for seed in range(20):
        modes = plain(seed, SALOON)
        if reconstruct(modes, nominal(SALOON)).suspension.struts[-1].damping == 0.0:
            return modes
    raise AssertionError("half of the draws end there")


class TestWidening:
    """Intervals of modes that the topology does not explain come from the misfit, not from the stated covariance."""

    def test_the_size_of_the_covariance_does_not_matter(self) -> None:
        modes = plain(1, with_sky())
        first = reconstruct(modes, nominal(PAPER))
        assert not first.explains
        half = reconstruct(scaled(modes, 0.25), nominal(PAPER))
        assert not half.explains
        assert first.stiffness_std is not None
        assert half.stiffness_std == pytest.approx(dict(first.stiffness_std), rel=1e-3), "optimum to 1e-8 of chi-square"

    def test_they_are_those_of_a_covariance_that_the_misfit_agrees_with(self) -> None:
        """Where chi-square is its degrees of freedom, nothing is widened, and the intervals are the same."""
        modes = plain(1, with_sky())
        first = reconstruct(modes, nominal(PAPER))
        assert first.chi_square is not None
        agreed = reconstruct(scaled(modes, first.chi_square / first.freedom), nominal(PAPER))
        assert agreed.explains
        assert agreed.chi_square == pytest.approx(agreed.freedom, rel=1e-3)
        assert first.damping_std is not None
        assert agreed.damping_std == pytest.approx(dict(first.damping_std), rel=1e-3)
        widening = remark(first, ReconstructionNote.UNEXPLAINED).numbers["widening"]
        assert widening == pytest.approx((first.chi_square / first.freedom) ** 0.5)

    def test_what_is_explained_is_not_widened(self) -> None:
        """Four times the covariance are twice the standard deviations."""
        one, four = (reconstruct(scaled(plain(2), factor), nominal(PAPER)) for factor in (1.0, 4.0))
        assert one.explains
        assert four.explains
        assert four.stiffness_std == pytest.approx({n: 2 * s for n, s in (one.stiffness_std or {}).items()}, rel=1e-3)


class TestDegreesOfFreedom:
    def test_equations_less_unknowns(self) -> None:
        """Three complex poles and two free complex components of each shape are 18 numbers."""
        assert reconstruct(plain(3), nominal(PAPER)).freedom == 18 - 6
        assert reconstruct(plain(3), nominal(PAPER), fixed=["tire"]).freedom == 18 - 4

    def test_a_parameter_on_its_bound_gives_one_back(self) -> None:
        """It is as if it were held there: judged alike, also where one degree of freedom decides."""
        modes = on_its_bound()
        first = reconstruct(modes, nominal(SALOON))
        assert first.chi_square is not None
        few, more = (float(chdtri(first.freedom + given_back, UNLIKELY)) for given_back in (0, 1))
        between = scaled(modes, first.chi_square / ((few + more) / 2))
        free, held = (reconstruct(between, nominal(SALOON), fixed=f) for f in ((), ("tire.damping",)))
        assert held.freedom == free.freedom + 1
        assert held.chi_square == pytest.approx(free.chi_square, rel=1e-6)
        assert held.chi_square == pytest.approx((few + more) / 2, rel=1e-3)
        assert held.explains
        assert free.explains

    def test_so_does_a_constraint_that_acts(self) -> None:
        car = PAPER.with_parameters(damping={"seat": 200.0})
        modes = plain(4, car)
        free = reconstruct(modes, nominal(car))
        ratio = free.suspension.struts[0].damping / free.suspension.struts[1].damping
        text = f"seat.damping >= {1.02 * ratio} * chassis.damping"
        first = reconstruct(modes, nominal(car), constraints=text)
        assert first.chi_square is not None
        few, more = (float(chdtri(first.freedom + given_back, UNLIKELY)) for given_back in (0, 1))
        between = scaled(modes, first.chi_square / ((few + more) / 2))
        held = reconstruct(between, nominal(car), constraints=text)
        assert held.chi_square == pytest.approx((few + more) / 2, rel=1e-3)
        assert held.explains

    def test_a_suspect_is_one_more_unknown(self) -> None:
        """A mass that is off: named with the chi-square and the freedom that freeing it gives."""
        modes = plain(5)
        wrong = nominal(PAPER).with_parameters(masses={"chassis": 0.97 * PAPER.masses["chassis"]})
        suspect = remark(reconstruct(modes, wrong), Suspect.MASS)
        freed = reconstruct(modes, wrong, free_masses=["chassis"])
        assert suspect.numbers["freedom"] == freed.freedom
        assert suspect.numbers["chi_square"] == pytest.approx(freed.chi_square, rel=0.01), "to first order at its end"
        assert suspect.numbers["error"] == pytest.approx(
            freed.suspension.masses["chassis"] / wrong.masses["chassis"] - 1, rel=0.01
        )

    def test_a_suspect_is_judged_without_its_degree_of_freedom(self) -> None:
        """A chi-square that only one more degree of freedom would excuse excuses nobody."""
        modes = plain(5)
        wrong = nominal(PAPER).with_parameters(masses={"chassis": 0.97 * PAPER.masses["chassis"]})
        freed = reconstruct(modes, wrong, free_masses=["chassis"])
        assert freed.chi_square is not None
        few, more = (float(chdtri(freed.freedom + given_back, UNLIKELY)) for given_back in (0, 1))
        for left, named in ((0.5 * few + 0.5 * more, False), (0.9 * few, True)):
            found = reconstruct(scaled(modes, freed.chi_square / left), wrong)
            names = {r.numbers["name"] for r in found.remarks if r.code is Suspect.MASS}
            assert ("chassis" in names) == named, left


class TestVerdict:
    def test_all_is_well(self) -> None:
        found = reconstruct(plain(6), nominal(PAPER))
        assert found.verdict.level is Level.SOUND
        assert checks(found)[ReconstructionCheck.EXPLAINS] is Level.SOUND
        assert checks(found)[ReconstructionCheck.NO_ALTERNATIVES] is Level.SOUND
        assert str(found.verdict) in str(found)

    def test_a_fit_that_is_not_tested_speaks_for_nothing(self) -> None:
        """As many unknowns as equations, or no uncertainty at all: no support from the fit."""
        poles = ModalSet(poles=eigenmodes(PAPER).poles)
        found = checks(reconstruct(poles, nominal(PAPER)))
        assert found[ReconstructionCheck.NOT_JUDGED] is Level.NOTE
        assert found[ReconstructionCheck.NO_UNCERTAINTY] is Level.NOTE
        assert ReconstructionCheck.EXPLAINS not in found

    def test_a_topology_that_does_not_explain(self) -> None:
        found = reconstruct(plain(1, with_sky()), nominal(PAPER))
        assert found.verdict.level is Level.CARE
        assert ReconstructionCheck.UNEXPLAINED in checks(found)

    @pytest.mark.parametrize(("masses", "springs", "doubted"), [(1e-3, 1, True), (1, 1e-3, True), (1, 3, False)])
    def test_units_that_are_off_by_a_thousand(self, masses: float, springs: float, doubted: bool) -> None:
        """Springs are in proportion to the masses: tonnes taken for kilograms divide them by 1000."""
        struts = [replace(one, stiffness=springs * one.stiffness) for one in nominal(PAPER).struts]
        car = replace(nominal(PAPER), masses={k: masses * m for k, m in PAPER.masses.items()}, struts=tuple(struts))
        found = reconstruct(plain(6), car)
        assert (checks(found).get(ReconstructionCheck.OTHER_UNITS) is Level.DOUBTFUL) == doubted
        assert ("in kg (1 t is 1000 kg)" in str(found)) == doubted

    def test_alternatives(self) -> None:
        found = reconstruct(ModalSet(poles=eigenmodes(HATCHBACK).poles), nominal(HATCHBACK))
        (count,) = (
            c.remark.numbers["count"] for c in found.verdict.checks if c.remark.code is ReconstructionCheck.ALTERNATIVES
        )
        assert count == len(found.alternatives) == 1
        assert found.verdict.level is Level.CARE

    def test_that_none_was_looked_for_is_no_support(self) -> None:
        found = reconstruct(ModalSet(poles=eigenmodes(HATCHBACK).poles), nominal(HATCHBACK), search=False)
        assert checks(found)[ReconstructionCheck.NOT_SEARCHED] is Level.NOTE
        assert ReconstructionCheck.NO_ALTERNATIVES not in checks(found)

    def test_a_parameter_that_could_be_zero(self) -> None:
        """A tire's damper of 10 N s/m beside shapes known to 3 %: its standard deviation is larger than itself."""
        car = PAPER.with_parameters(damping={"tire": 10.0})
        modes = with_noise(eigenmodes(car), np.random.default_rng(8), spread=3e-2)
        found = reconstruct(modes, nominal(car))
        assert found.damping_std is not None
        values = {s.name: s.damping for s in found.suspension.struts}
        expected = {f"{n}.damping" for n, std in found.damping_std.items() if 0 < values[n] < 1.96 * std}
        named = [c.remark.numbers["names"] for c in found.verdict.checks if c.remark.code is ReconstructionCheck.VAGUE]
        assert set(*named) == expected if named else not expected
        assert values["tire"] == 0.0 or "tire.damping" in expected

    def test_the_status_is_the_remarks(self) -> None:
        found = reconstruct(plain(6), nominal(PAPER))
        assert found.status == "; ".join(str(r) for r in found.remarks)
        assert remark(found, ReconstructionNote.CHI_SQUARE).numbers["freedom"] == found.freedom


class TestManyParametersTogether:
    """Holm's procedure: with many parameters one is apart from nominal by chance no more often than with one."""

    @staticmethod
    def named(z: np.ndarray) -> frozenset[str]:
        def outside(level: float) -> list[str]:
            return [str(i) for i, one in enumerate(z) if abs(one) > normal_reach(level)]

        return beyond_chance(outside, len(z))

    def test_as_holm_wrote_it(self) -> None:
        rng = np.random.default_rng(5)
        for _ in range(200):
            z = rng.standard_normal(6) * 2.5
            p = 2 * ndtr(-np.abs(z))
            expected = set[str]()
            for rank, i in enumerate(np.argsort(p)):
                if p[i] > 0.05 / (6 - rank):
                    break
                expected.add(str(i))
            assert self.named(z) == expected

    def test_one_of_twelve_by_chance(self) -> None:
        rng = np.random.default_rng(6)
        false = np.mean([bool(self.named(rng.standard_normal(12))) for _ in range(2000)])
        # Binomial: 5 % of 2000 within four standard deviations; each by itself would be 46 %.
        assert 0.03 < false < 0.07
