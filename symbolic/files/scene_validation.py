"""Pydantic's findings in the words of a scene file: the key, what it requires, what it received."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, TypeVar

from pydantic import ValidationError

from nonsmooth.symbolic.files.scene_values import TomlTable, keys_of, tables_in
from nonsmooth.symbolic.mechanics.units import AngleUnit
from nonsmooth.symbolic.messages import removed
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact, is_meant, requirement

QUOTED = re.compile("'([^']+)'")  # a name among those that pydantic expects
Model = TypeVar("Model", bound=TomlTable)


def validate(model: type[Model], data: object, file: str, angle_unit: AngleUnit | None = None) -> Model:
    """The data as a table; ``angle_unit`` is what the scene states for angles.

    Raises:
        SceneError: naming the first offending key; misspelt keys come before missing ones.
    """
    try:
        return model.model_validate(data, context={"angle": angle_unit})
    except ValidationError as error:
        details = error.errors(include_url=False)
        first = next((d for d in details if d["type"] == "extra_forbidden"), details[0])
        key = key_text(first["loc"])
        if first["type"] == "extra_forbidden" and key in removed.TABLES:
            without, kind = f"a scene without it: {removed.TABLES[key]}", "a key" if "." in key else "a table"
            raise SceneError(file, key, without, StatedFact(f"{kind} that was removed")) from None
        raise SceneError(file, _key(first), _expected(model, first), _received(first)) from None


def _key(detail: Any) -> str:
    """The offending key; pydantic's location in a field holds the kind as well."""
    location = detail["loc"]
    if _lacks_kind(detail):
        location = (*location, "kind")
    elif location[0] == "field":
        location = location[:1] + location[2:]
    return key_text(location)


def _received(detail: Any) -> object:
    match detail["type"]:
        case "missing":
            return StatedFact("nothing")
        case "extra_forbidden":
            return StatedFact("an unknown key")
        case _ if _lacks_kind(detail):
            return detail["input"].get("kind", StatedFact("nothing"))
    return detail["input"]


def key_text(location: tuple[int | str, ...]) -> str:
    """``wheel[2].speed``; list items are counted from 1."""
    return "".join(f"[{k + 1}]" if isinstance(k, int) else f".{k}" for k in location).removeprefix(".")


_EXPECTED = {
    "missing": "a value",
    "int_type": "an integer",
    "int_from_float": "an integer",
    "int_parsing": "an integer",
    "string_type": "a text in quotes",
    "model_type": "a table",
    "model_attributes_type": "a table",
    "bool_type": "true or false",
    "tuple_type": "a list of tables, written [[region]]",
    "list_type": "a list of tables, written [[wheel]]",
    "greater_than_equal": "an integer of at least {ge}",
    "less_than_equal": "an integer of at most {le}",
    "enum": "{expected}",
    "literal_error": "{expected}",
    "union_tag_not_found": "a table",  # of a number, which is none
}


def _lacks_kind(detail: Any) -> bool:
    """Whether a table of a field has no ``kind``, or one that there is not."""
    return detail["type"] in ("union_tag_not_found", "union_tag_invalid") and isinstance(detail["input"], Mapping)


def _expected(model: type[TomlTable], detail: Any) -> str:
    """What a pydantic error detail requires, in the words of a scene file."""
    context = detail.get("ctx", {})
    if isinstance(context.get("error"), ValueError):
        return requirement(context["error"])
    if detail["type"] == "extra_forbidden":
        keys = _keys(model, detail["loc"])
        return f"one of the keys {', '.join(keys)}{is_meant(detail['loc'][-1], keys)}"
    if _lacks_kind(detail):
        kinds = (t.model_fields["kind"].default for t in tables_in(model.model_fields["field"].annotation))
        return f"one of {', '.join(kinds)}"
    known = _EXPECTED.get(detail["type"])
    if known is None:
        return str(detail["msg"])
    return known.format(**context) + is_meant(detail["input"], QUOTED.findall(context.get("expected", "")))


def _keys(model: type[TomlTable], location: tuple[int | str, ...]) -> list[str]:
    """Keys of the table that holds the unknown key."""
    if len(location) == 1:
        return list(keys_of(model))
    tables = list(tables_in(keys_of(model)[str(location[0])].annotation))
    tagged = (t for t in tables if "kind" in t.model_fields and t.model_fields["kind"].default == location[1])
    return list(next(tagged, tables[0]).model_fields)
