"""Convexity of the constraints and penalties that a user wrote, and what is wrong if they are not convex."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

from suspid.errors import InputError

# Of k and of c by strut name, cvxpy expressions in N/m and N s/m.
ByStrut: TypeAlias = Mapping[str, Any]
Maker: TypeAlias = Callable[[ByStrut, ByStrut], Any]


def called(maker: Maker, k: ByStrut, c: ByStrut) -> Any:
    """Return what a function of the user makes of k and c."""
    try:
        return maker(k, c)
    except KeyError as error:
        raise InputError(f"constraints: there is no strut {error}. Known: {', '.join(k)}") from None
    except NotImplementedError as error:  # cvxpy's, for < and >
        raise InputError(f"constraints: {error}") from None


def constraint(maker: Maker, k: ByStrut, c: ByStrut, text: str, number: int) -> Any:
    """Return the constraint that a function makes."""
    made = called(maker, k, c)
    if not hasattr(made, "is_dcp") or not hasattr(made, "args") or hasattr(made, "curvature"):
        raise InputError(
            f"constraint {number} ({text or made!r}) is not a cvxpy constraint; write one with <=, >= or == in k and c"
        )
    return made


def check(made: Any, where: str, own: Sequence[Any]) -> None:
    """Raise if a constraint or a penalty is not convex, or has variables that are not k and c."""
    foreign = {v.id for v in made.variables()} - {v.id for one in own for v in one.variables()}
    if foreign:
        raise InputError(f"{where} uses a variable of its own; write it in k and c alone")
    if made.parameters():
        raise InputError(f"{where} uses a cvxpy Parameter; put its value there")
    if made.is_dcp():
        return
    if hasattr(made, "curvature"):
        raise InputError(f"{where} is not convex: it is {_curvature(made)}")
    kinds = [_curvature(side) for side in made.args]
    needed = "both sides must be linear" if is_equation(made) else "the lower side must be convex, the upper concave"
    raise InputError(f"{where} is not convex: {needed}, but they are {' and '.join(kinds)}")


def check_penalty(penalty: Maker, k: ByStrut, c: ByStrut) -> None:
    """Raise if a penalty is no single convex term that is never negative."""
    term = called(penalty, k, c)
    if not hasattr(term, "curvature") or term.size != 1:
        raise InputError(
            f"penalty: {term!r} is not a scalar cvxpy expression; return one term in k and c, such as a cp.norm1"
        )
    check(term, f"penalty ({term})", [*k.values(), *c.values()])
    if not term.is_convex():
        raise InputError(f"penalty ({term}) is not convex: it is {_curvature(term)}")
    if not term.is_nonneg():
        raise InputError(f"penalty ({term}) must be a term that is never negative, such as a sum of absolute values")


def _curvature(made: Any) -> str:
    """Return the curvature of an expression in words."""
    return (
        "neither convex nor concave as far as cvxpy can tell" if made.curvature == "UNKNOWN" else made.curvature.lower()
    )


def is_equation(made: Any) -> bool:
    """Return whether a constraint is an equation."""
    return type(made).__name__ in ("Equality", "Zero")
