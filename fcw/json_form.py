"""Frozen dataclasses as JSON, by their field names; one of several kinds is tagged with its name."""

import dataclasses
import functools
import math
import types
from collections.abc import Mapping, Sequence
from enum import Enum
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

from fcw.bounded.formats import json_value

T = TypeVar("T")


def to_json(value: Any) -> Any:  # noqa: ANN401 - JSON has no type
    """Dataclasses as objects, tuples as lists, enums by name; numbers of NumPy as plain ones."""
    if dataclasses.is_dataclass(value):
        return {field.name: to_json(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, tuple | list):
        return [to_json(item) for item in value]
    if isinstance(value, Enum):
        return value.name.lower()
    return value.item() if hasattr(value, "item") else value


def from_json(kind: type[T], value: Any) -> T:  # noqa: ANN401 - JSON has no type
    """The value of a type from what `to_json` made of it.

    Raises:
        ValueError: it is not of that form.
    """
    return _decoded(kind, value)


def without_non_finite(value: Any) -> Any:  # noqa: ANN401 - JSON has no type
    """A JSON value with None for NaN and infinities, which JSON does not know."""
    if isinstance(value, Mapping):
        return {key: without_non_finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [without_non_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def object_of_line(line: bytes) -> dict[str, Any] | None:
    """The JSON object that a line of a file holds; None where it holds anything else."""
    try:
        value = json_value(line.decode())
    except ValueError:
        return None
    return value if isinstance(value, dict) else None


def tagged_to_json(value: Any, tag: str) -> dict[str, Any]:  # noqa: ANN401 - any dataclass
    """A dataclass as an object that says in the field `tag` which one it is."""
    return {tag: type(value).__name__, **to_json(value)}


def tagged_from_json(kinds: Sequence[type[T]], value: dict[str, Any], tag: str) -> T:
    """The value of one of several dataclasses from what `tagged_to_json` made of it.

    Raises:
        ValueError: it is none of these, or its fields are not as expected.
    """
    fields = dict(value)
    name = fields.pop(tag, None)
    for kind in kinds:
        if kind.__name__ == name:
            return _decoded(kind, fields)
    raise ValueError(f"{name!r} is no {tag} of this program")


_hints = functools.cache(get_type_hints)


def _decoded(kind: Any, value: Any) -> Any:  # noqa: ANN401 - a type or a union of types
    origin, arguments = get_origin(kind), get_args(kind)
    if origin in (Union, types.UnionType):
        # Only "something or None" occurs.
        (inner,) = (argument for argument in arguments if argument is not type(None))
        return None if value is None else _decoded(inner, value)
    if origin is Literal:
        if value not in arguments:
            raise ValueError(f"{value!r} is none of {', '.join(map(str, arguments))}")
        return value
    if origin is tuple:
        if not isinstance(value, list):
            raise ValueError(f"{value!r} is not a list")
        if arguments[-1] is Ellipsis:
            return tuple(_decoded(arguments[0], item) for item in value)
        return tuple(_decoded(inner, item) for inner, item in zip(arguments, value, strict=True))
    if dataclasses.is_dataclass(kind):
        if not isinstance(value, dict):
            raise ValueError(f"{value!r} is not an object")
        hints = _hints(kind)
        if unknown := set(value) - set(hints):
            raise ValueError(f"unknown fields {', '.join(sorted(unknown))}")
        fields = {name: _decoded(hints[name], item) for name, item in value.items()}
        try:
            return kind(**fields)  # pyright: ignore[reportCallIssue]
        except TypeError as error:
            raise ValueError(str(error)) from None
    if issubclass(kind, Enum):
        names = {member.name.lower(): member for member in kind}
        if not (isinstance(value, str) and value in names):
            raise ValueError(f"{value!r} is none of {', '.join(names)}")
        return names[value]
    if kind is float and isinstance(value, int | float) and not isinstance(value, bool):
        return float(value)
    if type(value) is not kind:
        raise ValueError(f"{value!r} is not of type {kind.__name__}")
    return value
