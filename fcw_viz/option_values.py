"""Numbers, pairs and paths on the command line: one message with option, value and what is expected."""

import math
from collections.abc import Callable
from pathlib import Path
from types import NoneType
from typing import Annotated, Any, Literal, get_args, get_origin

import tyro
from tyro.constructors import PrimitiveConstructorSpec

from fcw.errors import UserError
from fcw.units import DECIMAL_COMMA


def number(option: str, text: str) -> float:
    """The number that somebody typed for an option.

    Raises:
        UserError: it is none, or not a finite one.
    """
    if DECIMAL_COMMA.fullmatch(text):
        raise UserError(f"{option} {text}: expected a number with a point: {text.replace(',', '.')}")
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise UserError(f"{option} {text:.60}: expected a finite number, such as 1.2")
    return value


def whole_number(option: str, text: str) -> int:
    """The whole number that somebody typed for an option.

    Raises:
        UserError: it is none.
    """
    try:
        return int(text)
    except ValueError:
        raise UserError(f"{option} {text:.60}: expected a whole number, such as 2") from None


def path_of(option: str, text: str) -> Path:
    """The path that somebody typed for an option.

    Raises:
        UserError: it is empty, as of a variable that is not set and would be the current folder; or `-`.
    """
    if not text:
        raise UserError(f'{option} "": expected a file or folder; the current folder is .')
    if text == "-":
        raise UserError(
            f"{option} -: standard input and output are not supported; expected a file or folder (./- is a "
            "file named -)"
        )
    return Path(text)


def typed_option(field: str, bare: Any, kind: Any) -> Any:  # noqa: ANN401 - types, however they are annotated
    """The type of an option, so that tyro, which would tell of Python's types, reads it by us.

    Args:
        field: of the option, as the command has it.
        bare: its type without annotations.
        kind: its type with them.
    """
    option = "--" + field.replace("_", "-")
    some = next((one for one in get_args(bare) if NoneType in get_args(bare) and one is not NoneType), bare)
    parts = get_args(some) if get_origin(some) is tuple else ()
    if some is float:
        return _read(kind, 1, "FLOAT", lambda texts: number(option, texts[0]))
    if some is int:
        return _read(kind, 1, "INT", lambda texts: whole_number(option, texts[0]))
    if some is Path and tyro.conf.Positional not in getattr(kind, "__metadata__", ()):
        return _read(kind, 1, "PATH", lambda texts: path_of(option, texts[0]))
    if parts == (float, ...):
        return _read(kind, "*", "FLOAT ...", lambda texts: tuple(number(option, text) for text in texts))
    if parts == (float, float):
        return _read(kind, "*", "FLOAT FLOAT", lambda texts: _two_numbers(option, texts))
    if len(parts) == 2 and get_origin(parts[0]) is Literal and parts[1] is Path:
        return _read(kind, "*", "NAME FILE", lambda texts: _named_file(option, texts, get_args(parts[0])))
    return kind


def _two_numbers(option: str, texts: list[str]) -> tuple[float, float]:
    if len(texts) != 2:
        raise UserError(f"{' '.join((option, *texts)):.80}: expected two numbers, such as {option} 1.5 4")
    return number(option, texts[0]), number(option, texts[1])


def _named_file(option: str, texts: list[str], names: tuple[str, ...]) -> tuple[str, Path]:
    if len(texts) != 2 or texts[0] not in names:
        raise UserError(
            f"{' '.join((option, *texts)):.80}: expected {' or '.join(names)}, and the file to write, "
            f"such as {option} {names[0]} {names[0]}.yaml"
        )
    return texts[0], path_of(f"{option} {texts[0]}", texts[1])


def _read(
    kind: Any,  # noqa: ANN401 - a type, however it is annotated
    count: int | Literal["*"],
    metavar: str,
    read: Callable[[list[str]], Any],
) -> Any:  # noqa: ANN401
    """The type, read from so many texts."""
    spec = PrimitiveConstructorSpec(
        nargs=count,
        metavar=metavar,
        instance_from_str=read,
        is_instance=lambda value: True,  # defaults are the commands' own, which pyright has looked at
        str_from_instance=lambda value: [*map(str, value)] if isinstance(value, tuple) else [str(value)],
    )
    return Annotated[kind, spec]
