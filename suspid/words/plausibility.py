"""Codes and sentences: a car whose numbers no vehicle has, most likely because of their units."""

from __future__ import annotations

from suspid.words.remarks import Code, sentence


def _metres(value: float) -> str:
    return f"{1e3 * value:.3g} mm" if value < 1 else f"{value:.3g} m"


class PlausibilityCheck(Code):
    """Doubts about the numbers of a car."""

    SINKS = (
        "sinks",
        sentence(
            lambda n: (
                f"{n['part']}: its load of {n['load']:.3g} N compresses it by {_metres(n['metres'])}, more than the "
                f"{_metres(n['limit'])} that any vehicle has: check whether stiffness is in N/mm or kN/m (1 N/mm is "
                f"1000 N/m), or masses in g."
            )
        ),
    )
    RIGID = (
        "rigid",
        sentence(
            lambda n: (
                f"{n['part']}: its load of {n['load']:.3g} N compresses it by {_metres(n['metres'])} only, less than "
                f"the {_metres(n['limit'])} that any vehicle has: check whether masses are in t (1 t is 1000 kg), "
                f"or stiffness in N/m."
            )
        ),
    )
    UNDAMPED = (
        "hardly damped",
        "No mode has a damping ratio above {zeta:.2g}, while rubber alone gives {limit:.2g}: check whether damping is "
        "in N s/mm (1 N s/mm is 1000 N s/m).",
    )
    LOAD = (
        "weighed load",
        "{wheel}: the load of {given:.4g} N is {factor:.3g} times that of the masses, {load:.4g} N: check the load and "
        "whether it is in N.",
    )
