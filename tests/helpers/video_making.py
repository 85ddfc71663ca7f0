"""How tests of sources ask for a video."""

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray


class MakeVideo(Protocol):
    def __call__(
        self,
        name: str,
        images: Sequence[NDArray[np.uint8]],
        *,
        pts: Sequence[int] | None = None,
        time_base: Fraction = Fraction(1, 30),
        codec: str = "libx264",
        pixel_format: str = "yuv420p",
        codec_options: dict[str, str] | None = None,
        container_options: dict[str, str] | None = None,
        rotation: tuple[int, bool, bool] | None = None,
    ) -> Path: ...
