"""The keys of the page: each does what some button does, and stands in the command palette."""

from functools import partial
from typing import TYPE_CHECKING

from fcw.annotation.records import Judgement
from fcw_viz.page.keys import ZOOM_STEP, Key
from fcw_viz.review_app.panels.event_list import JUDGEMENT_KEYS

if TYPE_CHECKING:
    from fcw_viz.review_app.tab import Tab

SKIP_S = 1.0


def all_keys() -> "list[Key[Tab]]":
    """Every key of the page."""
    keys: list[Key[Tab]] = [
        Key("Play or stop", "space", None, lambda tab: tab.playing.toggle()),
        Key("Play the event", "space", "shift", lambda tab: tab.playing.play_event()),
        Key("Next frame", "arrowright", None, lambda tab: tab.step(1)),
        Key("Previous frame", "arrowleft", None, lambda tab: tab.step(-1)),
        Key("Next frame", ".", None, lambda tab: tab.step(1)),
        Key("Previous frame", ",", None, lambda tab: tab.step(-1)),
        Key("One second on", "arrowright", "shift", lambda tab: tab.skip(SKIP_S)),
        Key("One second back", "arrowleft", "shift", lambda tab: tab.skip(-SKIP_S)),
        Key("To the beginning", "home", None, lambda tab: tab.go_to(0)),
        Key("To the end", "end", None, lambda tab: tab.go_to(tab.opened.last_row)),
        Key("Next event", "N", None, lambda tab: tab.next_event(True)),
        Key("Previous event", "P", None, lambda tab: tab.next_event(False)),
        Key("Next event of the list", "arrowdown", None, lambda tab: tab.next_listed(True)),
        Key("Previous event of the list", "arrowup", None, lambda tab: tab.next_listed(False)),
        Key("Faster", "]", None, lambda tab: tab.playing.change_speed(True)),
        Key("Slower", "[", None, lambda tab: tab.playing.change_speed(False)),
        Key("Wider plots", "W", None, lambda tab: tab.screen.next_window(True)),
        Key("Narrower plots", "W", "shift", lambda tab: tab.screen.next_window(False)),
        Key("A warning was missed here", "M", None, lambda tab: tab.annotating.add_missed()),
        Key("Type a note", "T", None, lambda tab: tab.type_note()),
        Key("Correct boxes, or stop", "E", None, lambda tab: tab.boxes.toggle()),
        Key("All boxes of the frame are right", "C", None, lambda tab: tab.boxes.confirm()),
        Key("Delete the selected box", "delete", None, lambda tab: tab.boxes.delete()),
        Key("Delete the selected box", "backspace", None, lambda tab: tab.boxes.delete()),
        Key("Take back what you said last", "Z", "cmd/ctrl", lambda tab: tab.annotating.undo()),
        Key("Say it again", "Y", "cmd/ctrl", lambda tab: tab.annotating.redo()),
        Key("Say it again", "Z", "cmd/ctrl+shift", lambda tab: tab.annotating.redo()),
        Key("Picture with or without overlay", "O", None, lambda tab: tab.screen.switch_overlay()),
        Key("The road from above, or the picture", "B", None, lambda tab: tab.screen.switch_birds_eye()),
        Key("Whole picture", "F", None, lambda tab: tab.view.fit()),
        Key("Zoom in", "=", None, lambda tab: tab.view.zoom(ZOOM_STEP)),
        Key("Zoom in", "[plus]", None, lambda tab: tab.view.zoom(ZOOM_STEP)),
        Key("Zoom in", "[plus]", "shift", lambda tab: tab.view.zoom(ZOOM_STEP)),
        Key("Zoom out", "-", None, lambda tab: tab.view.zoom(1 / ZOOM_STEP)),
        Key("All drives", "L", None, lambda tab: tab.show_list()),
        Key("Put the tool away", "escape", None, lambda tab: tab.escape()),
    ]
    for judgement, key in JUDGEMENT_KEYS.items():
        keys.append(Key(f"Verdict: {judgement.value}", key, None, partial(_judge, judgement=judgement)))
    return keys


def _judge(tab: "Tab", judgement: Judgement) -> None:
    tab.annotating.judge(judgement)


HELP_ROWS = (
    ("Space", "play, stop; with Shift the event"),
    ("← →, . ,", "frame back, on; with Shift a second"),
    ("N P", "next, previous event"),
    ("↑ ↓", "the same, as the list is sorted"),
    ("[ ]", "slower, faster"),
    ("W", "wider plots; with Shift narrower"),
    ("1 2 3 4", "right, too early, too late, false"),
    ("M", "a warning was missed here"),
    ("T", "type a note"),
    ("E", "correct boxes; C: all are right"),
    ("Ctrl Z, Ctrl Y", "take back, say again"),
    ("Home End", "first, last frame"),
    ("Wheel, + −", "zoom; F: whole picture"),
    ("O", "picture without the overlay"),
    ("B", "the road from above, or the picture"),
    ("L", "all drives"),
    ("Ctrl K", "every command"),
)
