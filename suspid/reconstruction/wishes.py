"""Constraints and penalties of the user: convex expressions in k and c, as rows in the dimensionless unknowns."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from suspid.errors import InputError
from suspid.reconstruction.convexity import ByStrut, Maker, called, check, check_penalty, constraint, is_equation
from suspid.reconstruction.programs import OPTIMAL, Program, build
from suspid.reconstruction.texts import constraint_of
from suspid.reconstruction.unknowns import Unknowns, parameter_names
from suspid.units import RealArray

Constraints: TypeAlias = str | Maker | Sequence[str | Maker]


@dataclass(frozen=True, kw_only=True, eq=False)
class Wishes:
    """Constraints and a penalty, checked to be convex."""

    labels: tuple[str, ...]  # the constraints as text, in the order given
    matrix: RealArray  # (row, unknown), rows of unit length: matrix @ x <= limit, with equality where `equal`
    limit: RealArray
    equal: NDArray[np.bool_]
    owner: NDArray[np.intp]  # which constraint each row belongs to
    curved: tuple[int, ...]  # the constraints that are convex and not linear
    makers: tuple[Maker, ...]  # all constraints, as functions of k and c
    penalty: Maker | None
    unknowns: Unknowns

    @property
    def linear(self) -> bool:
        """Whether there is nothing but linear constraints."""
        return not self.curved and self.penalty is None

    def penalised(self, x: RealArray) -> float:
        """Return the penalty at x."""
        if self.penalty is None:
            return 0.0
        return float(self.penalty(*constants(self.unknowns, x)).value)

    def violation(self, x: RealArray) -> float:
        """Return the largest violation of a constraint, in units of the unknowns where it is linear."""
        off = self.matrix @ x - self.limit
        worst = float(np.max(np.where(self.equal, np.abs(off), off), initial=0.0))
        made = constants(self.unknowns, x)
        for i in self.curved:
            left, right = sides(self.makers[i](*made))
            worst = max(worst, float(np.max(left - right)) / max(1.0, float(np.max(np.abs(right)))))
        return worst

    def acting(self, x: RealArray) -> list[int]:
        """Return which constraints hold with equality at x."""
        rows = self.equal | (self.matrix @ x - self.limit > -OPTIMAL)
        found = {int(i) for i in self.owner[rows]}
        made = constants(self.unknowns, x)
        for i in self.curved:
            left, right = sides(self.makers[i](*made))
            if float(np.max(left - right)) > -OPTIMAL * max(1.0, float(np.max(np.abs(right)))):
                found.add(i)
        return sorted(found)

    def terms(self, p: Any, chosen: Collection[int] | None = None) -> tuple[list[Any], Any]:
        """Return the constraints that are not linear (those chosen), and the penalty, of parameters p."""
        import cvxpy

        cp: Any = cvxpy
        u = self.unknowns
        names = enumerate(parameter_names(u.car))
        made = by_strut(u, {name: p[i] if name in u.names else cp.Constant(u.base[i]) for i, name in names})
        wanted = [i for i in self.curved if chosen is None or i in chosen]
        return [self.makers[i](*made) for i in wanted], None if self.penalty is None else self.penalty(*made)

    @cached_property
    def program(self) -> Program:
        """The program with all constraints and the penalty, compiled."""
        rows = int(np.sum(self.equal)), int(np.sum(~self.equal))
        return build(len(self.unknowns), *rows, parameters=len(self.unknowns.base), terms=self.terms)

    @cached_property
    def nearest(self) -> Program:
        """The same without the penalty."""
        rows = int(np.sum(self.equal)), int(np.sum(~self.equal))
        return build(
            len(self.unknowns), *rows, parameters=len(self.unknowns.base), terms=lambda p: (self.terms(p)[0], None)
        )

    def acting_rows(self, x: RealArray) -> RealArray:
        """Return the linear rows that hold with equality at x, (row, unknown)."""
        return self.matrix[self.equal | (self.matrix @ x - self.limit > -OPTIMAL)]

    @property
    def equations(self) -> RealArray:
        """The rows that always hold with equality, (row, unknown)."""
        return self.matrix[self.equal]


def wishes_of(constraints: Constraints | None, penalty: Maker | None, unknowns: Unknowns) -> Wishes | None:
    """Return the user's constraints and penalty, checked; None if there are none."""
    given: Sequence[Any] = [constraints] if isinstance(constraints, str) or callable(constraints) else constraints or []
    if not given and penalty is None:
        return None
    k, c = variables(unknowns)
    makers: list[Maker] = []
    labels: list[str] = []
    rows: list[tuple[RealArray, float, bool, int]] = []
    curved: list[int] = []
    for one in given:
        for maker, text in _expanded(one, unknowns, k, c):
            made, number = constraint(maker, k, c, text, len(labels) + 1), len(labels)
            labels.append(text or str(made))
            makers.append(maker)
            check(made, f"constraint {number + 1} ({labels[-1]})", [*k.values(), *c.values()])
            if made.args and all(side.is_affine() for side in made.args) and hasattr(made, "expr"):
                rows += [(*row, is_equation(made), number) for row in _rows(made.expr, unknowns, k, c)]
            elif hasattr(made, "expr") and len(made.args) == 2:
                curved.append(number)
            else:
                raise InputError(f"constraint {number + 1} ({labels[-1]}): write it with <=, >= or ==")
    if penalty is not None:
        check_penalty(penalty, k, c)
    for row, limit, equal, number in rows:
        if not np.any(row) and (abs(limit) if equal else -limit) > 1e-9:
            raise InputError(f"constraint {number + 1} ({labels[number]}) holds parameters alone, and they violate it")
    rows = [row for row in rows if np.any(row[0])]
    lengths = np.array([np.linalg.norm(row) for row, *_ in rows])
    return Wishes(
        labels=tuple(labels),
        matrix=np.array([row for row, *_ in rows]).reshape(len(rows), len(unknowns)) / lengths[:, None],
        limit=np.array([limit for _, limit, *_ in rows]) / lengths,
        equal=np.array([equal for _, _, equal, _ in rows], bool),
        owner=np.array([number for *_, number in rows], int),
        curved=tuple(curved),
        makers=tuple(makers),
        penalty=penalty,
        unknowns=unknowns,
    )


