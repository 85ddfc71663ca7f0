"""What finished stages of a training left on disk, so that a killed one goes on where it was."""

import hashlib
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fcw.bounded.arrays import npz_arrays
from fcw.errors import UserError
from fcw.files import whole_file


class Checkpoints:
    """Results of stages by name, each a file of its own, written whole or not at all.

    A stage's result must follow from the identity and the stages before it alone: then a training that goes
    on from here ends as an uninterrupted one does.
    """

    def __init__(self, folder: Path | None, identity: str) -> None:
        """Take up what is in the folder, unless it is of another training.

        Args:
            folder: where the files are; None keeps nothing.
            identity: text that differs where settings, labels or pictures do.

        Raises:
            UserError: the folder cannot be written.
        """
        self._folder = folder
        if folder is None:
            return
        digest = hashlib.sha256(identity.encode()).hexdigest()
        mark = folder / "identity"
        try:
            if folder.is_symlink() or (folder.exists() and not _is_ours(folder, mark)):
                raise UserError(
                    f"{folder}: is there, and holds other things than a training's stages; move it away, or "
                    "name another --out"
                )
            if folder.exists() and (not mark.is_file() or mark.read_text(encoding="utf-8") != digest):
                shutil.rmtree(folder)
            folder.mkdir(exist_ok=True)
            mark.write_text(digest, encoding="utf-8")
        except OSError as error:
            raise UserError(
                f"{folder}: cannot keep the training's finished stages there ({error.strerror}); "
                "give --out in a folder that can be written"
            ) from error

    def stage(
        self, name: str, compute: Callable[[], Mapping[str, NDArray[Any]]]
    ) -> Mapping[str, NDArray[Any]]:
        """The stage's arrays: those kept, or else computed now and kept."""
        path = self._folder and self._folder / (name.replace(" ", "-") + ".npz")
        if path and path.is_file():
            try:
                return npz_arrays(path)
            except (ValueError, OSError):
                path.unlink()  # not as it was written: the stage is done again
        arrays = dict(compute())
        if path:
            with whole_file(path) as partial, partial.open("wb") as file:
                np.savez(file, allow_pickle=False, **arrays)
        return arrays


def _is_ours(folder: Path, mark: Path) -> bool:
    """Whether there is nothing in it but what a training keeps."""
    if not folder.is_dir():
        return False
    return all(path == mark or path.suffix == ".npz" for path in folder.iterdir())
