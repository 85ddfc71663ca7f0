"""Put rendered pictures side by side, or beside real ones, and measure their colours, contrast and sharpness.

    python docs/contact_sheet.py                           writes docs/images/simulation-contact-sheet.jpg
    python docs/contact_sheet.py --beside-real sheet.jpg   real frames of FCW_DATA on the right

Real frames belong to others: a sheet with them is for looking, and never goes into the repository.
"""

import argparse
import os
import sys
from collections.abc import Sequence
from itertools import chain
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.simulation.picture.renderer import Renderer
from fcw.simulation.world.scenario import IMAGE_SIZE, load_scenario
from fcw.simulation.world.world import World

Picture = NDArray[np.uint8]

REPOSITORY = Path(__file__).resolve().parents[1]
SHEET = REPOSITORY / "docs" / "images" / "simulation-contact-sheet.jpg"
SCENARIO = "demo"
MOMENTS: tuple[tuple[int, float], ...] = ((0, 4.0), (1, 12.5), (2, 14.5), (3, 22.0), (4, 27.5), (5, 30.5))
"""Seed and time in seconds of each picture: other light, paint, and traffic each time."""
REAL_FOLDERS = (
    "tusimple/images",
    "labels/images/solidWhiteRight",
    "labels/images/udacity_project_video_1fps",
)
TILE = (640, 360)
JPEG_QUALITY = 88


def main() -> None:
    """Read the command line and write the sheet."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0] if __doc__ else None)
    parser.add_argument(
        "--beside-real", type=Path, metavar="FILE", help="where a sheet with real frames goes"
    )
    options = parser.parse_args()
    rendered = rendered_pictures()
    report("rendered", rendered)
    if options.beside_real is None:
        write_sheet(SHEET, rendered, columns=2)
        return
    out = options.beside_real.resolve()
    data = os.environ.get("FCW_DATA")
    if not data:
        sys.exit("FCW_DATA is not set: name the folder of the real drives")
    if out.is_relative_to(REPOSITORY):
        sys.exit(f"{out}: a sheet with frames of others must lie outside of {REPOSITORY}")
    real = real_pictures(Path(data), len(rendered))
    report("real", real)
    pairs = list(chain.from_iterable(zip(rendered, real, strict=True)))
    write_sheet(out, pairs, columns=2)


def rendered_pictures() -> list[Picture]:
    """The pictures of `MOMENTS`."""
    scenario = load_scenario(SCENARIO)
    camera = scenario.camera.camera()
    pictures = []
    for seed, time_s in MOMENTS:
        states = World(scenario, seed).states()
        state = next(state for state in states if state.time_ns >= time_s * 1e9)
        pictures.append(Renderer(camera, IMAGE_SIZE, seed).render(state))
    return pictures


def real_pictures(data: Path, count: int) -> list[Picture]:
    """Real frames spread evenly over `REAL_FOLDERS`."""
    pictures = []
    each = -(-count // len(REAL_FOLDERS))
    for folder in REAL_FOLDERS:
        files = sorted(path for path in (data / folder).rglob("*") if path.suffix in (".jpg", ".png"))
        for path in files[len(files) // (2 * each) :: max(len(files) // each, 1)][:each]:
            picture = cv2.imread(str(path))
            if picture is not None:
                pictures.append(np.asarray(picture, np.uint8))
    return pictures[:count]


def report(name: str, pictures: Sequence[Picture]) -> None:
    """Say how bright, contrasty and sharp pictures are."""
    for region, rows in (("sky", (0.05, 0.3)), ("middle", (0.4, 0.6)), ("road", (0.65, 0.85))):
        parts = [p[int(rows[0] * p.shape[0]) : int(rows[1] * p.shape[0])] for p in pictures]
        grey = [cv2.cvtColor(part, cv2.COLOR_BGR2GRAY) for part in parts]
        bgr = np.mean([part.mean(axis=(0, 1)) for part in parts], axis=0)
        contrast = np.mean([part.std() for part in grey])
        sharpness = np.mean([np.abs(cv2.Laplacian(part, cv2.CV_32F)).mean() for part in grey])
        colors = "BGR " + " ".join(f"{value:3.0f}" for value in bgr)
        figures = f"contrast {contrast:.0f}, sharpness {sharpness:.1f}"
        sys.stdout.write(f"{name:>8} {region:>6}: {colors}, {figures}\n")


def write_sheet(path: Path, pictures: Sequence[Picture], columns: int) -> None:
    """Write pictures in rows as one JPEG."""
    tiles = [cv2.resize(picture, TILE, interpolation=cv2.INTER_AREA) for picture in pictures]
    rows = [np.hstack(tiles[start : start + columns]) for start in range(0, len(tiles), columns)]
    _, encoded = cv2.imencode(".jpg", np.vstack(rows), [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(path.name + ".partial")
    partial.write_bytes(encoded.tobytes())
    partial.replace(path)


if __name__ == "__main__":
    main()
