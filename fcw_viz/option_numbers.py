"""A number on the command line: finite, with a point, or one message that names the option."""

import math
from typing import Annotated, Any

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


def number_option(field: str, kind: Any) -> Any:  # noqa: ANN401 - a type, however it is annotated
    """The type of an option that takes a number, so that tyro reads it by `number`."""
    option = "--" + field.replace("_", "-")

    def one(texts: list[str]) -> float:
        return number(option, texts[0])

    spec = PrimitiveConstructorSpec(
        nargs=1,
        metavar="FLOAT",
        instance_from_str=one,
        is_instance=lambda value: value is None or isinstance(value, (int, float)),
        str_from_instance=lambda value: [str(value)],
    )
    return Annotated[kind, spec]
