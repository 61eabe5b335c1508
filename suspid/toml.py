"""Files in TOML: parsed, and each value checked by name."""

from __future__ import annotations

import reprlib
import tomllib
from collections.abc import Collection
from typing import NoReturn

from suspid.errors import InputError
from suspid.files import parsed_json, printable
from suspid.values import nearest_names

# What suspid wrote as JSON, and what to give where TOML is needed.
OF_SUSPID = {
    "suspid modes": "it is JSON with modes, which `suspid compare` and `suspid reconstruct` take, and no description",
    "suspid car": "it is JSON of `suspid reconstruct`, whose option -o car.toml writes the car",
    "suspid estimate": "it is JSON of `suspid estimate`, whose option -o car.toml writes the car",
    "suspid drive": "it is JSON of `suspid drive`, whose option -o car.toml writes the car",
}


def parsed_toml(text: str) -> dict[str, object]:
    """Return the content of a TOML text; raise an `InputError` with the line where it is not TOML."""
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        why = printable(str(error))
        if text.lstrip().startswith("{"):
            why = _json_instead(text)
        raise InputError(
            f"is not TOML: {why}; examples/car.toml and examples/limits.toml show the form, such as damping = 300"
        ) from None


def _json_instead(text: str) -> str:
    """Return what a text is that begins as JSON does."""
    try:
        content = parsed_json(text)
    except InputError as error:
        return f"it begins like JSON, and as JSON it {error.message}"
    form = str(content.get("format"))
    known = next((what for start, what in OF_SUSPID.items() if form.startswith(start)), "")
    return known or "it is JSON; name it .json where that is taken"


def as_table(where: str, value: object) -> dict[str, object]:
    """Return a table, or refuse what is none."""
    return value if isinstance(value, dict) else refuse(f"{where} must be a table, not {reprlib.repr(value)}")


def as_number(where: str, key: str, value: object, unit: str) -> float:
    """Return a number in a unit, or refuse what is none."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        refuse(f"{where}: {key} = {reprlib.repr(value)} must be a number in {unit}")
    try:
        return float(value)
    except OverflowError:
        refuse(f"{where}: {key} is too large for a number in {unit}")


def check_keys(where: str, given: Collection[str], known: Collection[str]) -> None:
    """Refuse a key that is not known; the message names the nearest."""
    for key in given:
        if key not in known:
            raise InputError(f"{where} has an unknown key {key!r}.{nearest_names(key, known)}")


def refuse(message: str) -> NoReturn:
    """Refuse a file: raise an `InputError`."""
    raise InputError(message)
