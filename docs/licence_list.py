"""Writes `docs/licences.md`: the packages that installing the program brings, and their licences.

    python docs/licence_list.py

Licences are what the metadata of each package say (Core Metadata 2.4: License-Expression, else classifiers,
else the first line of License).
"""

from collections.abc import Iterator
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path

from packaging.requirements import Requirement

HEAD = """# Licences of what is installed

`pip install fcw` brings these packages; the versions are those that the list was made with
(`python docs/licence_list.py`). Extras (`onnx`, `parquet`, `train`) bring others.

| package | version | licence, as its metadata say |
| --- | --- | --- |
"""


def brought(name: str, seen: set[str]) -> Iterator[Distribution]:
    """A package and all that it needs here, without extras."""
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
        if needed.marker is None or needed.marker.evaluate({"extra": ""}):
            yield from brought(needed.name, seen)


def licence(package: Distribution) -> str:
    """What a package's metadata say of its licence."""
    metadata = package.metadata
    if "License-Expression" in metadata:
        return metadata["License-Expression"]
    classifiers = [text for text in metadata.get_all("Classifier") or () if text.startswith("License ::")]
    if classifiers:
        return "; ".join(text.rpartition(":: ")[2] for text in classifiers)
    return metadata["License"].strip().splitlines()[0][:80] if "License" in metadata else "not stated"


def main() -> None:
    """Write the list."""
    packages = sorted(brought("fcw", set()), key=lambda package: package.name.lower())
    rows = [f"| {one.name} | {one.version} | {licence(one)} |" for one in packages if one.name != "fcw"]
    Path(__file__).with_name("licences.md").write_text(HEAD + "\n".join(rows) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
