"""The keys of the page; each does the same as a button, and is listed in the command palette."""

from collections.abc import Callable
from functools import partial

from fcw_viz.page.keys import Key, picture_keys
from fcw_viz.review_app.desk import Desk
from fcw_viz.review_app.words import JUDGEMENT_KEYS

SKIP_S = 1.0
ARROWS = {"arrowleft": (-1, 0), "arrowright": (1, 0), "arrowup": (0, -1), "arrowdown": (0, 1)}
"""Keys with the direction in pixels to the right and down."""


def all_keys(desk: Desk, switch_goes_on: Callable[[], object]) -> list[Key]:
    """All keys of the page.

    Args:
        desk: the desk that they control.
        switch_goes_on: switches whether a verdict leads to the next event.
    """
    return [
        Key("Play or pause", "space", None, desk.playing.toggle),
        Key("Play the event", "space", "shift", desk.playing.play_event),
        Key("Next frame", "arrowright", None, lambda: desk.step(1)),
        Key("Previous frame", "arrowleft", None, lambda: desk.step(-1)),
        Key("Next frame", ".", None, lambda: desk.step(1)),
        Key("Previous frame", ",", None, lambda: desk.step(-1)),
        Key("One second forward", "arrowright", "shift", lambda: desk.skip(SKIP_S)),
        Key("One second back", "arrowleft", "shift", lambda: desk.skip(-SKIP_S)),
        Key("First frame", "home", None, lambda: desk.go_to(0)),
        Key("Last frame", "end", None, lambda: desk.go_to(desk.place.opened.last_row)),
        Key("Next event", "N", None, lambda: desk.next_event(True)),
        Key("Previous event", "P", None, lambda: desk.next_event(False)),
        Key("Next event in the list", "arrowdown", None, lambda: desk.next_listed(True)),
        Key("Previous event in the list", "arrowup", None, lambda: desk.next_listed(False)),
        Key("Start the range here", "A", None, desk.mark_start),
        Key("End the range here", "S", None, desk.mark_end),
        Key("Loop the range, or the event", "R", None, desk.playing.loop),
        Key("Next unjudged event in all drives", "U", None, desk.next_unjudged),
        Key("Auto-next on or off", "G", None, switch_goes_on),
        Key("Faster", "]", None, lambda: desk.playing.change_speed(True)),
        Key("Slower", "[", None, lambda: desk.playing.change_speed(False)),
        Key("Longer plot window", "W", None, lambda: desk.screen.next_window(True)),
        Key("Shorter plot window", "W", "shift", lambda: desk.screen.next_window(False)),
        Key("Next difference between two runs", "D", None, lambda: desk.runs.step(True)),
        Key("Previous difference between two runs", "D", "shift", lambda: desk.runs.step(False)),
        Key("Tall or normal plots", "H", None, desk.screen.switch_height),
        Key("A warning was missed here", "M", None, desk.annotating.add_missed),
        Key("Type a note", "T", None, desk.type_note),
        Key("Correct boxes on or off", "E", None, desk.screen.switch_boxes),
        Key("Confirm all boxes of the frame", "C", None, desk.boxes.confirm),
        Key("Delete the selected box", "delete", None, desk.boxes.delete),
        Key("Delete the selected box", "backspace", None, desk.boxes.delete),
        Key("Next box of the frame", "V", None, desk.boxes.select_next),
        Key("Copy the box to the next frame", "K", None, desk.box_commands.copy_on),
        Key("Interpolate the box from where you last drew it", "I", None, desk.box_commands.interpolate),
        Key("Follow the box until it drifts", "J", None, desk.box_commands.follow),
        *(
            key
            for arrow, (right_px, down_px) in ARROWS.items()
            for key in (
                Key(
                    "Move the box a pixel",
                    arrow,
                    "cmd/ctrl",
                    partial(desk.box_commands.nudge, right_px, down_px),
                ),
                Key(
                    "Move the box's right or lower edge a pixel",
                    arrow,
                    "cmd/ctrl+shift",
                    partial(desk.box_commands.stretch, right_px, down_px),
                ),
            )
        ),
        Key("Undo", "Z", "cmd/ctrl", desk.undo),
        Key("Redo", "Y", "cmd/ctrl", desk.annotating.redo),
        Key("Redo", "Z", "cmd/ctrl+shift", desk.annotating.redo),
        Key("Overlay on or off", "O", None, desk.screen.switch_overlay),
        Key("Picture or view from above", "B", None, desk.screen.switch_birds_eye),
        *picture_keys(desk.view.fit, desk.view.zoom),
        Key("All drives", "L", None, desk.show_list),
        Key("Cancel", "escape", None, desk.escape),
        *(
            Key(f"Verdict: {judgement.value}", key, None, partial(desk.judge, judgement))
            for judgement, key in JUDGEMENT_KEYS.items()
        ),
    ]


HELP_ROWS = (
    ("Space", "play, pause; with Shift: play the event"),
    ("← →, . ,", "previous, next frame; with Shift: one second"),
    ("N P", "next, previous event"),
    ("↑ ↓", "the same, in list order"),
    ("U", "next unjudged event in all drives"),
    ("G", "go to the next event after each verdict"),
    ("A S", "start, end of a range; drag its ends"),
    ("R", "loop the range, or the event"),
    ("[ ]", "slower, faster"),
    ("W", "longer plot window; with Shift: shorter"),
    ("H", "tall or normal plots; or drag their upper edge"),
    ("D", "next difference between two runs; with Shift: previous"),
    ("1 2 3 4", "right, too early, too late, false"),
    ("M", "a warning was missed here, or in the range"),
    ("T", "type a note"),
    ("E", "correct boxes; C: confirm all; V: next box"),
    ("K, I, J", "copy the box to the next frame, interpolate, follow"),
    ("Ctrl arrows", "move the box; with Shift: its right or lower edge"),
    ("Ctrl Z, Ctrl Y", "undo, redo"),
    ("Home End", "first, last frame"),
    ("Wheel, + −", "zoom; F: whole picture"),
    ("O", "overlay on, off"),
    ("Mouse", "over a box: vehicle details"),
    ("B", "picture or view from above"),
    ("L", "all drives; ↑ ↓ Enter: open another"),
    ("Ctrl K", "all commands"),
)

LIST_ROWS = (
    ("↑ ↓", "next, previous drive or moment"),
    ("Enter", "open it"),
    ("Home End", "first, last in the list"),
    ("U", "next unjudged event in all drives"),
    ("G", "go to the next event after each verdict"),
    ("Tab", "filters, drives"),
    ("Ctrl K", "all commands"),
)
"""What keys do while the list of drives is shown."""
