"""Linear constraints as text, such as ``front.stiffness >= 1.5 * rear.stiffness``; nothing in it is executed."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from suspid.errors import InputError
from suspid.reconstruction.unknowns import QUANTITIES
from suspid.values import nearest_names

COMPARISONS: Mapping[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.LtE: operator.le,
    ast.GtE: operator.ge,
    ast.Eq: operator.eq,
}
OPERATIONS: Mapping[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
FORM = 'write it as "front.stiffness >= 1.5 * rear.stiffness": numbers, parameters, + - * / ( ) and one of <= >= =='


def constraint_of(text: str, struts: Sequence[str]) -> Callable[[Mapping[str, Any], Mapping[str, Any]], Any]:
    """Return a linear constraint as a function of k and c by strut name.

    Its parameters are ``strut.stiffness`` [N/m] and ``strut.damping`` [N s/m]; a strut whose name is no plain word
    stands in quotes: ``"front left.stiffness" <= 3e4``.

    Examples
    --------
    >>> made = constraint_of("front.stiffness >= 1.5 * rear.stiffness", ["front", "rear"])
    >>> made({"front": 30e3, "rear": 25e3}, {"front": 0.0, "rear": 0.0})
    False
    """
    where = f"constraint {text!r}"
    try:
        # Longer texts are refused: their trees would fill the memory.
        tree = ast.parse(text.strip() if len(text) <= 1000 else "", mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise InputError(f"{where} cannot be read; {FORM}") from None
    if not isinstance(tree, ast.Compare) or len(tree.ops) != 1 or type(tree.ops[0]) not in COMPARISONS:
        raise InputError(f"{where} is not a single comparison; {FORM}")
    sides = tree.left, tree.comparators[0]
    degrees = [_degree(side, struts, where) for side in sides]
    if not any(degrees):
        raise InputError(f"{where} contains no parameter; {FORM}")
    compare = COMPARISONS[type(tree.ops[0])]

    def made(k: Mapping[str, Any], c: Mapping[str, Any]) -> Any:
        return compare(_value(sides[0], k, c), _value(sides[1], k, c))

    return made


def _degree(node: ast.expr, struts: Sequence[str], where: str) -> int:
    """Return 1 if there is a parameter below the node, else 0; raise if it is not linear."""
    if isinstance(node, ast.Constant) and isinstance(node.value, int | float) and not isinstance(node.value, bool):
        return 0
    name = _name(node)
    if name is not None:
        strut, _, quantity = name.rpartition(".")
        known = [f"{s}.{q}" for s in struts for q in QUANTITIES]
        if quantity not in QUANTITIES or strut not in struts:
            raise InputError(f"{where}: there is no parameter {name!r}.{nearest_names(name, known)}")
        return 1
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.UAdd):
        return _degree(node.operand, struts, where)
    if isinstance(node, ast.BinOp) and type(node.op) in OPERATIONS:
        left, right = _degree(node.left, struts, where), _degree(node.right, struts, where)
        if isinstance(node.op, ast.Div) and not right and _value(node.right, {}, {}) == 0:
            raise InputError(f"{where} divides by zero")
        if (isinstance(node.op, ast.Mult) and left + right > 1) or (isinstance(node.op, ast.Div) and right):
            raise InputError(f"{where} is not linear: {ast.unparse(node)!r} multiplies or divides by a parameter")
        return max(left, right)
    raise InputError(f"{where}: {ast.unparse(node)!r} has no place in it; {FORM}")


def _name(node: ast.expr) -> str | None:
    """Return the name of the parameter that a node is, if it is one."""
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
        return f"{node.value.id}.{node.attr}"
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else None


def _value(node: ast.expr, k: Mapping[str, Any], c: Mapping[str, Any]) -> Any:
    """Return a side of the comparison, which has been checked."""
    name = _name(node)
    if name is not None:
        strut, _, quantity = name.rpartition(".")
        return k[strut] if quantity == "stiffness" else c[strut]
    if isinstance(node, ast.BinOp):
        return OPERATIONS[type(node.op)](_value(node.left, k, c), _value(node.right, k, c))
    if isinstance(node, ast.UnaryOp):
        value = _value(node.operand, k, c)
        return -value if isinstance(node.op, ast.USub) else value
    assert isinstance(node, ast.Constant)
    return node.value
