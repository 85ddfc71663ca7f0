"""Take the pictures of the calibration page that stand in the documentation.

    python docs/screenshot_calibrate.py [--out docs/images] [--only calibrate-bumper]

Needs a Chromium and playwright, of the `dev` group. The page serves a copy of the shipped drive; what is on
it is what clicks on its white marks give.
"""

import math
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

from page_pictures import READY_MS, chromium, option_parser, steady_screenshot, window
from playwright.sync_api import Page

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
        tab: of the panel.
        dark: its colours.
        mend: whether the first mend is pressed.
    """

    name: str
    edits: tuple[Edit, ...]
    tab: str = "Calibrate"
    dark: bool = False
    mend: bool = False


SCENES = (
    Scene("calibrate-empty", ()),
    Scene("calibrate-three-points", (NEAR, MIDDLE, FAR, HEIGHT, BUMPER)),
    Scene("calibrate-implausible", (NEAR, MIDDLE, FAR, HEIGHT)),
    Scene("calibrate-bumper-mend", (NEAR, MIDDLE, FAR, HEIGHT), "From above", mend=True),
    Scene("calibrate-far-uncertain", (*NEAR_ONLY, HEIGHT, BUMPER)),
    Scene(
        "calibrate-more-knowledge",
        (*NEAR_ONLY, FAR, HEIGHT, BUMPER, SetFieldOfView(Belief(LENS))),
    ),
    Scene(
        "calibrate-dark",
        (NEAR, MIDDLE, FAR, FOURTH, HEIGHT, BUMPER),
        dark=True,
    ),
)


def main() -> None:
    """Read the command line and take the pictures."""
    parser = option_parser(__doc__)
    parser.add_argument("--only", help="name of the one picture to take")
    options = parser.parse_args()

    with chromium(options) as browser:
        for scene in SCENES:
            if options.only in (None, scene.name):
                context = window(browser, options)
                take(scene, context.new_page(), options.out / f"{scene.name}.png")
                context.close()


def take(scene: Scene, page: Page, file: Path) -> None:
    """Serve the scene and take its picture."""
    with tempfile.TemporaryDirectory() as folder:
        source = Path(shutil.copy(DRIVE, folder))
        served = CalibrationPage(source, default_path(source), dark=scene.dark)
        try:
            if scene.edits:
                served.session.apply(SOMEBODY, *scene.edits)
            page.goto(f"{served.url}/?fixedDpr=1")
            page.wait_for_function("window.__viserMutable?.cameraControl", timeout=READY_MS)
            page.get_by_role("tab", name=scene.tab).wait_for(timeout=READY_MS)
            if scene.mend:
                page.get_by_role("button", name="measured from the bumper").click()
            page.get_by_role("tab", name=scene.tab).click()
            file.write_bytes(steady_screenshot(page))
        finally:
            served.stop()


if __name__ == "__main__":
    main()
