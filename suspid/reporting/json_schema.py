"""The JSON Schemas of what `report_to_dict` and the other functions of its kind return, and what these share."""

from __future__ import annotations

import json
from collections.abc import Mapping
from importlib.resources import files
from typing import Literal

from suspid.identification import to_json


def as_plain(form: str, fields: Mapping[str, object]) -> dict[str, object]:
    """Return fields as JSON holds them, between the format of the file and the version of suspid."""
    from importlib.metadata import version

    plain: dict[str, object] = json.loads(to_json({"format": form, **fields, "suspid": version("suspid")}))
    return plain


def json_schema(
    name: Literal["report", "estimate", "drive", "compare", "damper", "ride", "grip", "tune"],
) -> dict[str, object]:
    """Return the JSON Schema (draft 2020-12) of one kind of result: every field with its unit.

    Examples
    --------
    >>> json_schema("estimate")["title"]
    'suspid estimate'
    """
    text = files("suspid.reporting").joinpath("schemas", f"{name}.schema.json").read_text(encoding="utf-8")
    schema: dict[str, object] = json.loads(text)
    return schema
