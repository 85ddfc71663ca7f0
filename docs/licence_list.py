"""Writes `docs/licences.md`: the packages that installing the program brings, and their licences.

    python docs/licence_list.py

Licences are what the metadata of each package say (Core Metadata 2.4: License-Expression, else classifiers,
else the first line of License).
"""

import argparse
from collections.abc import Iterable, Iterator, Sequence
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path

from packaging.requirements import Requirement

HEAD = """# Licences of what is installed

`pip install fcw` brings these packages; the versions are those that the list was made with
(`python docs/licence_list.py`).

| package | version | licence, as its metadata say |
| --- | --- | --- |
"""

EXTRAS = ("batch", "onnx", "parquet")
EXTRAS_HEAD = """
The extras `batch`, `onnx` and `parquet` bring these as well; `train` brings PyTorch, onnx and what they need.

| package | version | licence, as its metadata say |
| --- | --- | --- |
"""


def brought(name: str, seen: set[str], extras: Sequence[str] = ()) -> Iterator[Distribution]:
    """A package and all that it needs here."""
    try:
        found = distribution(name)
    except PackageNotFoundError:
        return
    if found.name.lower() in seen:
        return
    seen.add(found.name.lower())
    yield found
    for text in found.requires or ():
        needed = Requirement(text)
        if needed.marker is None or any(needed.marker.evaluate({"extra": one}) for one in ("", *extras)):
            yield from brought(needed.name, seen, tuple(needed.extras))


def licence(package: Distribution) -> str:
    """What a package's metadata say of its licence."""
    metadata = package.metadata
    if "License-Expression" in metadata:
        return metadata["License-Expression"]
    classifiers = [text for text in metadata.get_all("Classifier") or () if text.startswith("License ::")]
    if classifiers:
        return "; ".join(text.rpartition(":: ")[2] for text in classifiers)
    return metadata["License"].strip().splitlines()[0][:80] if "License" in metadata else "not stated"


def table(packages: Iterable[Distribution]) -> str:
    """Rows of a table, by name."""
    ordered = sorted(packages, key=lambda package: package.name.lower())
    return "".join(
        f"| {one.name} | {one.version} | {licence(one)} |\n" for one in ordered if one.name != "fcw"
    )


def main() -> None:
    """Write the list."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter).parse_args()
    own = {one.name: one for one in brought("fcw", set())}
    more = {one.name: one for one in brought("fcw", set(), EXTRAS) if one.name not in own}
    text = HEAD + table(own.values()) + EXTRAS_HEAD + table(more.values())
    Path(__file__).with_name("licences.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
