"""YAML into frozen dataclasses: the annotations are the schema, and what is wrong is named."""

import dataclasses
import types
import typing
from collections.abc import Mapping
from enum import Enum
from typing import Any, TypeVar

from fcw.errors import UserError

T = TypeVar("T")

LARGEST_NUMBER = 1e6
"""Of metres, seconds, pixels: larger ones are slips, and end in overflows."""
LONGEST_LIST = 200


def read_dataclass(cls: type[T], values: object, name: str, path: str = "") -> T:
    """A dataclass from what YAML gave for it.

    Fields may be float, int, str, bool, an Enum by value, a dataclass, `X | None`, or `tuple[X, ...]`.
    A field without a default must be there, and an unknown one is a mistake. A ValueError from the
    dataclass's own checks becomes a UserError that says where.

    Args:
        cls: the dataclass.
        values: what YAML gave.
        name: of the file, for messages.
        path: where in the file, for messages.

    Raises:
        UserError: naming file, field, value and what was expected.
    """
    if not isinstance(values, Mapping):
        raise _wrong(name, path, values, "a mapping of fields")
    hints = typing.get_type_hints(cls)
    fields = {field.name: field for field in dataclasses.fields(cls)}  # pyright: ignore[reportArgumentType]
    for key in values:
        if key not in fields:
            raise UserError(
                f"{name}: {_join(path, str(key))} is no field; expected one of {', '.join(fields)}"
            )
    given: dict[str, Any] = {}
    for key, field in fields.items():
        if key in values:
            given[key] = _value(hints[key], values[key], name, _join(path, key))
        elif field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
            raise UserError(f"{name}: {_join(path, key)} is missing; add it")
    try:
        return cls(**given)
    except ValueError as error:
        raise UserError(f"{name}: {f'{path}: ' if path else ''}{error}") from error


def _value(hint: Any, value: object, name: str, path: str) -> Any:  # noqa: ANN401 - as annotated
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin in (types.UnionType, typing.Union):
        if value is None:
            return None
        (inner,) = (argument for argument in arguments if argument is not type(None))
        return _value(inner, value, name, path)
    if origin is tuple:
        if not isinstance(value, list) or len(value) > LONGEST_LIST:
            raise _wrong(name, path, value, f"a list of at most {LONGEST_LIST}")
        return tuple(_value(arguments[0], item, name, f"{path}[{k}]") for k, item in enumerate(value))
    if dataclasses.is_dataclass(hint):
        return read_dataclass(typing.cast("type[Any]", hint), value, name, path)
    if isinstance(hint, type) and issubclass(hint, Enum):
        known = [member.value for member in hint]
        if not isinstance(value, str | int) or value not in known:
            raise _wrong(name, path, value, f"one of {', '.join(map(str, known))}")
        return hint(value)
    if hint is float:
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= LARGEST_NUMBER:
            raise _wrong(name, path, value, f"a finite number of at most {LARGEST_NUMBER:g}")
        return float(value)
    expected = {int: "a whole number", str: "a text", bool: "true or false"}
    if hint not in expected:
        raise TypeError(f"no reading of {hint} for {path}")
    # A bool is an int to Python, not to a person.
    if not isinstance(value, hint) or (hint is int and isinstance(value, bool)):
        raise _wrong(name, path, value, expected[hint])
    return value


def _wrong(name: str, path: str, value: object, expected: str) -> UserError:
    return UserError(f"{name}: {path or 'the file'} is {repr(value)[:80]}, expected {expected}")


def _join(path: str, key: str) -> str:
    return f"{path}.{key}" if path else key