def null_space(rows: RealArray) -> RealArray:
    """Return a basis of the directions that rows leave as they are, (unknown, direction)."""
    _, values, directions = np.linalg.svd(rows, full_matrices=True)
    return np.asarray(directions[int(np.sum(values > 1e-10 * np.max(values, initial=0.0))) :].T)


def sides(made: Any) -> tuple[RealArray, RealArray]:
    """Return the values of both sides of ``left <= right``."""
    left, right = (np.asarray(side.value, float) for side in made.args)
    return left, right


def variables(unknowns: Unknowns) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return k and c by strut name: named variables in SI units, and constants for what is held."""
    import cvxpy

    cp: Any = cvxpy
    names, p = parameter_names(unknowns.car), unknowns.parameters(unknowns.nominal)
    made = {
        name: cp.Variable(name=name) if name in unknowns.names else cp.Constant(value, name)
        for name, value in zip(names, p.tolist(), strict=True)
    }
    return by_strut(unknowns, made)


def constants(unknowns: Unknowns, x: RealArray) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return k and c by strut name as cvxpy constants, at x."""
    import cvxpy

    cp: Any = cvxpy
    values = unknowns.parameters(x).tolist()
    return by_strut(unknowns, {n: cp.Constant(v) for n, v in zip(parameter_names(unknowns.car), values, strict=True)})


def by_strut(unknowns: Unknowns, made: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the stiffnesses and the dampings among parameters, by strut."""
    struts = [s.name for s in unknowns.car.struts]
    return {s: made[f"{s}.stiffness"] for s in struts}, {s: made[f"{s}.damping"] for s in struts}


def _expanded(one: Any, unknowns: Unknowns, k: ByStrut, c: ByStrut) -> list[tuple[Maker, str]]:
    """Return the constraints of a text or of a function, each as a function of its own and its text if it has one."""
    if isinstance(one, str):
        return [(constraint_of(one, [s.name for s in unknowns.car.struts]), one)]
    if not callable(one):
        raise InputError(
            f'constraints: {one!r} is neither text nor a function; write "front.stiffness >= 1.5 * rear.stiffness" '
            f"or lambda k, c: [k['front'] >= 1.5 * k['rear']]"
        )
    found = called(one, k, c)
    if not isinstance(found, list | tuple):
        return [(one, "")]
    return [(partial(_one_of, one, i), "") for i in range(len(found))]


def _one_of(maker: Maker, number: int, k: ByStrut, c: ByStrut) -> Any:
    """Return one of the constraints that a function makes."""
    return maker(k, c)[number]


def _rows(expression: Any, unknowns: Unknowns, k: ByStrut, c: ByStrut) -> list[tuple[RealArray, float]]:
    """Return the rows and limits in x of a linear expression that must be at most 0."""
    free = [v for one in (*k.values(), *c.values()) for v in one.variables()]
    place = {name: i for i, name in enumerate(parameter_names(unknowns.car))}

    def value(p: RealArray) -> RealArray:
        for variable in free:
            variable.value = p[place[variable.name()]]
        return np.atleast_1d(np.asarray(expression.value, float)).ravel()

    at_zero = value(unknowns.base)
    slope = np.stack([value(unknowns.base + column) - at_zero for column in unknowns.spread.T], axis=1)
    return [(row, -limit) for row, limit in zip(slope, at_zero.tolist(), strict=True)]
