"""Take the pictures of the calibration page that stand in the documentation.

    python docs/screenshot_calibrate.py [--out docs/images] [--only calibrate-bumper]

Needs a Chromium and playwright, of the `dev` group. The page serves a copy of the shipped drive; what is on
it is what clicks on its white marks give.
"""

import argparse
import math
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

from page_pictures import BROWSER_ARGUMENTS, READY_MS, WITHOUT_WARNING, steady_screenshot
from playwright.sync_api import Browser, ViewportSize, sync_playwright

from fcw.camera.calibration import Gaussian
from fcw.camera.file import default_path
from fcw_viz.calibrate_app.document.document import Belief
from fcw_viz.calibrate_app.document.edits import AddMark, Edit, SetFieldOfView, SetHeight, SetReference
from fcw_viz.calibrate_app.server import CalibrationPage
from fcw_viz.calibrate_app.session import Person

ROOT = Path(__file__).parents[1]
DRIVE = ROOT / "recordings" / "demo" / "drive.mp4"
SOMEBODY = Person("somebody")

NEAR, MIDDLE, FAR = AddMark(640, 500.2, 0, 6.0), AddMark(640, 408.0, 0, 15.0), AddMark(640, 371.1, 0, 30.0)
"""The white marks of the shipped drive, measured from the bumper, 1.6 m ahead of the camera."""
HEIGHT, BUMPER = SetHeight(1.3), SetReference(True, 1.6)
NEAR_ONLY = tuple(
    AddMark(640, row_px, 0, distance_m) for row_px, distance_m in ((560.6, 4), (525.8, 5), (480.4, 7))
)
FOURTH = AddMark(494, 436.4, 0, 10.6)
"""The near end of a dash of the lane line."""
LENS = Gaussian(math.radians(65), math.radians(3))


@dataclass(frozen=True, slots=True)
class Scene:
    """One picture.

    Attributes:
        name: of the file.
        edits: what was said.
        tab: of the panel over the sky.
        dark: its colours.
        mend: whether the first mend is pressed.
    """

    name: str
    edits: tuple[Edit, ...]
    tab: str = "Error"
    dark: bool = False
    mend: bool = False


SCENES = (
    Scene("calibrate-empty", (), "Keys"),
    Scene("calibrate-three-points", (NEAR, MIDDLE, FAR, HEIGHT, BUMPER)),
    Scene("calibrate-implausible", (NEAR, MIDDLE, FAR, HEIGHT)),
    Scene("calibrate-bumper-mend", (NEAR, MIDDLE, FAR, HEIGHT), "From above", mend=True),
    Scene("calibrate-far-uncertain", (*NEAR_ONLY, HEIGHT, BUMPER)),
    Scene(
        "calibrate-more-knowledge",
        (*NEAR_ONLY, FAR, HEIGHT, BUMPER, SetFieldOfView(Belief(LENS))),
        "Know more",
    ),
    Scene(
        "calibrate-dark",
        (NEAR, MIDDLE, FAR, FOURTH, HEIGHT, BUMPER),
        dark=True,
    ),
)


def main() -> None:
    """Read the command line and take the pictures."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0] if __doc__ else None)
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "images", help="folder of the pictures")
    parser.add_argument("--only", help="name of the one picture to take")
    parser.add_argument("--browser", default=shutil.which("chromium"), help="the Chromium to use")
    parser.add_argument("--size", default="1400x900", help="of the window, WIDTHxHEIGHT")
    options = parser.parse_args()
    width, height = (int(length) for length in options.size.split("x"))

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=options.browser, args=list(BROWSER_ARGUMENTS))
        for scene in SCENES:
            if options.only in (None, scene.name):
                take(
                    scene,
                    browser,
                    ViewportSize(width=width, height=height),
                    options.out / f"{scene.name}.png",
                )
        browser.close()


def take(scene: Scene, browser: Browser, window: ViewportSize, file: Path) -> None:
    """Serve the scene and take its picture."""
    with tempfile.TemporaryDirectory() as folder:
        source = Path(shutil.copy(DRIVE, folder))
        served = CalibrationPage(source, default_path(source), dark=scene.dark)
        try:
            if scene.edits:
                served.session.apply(SOMEBODY, *scene.edits)
            context = browser.new_context(viewport=window)
            context.add_init_script(WITHOUT_WARNING)
            page = context.new_page()
            page.goto(f"{served.url}/?fixedDpr=1")
            page.wait_for_function("window.__viserMutable?.cameraControl", timeout=READY_MS)
            page.get_by_text(scene.tab, exact=True).click(timeout=READY_MS)
            if scene.mend:
                page.get_by_role("button", name="measured from the bumper").click()
            file.write_bytes(steady_screenshot(page))
            context.close()
        finally:
            served.stop()


if __name__ == "__main__":
    main()
