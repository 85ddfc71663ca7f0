"""Small videos made on the spot."""

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from av.video.stream import VideoStream
from numpy.typing import NDArray
from video_making import MakeVideo


@pytest.fixture(scope="session")
def numbered_images() -> list[NDArray[np.uint8]]:
    """A hundred pictures, each with its number in eight black and white bands, the lowest bit first."""
    bands = [[255 * (i >> bit & 1) for bit in range(8)] for i in range(100)]
    return [np.tile(np.repeat(np.array(row, np.uint8), 8)[None, :, None], (48, 1, 3)) for row in bands]


@pytest.fixture(scope="session")
def noise_images() -> list[NDArray[np.uint8]]:
    """Thirty pictures that do not compress: cutting the file cuts pictures."""
    generator = np.random.default_rng(3)
    return [generator.integers(0, 256, (48, 64, 3), np.uint8) for _ in range(30)]


@pytest.fixture
def make_video(tmp_path: Path) -> MakeVideo:
    """Encode pictures into a file in the test's own folder."""

    def make(
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
        pixel_ratio: Fraction | None = None,
    ) -> Path:
        path = tmp_path / name
        with av.open(str(path), "w", options=container_options or {}) as container:
            stream = container.add_stream(codec, rate=30, options=codec_options or {})
            assert isinstance(stream, VideoStream)
            stream.height, stream.width = images[0].shape[:2]
            stream.pix_fmt = pixel_format
            stream.time_base = stream.codec_context.time_base = time_base
            if pixel_ratio is not None:
                stream.codec_context.sample_aspect_ratio = pixel_ratio
            if rotation is not None:
                stream.set_display_rotation(*rotation)
            for i, image in enumerate(images):
                picture = av.VideoFrame.from_ndarray(image, format="bgr24")
                picture.pts = i if pts is None else pts[i]
                picture.time_base = time_base
                container.mux(stream.encode(picture))
            container.mux(stream.encode(None))
        return path

    return make
