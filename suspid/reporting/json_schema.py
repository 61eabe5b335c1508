"""The JSON Schemas of what `report_to_dict` and the other functions of its kind return."""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Literal


def json_schema(name: Literal["report", "estimate", "drive", "compare", "damper"]) -> dict[str, object]:
    """Return the JSON Schema (draft 2020-12) of one kind of result: every field with its unit.

    Examples
    --------
    >>> json_schema("estimate")["title"]
    'suspid estimate'
    """
    text = files("suspid.reporting").joinpath("schemas", f"{name}.schema.json").read_text(encoding="utf-8")
    schema: dict[str, object] = json.loads(text)
    return schema
