"""Edits and documents as JSON: frozen dataclasses by their field names, an edit tagged with its name."""

import dataclasses
import functools
import types
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

from fcw_viz.calibrate_app.edits import Edit

T = TypeVar("T")

EDIT_FIELD = "edit"
EDIT_TYPES: dict[str, type] = {edit.__name__: edit for edit in get_args(Edit)}


def to_json(value: Any) -> Any:  # noqa: ANN401 - JSON has no type
    """Dataclasses as objects, tuples as lists; numbers of NumPy as plain ones."""
    if dataclasses.is_dataclass(value):
        return {field.name: to_json(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, tuple | list):
        return [to_json(item) for item in value]
    return value.item() if hasattr(value, "item") else value


def from_json(kind: type[T], value: Any) -> T:  # noqa: ANN401 - JSON has no type
    """The value of a type from what `to_json` made of it.

    Raises:
        ValueError: it is not of that form.
    """
    return _decoded(kind, value)


def edit_to_json(edit: Edit) -> dict[str, Any]:
    """An edit as an object with its name."""
    return {EDIT_FIELD: type(edit).__name__, **to_json(edit)}


def edit_from_json(value: dict[str, Any]) -> Edit:
    """The edit.

    Raises:
        ValueError: there is no such edit, or its fields are not as expected.
    """
    fields = dict(value)
    name = fields.pop(EDIT_FIELD, None)
    if name not in EDIT_TYPES:
        raise ValueError(f"{name!r} is no edit of this program")
    return _decoded(EDIT_TYPES[name], fields)


_hints = functools.cache(get_type_hints)


def _decoded(kind: Any, value: Any) -> Any:  # noqa: ANN401 - a type or a union of types
    origin, arguments = get_origin(kind), get_args(kind)
    if origin in (Union, types.UnionType):
        # Only "something or None" occurs.
        (inner,) = (argument for argument in arguments if argument is not type(None))
        return None if value is None else _decoded(inner, value)
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
        return kind(**{name: _decoded(hints[name], item) for name, item in value.items()})  # pyright: ignore[reportCallIssue]
    if kind is float and isinstance(value, int | float) and not isinstance(value, bool):
        return float(value)
    if type(value) is not kind:
        raise ValueError(f"{value!r} is not of type {kind.__name__}")
    return value
