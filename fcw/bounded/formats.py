"""JSON, YAML, XML and CSV of others: what is too deep, too long or refers to itself is refused.

Every function raises `MalformedError` alone, whatever the text is.
"""

import csv
import json
import re
from collections.abc import Iterator
from typing import Any
from xml.etree import ElementTree
from xml.parsers import expat

import yaml

from fcw.bounded.files import MalformedError

MOST_JSON_BYTES = 128 << 20
"""Of labels: a hundred thousand pictures' are 100 MB."""
MOST_YAML_BYTES = 256 << 10
"""PyYAML reads some 100 kB a second; calibrations and scenarios have 10 kB."""
MOST_XML_BYTES = 32 << 20
MOST_XML_TAGS = 2_000_000
"""Of openings and closings: a track with eight for each point fills the bytes allowed with 240,000 points."""
MOST_VALUES = 12_000_000
"""In one file: together they stay below 1 GB."""
DEEPEST = 50
LARGEST_WHOLE = 2**63 - 1
_MOST_DIGITS = 20


def json_value(text: str) -> Any:  # noqa: ANN401 - JSON has no type
    """What a JSON text holds."""
    if sum(map(text.count, ",[{:")) > MOST_VALUES:
        raise MalformedError(f"more than {MOST_VALUES} values")
    try:
        value = json.loads(text, parse_int=_whole)
    except RecursionError:
        raise MalformedError("nested too deeply") from None
    except ValueError as error:  # Python 3.13 goes deeper before it gives up
        raise MalformedError("nested too deeply" if _deep(text) else str(error)) from error
    if "\\u" in text or _deep(text):
        _check(value)
    return value


def yaml_value(text: str) -> Any:  # noqa: ANN401 - YAML has no type
    """What a YAML text holds, with the plain types alone; anchors, which multiply, are refused."""
    if len(text) > MOST_YAML_BYTES:
        raise MalformedError(f"larger than {MOST_YAML_BYTES >> 10} kB")
    try:
        return yaml.load(text, _BoundedLoader)
    except MalformedError:
        raise
    except RecursionError:
        raise MalformedError("nested too deeply") from None
    except (yaml.YAMLError, ValueError, OverflowError, TypeError, AttributeError, LookupError) as error:
        # PyYAML's constructors raise what Python raises for a date or number that is none.
        raise MalformedError(_of_yaml(error)) from error


def _of_yaml(error: Exception) -> str:
    """What is wrong and where, without the line of the text that PyYAML shows with a mark below."""
    if isinstance(error, yaml.MarkedYAMLError) and error.problem and error.problem_mark:
        mark = error.problem_mark
        return f"{error.problem}, line {mark.line + 1}, column {mark.column + 1}"
    return " ".join(str(error).split())


def xml_root(data: bytes) -> ElementTree.Element:
    """The root of an XML document; document types, which define entities, are refused."""
    if data.count(b"<") > MOST_XML_TAGS:
        raise MalformedError(f"more than {MOST_XML_TAGS} tags")
    depth = 0

    def start(_name: str, _attributes: object) -> None:
        nonlocal depth
        depth += 1
        if depth > DEEPEST:
            raise MalformedError("nested too deeply")

    def end(_name: str) -> None:
        nonlocal depth
        depth -= 1

    def doctype(*_: object) -> None:
        raise MalformedError("a document type is not allowed")

    parser = expat.ParserCreate()
    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(data, True)
        return ElementTree.fromstring(data)
    except MalformedError:
        raise
    except (expat.ExpatError, ElementTree.ParseError, ValueError, LookupError) as error:
        raise MalformedError(str(error)) from error


def csv_rows(text: str) -> Iterator[tuple[int, list[str]]]:
    """The rows of a CSV text that hold anything, each with the number of its last line."""
    rows = csv.reader(text.splitlines(), skipinitialspace=True)
    while True:
        try:
            row = next(rows, None)
        except csv.Error as error:
            raise MalformedError(f"line {rows.line_num}: {error}") from error
        if row is None:
            return
        if row:
            yield rows.line_num, row


def _whole(digits: str) -> int:
    if len(digits) <= _MOST_DIGITS and abs(value := int(digits)) <= LARGEST_WHOLE:
        return value
    raise MalformedError(f"{digits[:12]}... has {len(digits)} digits")


def _deep(text: str) -> bool:
    """Whether brackets may be nested deeper than allowed; strings may hold brackets too."""
    depth = 0
    for bracket in re.finditer(r"[\[{\]}]", text[: 1 << 16]):
        depth += 1 if bracket[0] in "[{" else -1
        if depth > DEEPEST:
            return True
    return False


def _check(value: object) -> None:
    """No more levels than allowed, and no half characters, which cannot be printed or written."""
    level, depth = [value], 0
    while level:
        depth += 1
        if depth > DEEPEST:
            raise MalformedError("nested too deeply")
        below: list[object] = []
        for one in level:
            if isinstance(one, dict):
                below += [*one, *one.values()]
            elif isinstance(one, list):
                below += one
            elif isinstance(one, str) and not one.isascii() and re.search("[\ud800-\udfff]", one):
                raise MalformedError("an incomplete character in a text")
        level = below


class _BoundedLoader(yaml.SafeLoader):
    """PyYAML's safe loader without anchors, depth and huge numbers."""

    _depth = 0

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        if self.check_event(yaml.AliasEvent) or getattr(self.peek_event(), "anchor", None) is not None:
            raise MalformedError("anchors are not allowed; write out the values")
        self._depth += 1
        if self._depth > DEEPEST:
            raise MalformedError("nested too deeply")
        try:
            return super().compose_node(parent, index)
        finally:
            self._depth -= 1

    def construct_yaml_int(self, node: yaml.ScalarNode) -> int:
        if len(node.value) > 3 * _MOST_DIGITS:
            raise MalformedError(f"{node.value[:12]}... has {len(node.value)} digits")
        value = super().construct_yaml_int(node)
        if abs(value) > LARGEST_WHOLE:
            raise MalformedError(f"{node.value[:12]}... has {len(node.value)} digits")
        return value


# YAML 1.2, and so every other tool, takes 1e-05 for a number; PyYAML asks for a point and a sign.
_BoundedLoader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"^[-+]?[0-9]+(?:\.[0-9]*)?[eE][-+]?[0-9]+$"), list("-+0123456789")
)
_BoundedLoader.add_constructor("tag:yaml.org,2002:int", _BoundedLoader.construct_yaml_int)
