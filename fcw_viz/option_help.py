"""How `--help` words the options: each docstring as running text, and no default that says nothing."""

import ast
import inspect
from dataclasses import MISSING, fields, is_dataclass
from functools import cache, partial
from itertools import pairwise
from textwrap import dedent
from typing import Annotated, Any, get_type_hints

import tyro
from tyro.constructors import ConstructorRegistry, StructConstructorSpec, StructFieldSpec, StructTypeInfo

from fcw_viz.option_values import typed_option

COMMANDS = "fcw_viz.commands."
SAYS_NOTHING = (None, False, ())
"""Defaults that an option's text tells, or that mean that it is not given."""

registry = ConstructorRegistry()


@registry.struct_rule
def command_rule(info: StructTypeInfo) -> StructConstructorSpec | None:
    """The options of a command; tyro's own rule breaks their texts wherever the source does."""
    if not (is_dataclass(info.type) and info.type.__module__.startswith(COMMANDS)):
        return None
    types, bare = get_type_hints(info.type, include_extras=True), get_type_hints(info.type)
    specs: list[StructFieldSpec] = []
    for one in fields(info.type):
        kind: Any = typed_option(one.name, bare[one.name], types[one.name])
        default = tyro.MISSING if one.default is MISSING else one.default
        if default is tyro.MISSING:
            kind = Annotated[kind, tyro.conf.arg(help_behavior_hint="(required)")]
        elif any(default is nothing for nothing in SAYS_NOTHING):
            kind = Annotated[kind, tyro.conf.arg(help_behavior_hint="")]
        specs.append(StructFieldSpec(one.name, kind, default, partial(_text, info.type, one.name)))
    return StructConstructorSpec(info.type, tuple(specs))


def _text(command: type, option: str) -> str | None:
    return _texts(command).get(option)


@cache
def _texts(command: type) -> dict[str, str]:
    """By option what the docstring below it says."""
    (definition,) = ast.parse(dedent(inspect.getsource(command))).body
    assert isinstance(definition, ast.ClassDef)
    return {
        option.id: " ".join(text.split())
        for field, below in pairwise(definition.body)
        if isinstance(field, ast.AnnAssign) and isinstance(option := field.target, ast.Name)
        if isinstance(below, ast.Expr) and isinstance(below.value, ast.Constant)
        if isinstance(text := below.value.value, str)
    }
