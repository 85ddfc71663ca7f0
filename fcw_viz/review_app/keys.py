"""The keys of the page: each does what some button does, and stands in the command palette."""

from functools import partial

from fcw.annotation.records import Judgement
from fcw_viz.page.keys import ZOOM_STEP, Key
from fcw_viz.review_app.desk import Desk
from fcw_viz.review_app.words import JUDGEMENT_KEYS

SKIP_S = 1.0


def all_keys() -> list[Key[Desk]]:
    """Every key of the page."""
    keys: list[Key[Desk]] = [
        Key("Play or stop", "space", None, lambda desk: desk.playing.toggle()),
        Key("Play the event", "space", "shift", lambda desk: desk.playing.play_event()),
        Key("Next frame", "arrowright", None, lambda desk: desk.step(1)),
        Key("Previous frame", "arrowleft", None, lambda desk: desk.step(-1)),
        Key("Next frame", ".", None, lambda desk: desk.step(1)),
        Key("Previous frame", ",", None, lambda desk: desk.step(-1)),
        Key("One second on", "arrowright", "shift", lambda desk: desk.skip(SKIP_S)),
        Key("One second back", "arrowleft", "shift", lambda desk: desk.skip(-SKIP_S)),
        Key("To the beginning", "home", None, lambda desk: desk.go_to(0)),
        Key("To the end", "end", None, lambda desk: desk.go_to(desk.place.opened.last_row)),
        Key("Next event", "N", None, lambda desk: desk.next_event(True)),
        Key("Previous event", "P", None, lambda desk: desk.next_event(False)),
        Key("Next event of the list", "arrowdown", None, lambda desk: desk.next_listed(True)),
        Key("Previous event of the list", "arrowup", None, lambda desk: desk.next_listed(False)),
        Key("Faster", "]", None, lambda desk: desk.playing.change_speed(True)),
        Key("Slower", "[", None, lambda desk: desk.playing.change_speed(False)),
        Key("Wider plots", "W", None, lambda desk: desk.screen.next_window(True)),
        Key("Narrower plots", "W", "shift", lambda desk: desk.screen.next_window(False)),
        Key("A warning was missed here", "M", None, lambda desk: desk.annotating.add_missed()),
        Key("Type a note", "T", None, lambda desk: desk.type_note()),
        Key("Correct boxes, or stop", "E", None, lambda desk: desk.screen.switch_boxes()),
        Key("All boxes of the frame are right", "C", None, lambda desk: desk.boxes.confirm()),
        Key("Delete the selected box", "delete", None, lambda desk: desk.boxes.delete()),
        Key("Delete the selected box", "backspace", None, lambda desk: desk.boxes.delete()),
        Key("Take back what you said last", "Z", "cmd/ctrl", lambda desk: desk.annotating.undo()),
        Key("Say it again", "Y", "cmd/ctrl", lambda desk: desk.annotating.redo()),
        Key("Say it again", "Z", "cmd/ctrl+shift", lambda desk: desk.annotating.redo()),
        Key("Picture with or without overlay", "O", None, lambda desk: desk.screen.switch_overlay()),
        Key("The road from above, or the picture", "B", None, lambda desk: desk.screen.switch_birds_eye()),
        Key("Whole picture", "F", None, lambda desk: desk.view.fit()),
        Key("Zoom in", "=", None, lambda desk: desk.view.zoom(ZOOM_STEP)),
        Key("Zoom in", "[plus]", None, lambda desk: desk.view.zoom(ZOOM_STEP)),
        Key("Zoom in", "[plus]", "shift", lambda desk: desk.view.zoom(ZOOM_STEP)),
        Key("Zoom out", "-", None, lambda desk: desk.view.zoom(1 / ZOOM_STEP)),
        Key("All drives", "L", None, lambda desk: desk.show_list()),
        Key("Put the tool away", "escape", None, lambda desk: desk.escape()),
    ]
    for judgement, key in JUDGEMENT_KEYS.items():
        keys.append(Key(f"Verdict: {judgement.value}", key, None, partial(_judge, judgement=judgement)))
    return keys


def _judge(desk: Desk, judgement: Judgement) -> None:
    desk.annotating.judge(judgement)


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
