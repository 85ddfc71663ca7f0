"""Take the pictures of the review page that stand in the documentation.

    python docs/screenshot_review.py DRIVES [--out docs/images] [--only review-event]

Needs a Chromium and playwright, of the `dev` group. DRIVES is a folder with the logs of some drives, the
shipped one among them under the name `demo`, and as `demo-ttc` by another policy: what is on the pictures
is said of copies of them.
"""

import shutil
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from page_pictures import READY_MS, STEADY_MS, chromium, option_parser, steady_screenshot, window
from playwright.sync_api import Page

from fcw.annotation.records import Judgement, Note, Reason, Verdict
from fcw.annotation.review import reference_to
from fcw.annotation.store import ReviewStore
from fcw.logs.events import find_events
from fcw.logs.export.clip import find_drives
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.names import MCAP_NAME
from fcw_viz.review_app.server import ReviewPage

ROOT = Path(__file__).parents[1]
SHIPPED, OTHER_RUN = "demo", "demo-ttc"


@dataclass(frozen=True, slots=True)
class Scene:
    """One picture.

    Attributes:
        name: of the file.
        act: what is done on the page.
        dark: its colours.
        place: where it begins; empty for the list of drives.
    """

    name: str
    act: Callable[[Page], None]
    dark: bool = False
    place: str = f"{SHIPPED}#0"


def look(page: Page) -> None:
    """Do nothing."""


def judge(page: Page) -> None:
    """Judge the event, with a reason."""
    page.keyboard.press("2")
    page.locator("select[data-fcw-choice=reason]").select_option("DRIVER_AWARE")


def correct_box(page: Page) -> None:
    """Take hold of the lead's box."""
    page.get_by_role("tab", name="Boxes").click()
    page.keyboard.press("e")
    canvas = page.locator("canvas[data-engine]").bounding_box()
    assert canvas is not None
    # The vehicle ahead fills the middle of the shipped drive's worst moment.
    page.wait_for_timeout(STEADY_MS)
    page.mouse.click(canvas["x"] + canvas["width"] * 0.5, canvas["y"] + canvas["height"] * 0.55)


def choose_plots(page: Page) -> None:
    """Plot more, and look at a moment."""
    page.get_by_role("tab", name="Plots").click()
    page.locator('[data-fcw="plot:braking ahead"]').click()
    page.locator("select[data-fcw-choice=subject]").select_option("own")
    for name in ("own_speed", "yaw_rate", "probability"):
        page.locator(f'[data-fcw="plot:{name} own"]').click()
    page.wait_for_timeout(STEADY_MS)
    plots = page.locator("#fcw-plots").bounding_box()
    assert plots is not None
    page.mouse.move(plots["x"] + 0.44 * plots["width"], plots["y"] + 0.5 * plots["height"])


def compare(page: Page) -> None:
    """Compare with another run, and go to the first difference."""
    page.get_by_role("tab", name="Runs").click()
    page.locator("select[data-fcw-choice=compare]").select_option(OTHER_RUN)
    page.wait_for_selector('.fcw-event[data-fcw^="difference"]', timeout=READY_MS)
    page.keyboard.press("d")


SCENES = (
    Scene("review-folder", look, place=""),
    Scene("review-event", look),
    Scene("review-verdict", judge, dark=True),
    Scene("review-boxes", correct_box),
    Scene("review-plots", choose_plots),
    Scene("review-runs", compare),
)


def main() -> None:
    """Read the command line and take the pictures."""
    parser = option_parser(__doc__)
    parser.add_argument("drives", type=Path, help="folder with the logs")
    parser.add_argument("--only", help="name of the one picture to take")
    options = parser.parse_args()

    with chromium(options) as browser:
        for scene in SCENES:
            if options.only in (None, scene.name):
                context = window(browser, options)
                take(scene, options.drives, context.new_page(), options.out / f"{scene.name}.png")
                context.close()


def take(scene: Scene, drives: Path, page: Page, file: Path) -> None:
    """Serve copies of the drives and take the picture."""
    with tempfile.TemporaryDirectory() as folder:
        copies: dict[str, Path] = {}
        for name, log in find_drives([drives]).items():
            (Path(folder) / name).mkdir()
            copies[name] = Path(shutil.copy(log, Path(folder) / name / MCAP_NAME))
        say_something(copies)
        served = ReviewPage(copies, "Test drives", "anna", dark=scene.dark)
        try:
            page.goto(f"{served.url}/?fixedDpr=1")
            page.wait_for_function("!document.body.innerText.includes('not read yet')", timeout=READY_MS)
            page.wait_for_selector(".fcw-row", timeout=READY_MS)
            steady_screenshot(page)
            if scene.place:
                name, _, event = scene.place.partition("#")
                page.locator(f'.fcw-row[data-drive="{name}"] [data-event="{event}"]').click()
                page.wait_for_selector(".fcw-clock", timeout=READY_MS)
                page.wait_for_timeout(STEADY_MS)
                scene.act(page)
            file.write_bytes(steady_screenshot(page))
        finally:
            served.stop()


def say_something(drives: dict[str, Path]) -> None:
    """What somebody else has said of the drives before."""
    for name, path in drives.items():
        log = DriveLog(path)
        events = find_events(log.series())
        store = ReviewStore(log)
        if name == SHIPPED:
            store.add("bert", Note(16.0, "the lead pulls away"))
        elif name == OTHER_RUN and events:
            verdict = Verdict(reference_to(events[0]), Judgement.FALSE, Reason.OTHER_LANE)
            store.add("bert", verdict)
        store.close()


if __name__ == "__main__":
    main()
