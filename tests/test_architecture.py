"""What may import what: layers, no circles, small rooms. Imports in functions and for types count too."""

import ast
from collections import Counter
from collections.abc import Mapping
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

ROOT = Path(__file__).parents[1]
LAYERS = (
    "errors units bounded clock files json_form locked_file threads frame box versions charts",
    "kernels",
    "camera",
    "detection",
    "motion",
    "self_calibration",
    "tracking",
    "threat",
    "warning",
    "logs",
    "sources",
    "pipeline summary job",
    "pieces",
    "simulation",
    "evaluation",
    "annotation",
    "batch",
)
"""The rooms of `fcw` from the bottom up; each may use those of its own line and of the lines above it."""
LARGEST_ROOM = 14
LONGEST_MODULE = 400


@cache
def modules() -> dict[str, Path]:
    paths = {path for package in ("fcw", "fcw_viz") for path in (ROOT / package).rglob("*.py")}
    return {
        ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path
        for path in paths
    }


@cache
def imported(path: Path) -> tuple[str, ...]:
    """The names a module imports, each with its module's."""
    names: list[str] = []
    nodes: list[ast.AST] = [ast.parse(path.read_text(encoding="utf-8"))]
    while nodes:
        node = nodes.pop()
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: a relative import"
            names += [f"{node.module}.{alias.name}" for alias in node.names]
        # Imports stand in blocks, never in expressions, which are most of a file.
        for block in ("body", "orelse", "handlers", "finalbody", "cases"):
            nodes += [inner for inner in getattr(node, block, ()) if not isinstance(inner, ast.Expr)]
    return tuple(names)


@cache
def dependencies() -> dict[str, set[str]]:
    """For every module of the program those that it imports."""
    paths = modules()
    graph: dict[str, set[str]] = {}
    for module, path in paths.items():
        graph[module] = set()
        for name in imported(path):
            while name and name not in paths:  # what is imported may be a name within a module
                name = name.rpartition(".")[0]
            graph[module] |= {name} - {module, ""}
    return graph


def room(module: str) -> str:
    """The package's folder or module that a module is in, e.g. `fcw.camera`."""
    return ".".join(module.split(".")[:2])


def circle(graph: Mapping[str, set[str]]) -> list[str]:
    """One circle, if there is any."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return error.args[1]
    return []


def test_no_modules_import_each_other_in_a_circle():
    assert circle(dependencies()) == []


def test_no_rooms_import_each_other_in_a_circle():
    rooms: dict[str, set[str]] = {}
    for module, others in dependencies().items():
        rooms.setdefault(room(module), set()).update({room(other) for other in others} - {room(module)})
    assert circle(rooms) == []


def test_every_room_of_the_library_uses_those_below_it_alone():
    height = {f"fcw.{name}": layer for layer, names in enumerate(LAYERS) for name in names.split()}
    height["fcw"] = len(LAYERS)  # the public face, which everything else does without
    graph = dependencies()
    assert {room(module) for module in graph if module.startswith("fcw.")} <= height.keys()
    upwards = [
        f"{module} imports {other}"
        for module, others in graph.items()
        if room(module) in height
        for other in others
        if height.get(room(other), len(height)) > height[room(module)]
    ]
    assert upwards == []


def test_the_library_never_imports_the_application():
    assert [
        f"{module} imports {name}"
        for module, path in modules().items()
        if room(module).split(".")[0] == "fcw"
        for name in imported(path)
        if name.split(".")[0] == "fcw_viz"
    ] == []


def own_files() -> list[Path]:
    folders = ("fcw", "fcw_viz", "tests", "examples", "benchmarks", "docs")
    return [path for folder in folders for path in sorted((ROOT / folder).rglob("*.py"))]


def test_no_folder_holds_more_modules_than_one_can_take_in():
    sizes = Counter(path.parent.relative_to(ROOT).as_posix() for path in own_files())
    assert {folder: size for folder, size in sizes.items() if size > LARGEST_ROOM} == {}


def test_no_module_is_longer_than_fits_in_a_head():
    lines = {
        path.relative_to(ROOT).as_posix(): len(path.read_text(encoding="utf-8").splitlines())
        for path in own_files()
        if not path.name.endswith("_pb2.py")  # generated
    }
    assert {path: count for path, count in lines.items() if count > LONGEST_MODULE} == {}
