"""What the documents point to is there: files, pictures and headings."""

import re
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement

ROOT = Path(__file__).parents[1]
DOCUMENTS = sorted(
    path
    for pattern in ("*.md", "docs/**/*.md", "recordings/*.md", "fcw/detection/weights/*.md")
    for path in ROOT.glob(pattern)
)
LINK = re.compile(r"\]\(([^()\s]+)\)")
NAMED_PATH = re.compile(r"(?<![\w/.~-])(?:fcw|fcw_viz|tests|docs|benchmarks|examples)/[\w./-]*\w")


def anchors(path: Path) -> set[str]:
    """Of the headings, as GitHub makes them."""
    headings = re.findall(r"^#+ (.+)$", path.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_every_link_leads_somewhere(document: Path):
    text = re.sub(r"```.*?```", "", document.read_text(encoding="utf-8"), flags=re.DOTALL)
    for target in LINK.findall(text):
        if target.startswith(("https://", "http://")):
            continue
        name, _, anchor = target.partition("#")
        path = (document.parent / name).resolve() if name else document
        assert path.exists(), target
        assert not anchor or anchor in anchors(path), target


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_every_file_and_folder_of_the_code_that_is_named_is_there(document: Path):
    quoted = re.findall(r"`([^`\n]+)`|^    (\S.*)$", document.read_text(encoding="utf-8"), re.MULTILINE)
    named = {path for inline, block in quoted for path in NAMED_PATH.findall(f" {inline or block}")}
    assert [path for path in sorted(named) if not (ROOT / path).exists()] == []


def test_the_readme_is_short():
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) < 150


def test_every_package_that_is_needed_is_in_the_list_of_licences_and_in_the_tested_set():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    needed = [Requirement(text) for text in project["dependencies"]]
    licences = (ROOT / "docs" / "licences.md").read_text(encoding="utf-8")
    tested = dict(re.findall(r"^([\w.-]+)==(.+)$", (ROOT / "constraints.txt").read_text(), re.MULTILINE))
    for one in needed:
        assert f"| {one.name} |" in licences
        assert one.specifier.contains(tested[one.name])
