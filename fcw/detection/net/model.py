"""The trained model: the nets of glance and look, and their file."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fcw.bounded.arrays import npz_arrays
from fcw.bounded.formats import json_value
from fcw.detection.net.glance import SHAPES, STRIDES
from fcw.detection.net.onnx_layers import Convolution, read_layers
from fcw.errors import UserError
from fcw.files import whole_file

FORMAT = "fcw-net-4"
SHIPPED_NET_PATH = Path(__file__).parents[1] / "weights" / "net.npz"


@dataclass(frozen=True, slots=True, eq=False)
class NetModel:
    """Everything that the detector has learned.

    Attributes:
        glance: convolutions of the net that sees the picture (`fcw.detection.net.glance.SHAPES`).
        look: bytes of the ONNX file of the net that looks closer (`fcw.detection.net.look.Look`).
        score_threshold: default threshold: least logit of a detection.
    """

    glance: tuple[Convolution, ...]
    look: bytes
    score_threshold: float

    def save(self, path: Path) -> None:
        """Write the model file (a NumPy .npz archive) whole or not at all.

        Raises:
            UserError: the file cannot be written there.
        """
        header = {"format": FORMAT, "score_threshold": self.score_threshold}
        arrays: dict[str, NDArray[Any]] = {"look": np.frombuffer(self.look, np.uint8)}
        for number, each in enumerate(self.glance):
            arrays[f"glance_{number}_weights"], arrays[f"glance_{number}_biases"] = each.weights, each.biases
        arrays["header"] = np.frombuffer(json.dumps(header).encode(), np.uint8)
        with whole_file(path) as partial, partial.open("wb") as file:
            np.savez_compressed(file, allow_pickle=False, **arrays)

    @classmethod
    def load(cls, path: Path) -> "NetModel":
        """Read a model file.

        Raises:
            UserError: the file is missing, or is no model of this kind.
        """
        try:
            arrays = npz_arrays(path)
            header = json_value(arrays["header"].tobytes().decode())
            if header["format"] != FORMAT:
                raise ValueError(f"format {header['format']!r:.40}, expected {FORMAT}")
            model = cls(
                tuple(_convolution(arrays, number) for number in range(len(SHAPES))),
                arrays["look"].tobytes(),
                header["score_threshold"],
            )
            read_layers(model.look)
            if not math.isfinite(model.score_threshold):
                raise ValueError(f"a score threshold of {model.score_threshold}")
            return model
        except FileNotFoundError:
            raise UserError(
                f"{path}: no such model file; train one with `fcw train --detector net`"
            ) from None
        except (KeyError, TypeError, AttributeError, ValueError, OverflowError, OSError) as error:
            reason = f"no {error} in it" if isinstance(error, KeyError) else error
            raise UserError(
                f"{path}: not a model of the net ({reason}); expected a file written by "
                "`fcw train --detector net`"
            ) from error


def _convolution(arrays: Mapping[str, NDArray[Any]], number: int) -> Convolution:
    """A convolution of the glance, by its number.

    Raises:
        ValueError: it is missing, or does not fit this net.
    """
    weights, biases = (arrays.get(f"glance_{number}_{name}") for name in ("weights", "biases"))
    shape = SHAPES[number]
    if weights is None or biases is None or weights.shape != shape or biases.shape != shape[:1]:
        raise ValueError(f"no convolution of {shape} as the glance's number {number}")
    if weights.dtype.kind != "f" or biases.dtype.kind != "f":
        raise ValueError(
            f"weights of {weights.dtype}, biases of {biases.dtype}, in the glance's number {number}"
        )
    if not np.isfinite(weights).all() or not np.isfinite(biases).all():
        raise ValueError(f"weights that are no numbers, in the glance's number {number}")
    return Convolution(weights.astype(np.float32), biases.astype(np.float32), STRIDES[number])
