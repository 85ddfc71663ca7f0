"""What is done with the selected box at once: nudged, described, copied on, interpolated, followed."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from fcw.annotation.box_motion import followed, interpolated, moved, reshaped
from fcw.annotation.records import BoxEdit, LabelledBox, MadeBy, VehicleKind, View
from fcw.box import Box
from fcw.errors import UserError
from fcw_viz.review_app.picture.box_editor import BoxEditor
from fcw_viz.review_app.picture.box_limits import SMALLEST_PX
from fcw_viz.review_app.place import Place

FOLLOWED_S = 4.0
"""How far a box is followed at once, before somebody looks."""


class BoxCommands:
    """The commands of one tab, in its thread."""

    def __init__(
        self,
        place: Place,
        boxes: BoxEditor,
        go_to: Callable[[int], object],
        notify: Callable[[str, str], object],
    ) -> None:
        """Nothing is done yet.

        Args:
            place: where the person is.
            boxes: the editor with the selected box.
            go_to: shows a row.
            notify: tells the person something, as a title and a text.
        """
        self._place, self._boxes, self._go_to, self._notify = place, boxes, go_to, notify

    @property
    def messages(self) -> Mapping[str, Callable[[str], object]]:
        """What the panel's elements say, and what is done then."""
        return {
            "boxview": lambda about: self._describe(view=View[about] if about else None),
            "boxkind": lambda about: self._describe(kind=VehicleKind[about] if about else None),
            "boxoccluded": lambda about: self._describe(occluded=int(about) if about else None),
            "boxrear": lambda _: self.switch_rear(),
            "boxcopy": lambda _: self.copy_on(),
            "boxinterpolate": lambda _: self.interpolate(),
            "boxfollow": lambda _: self.follow(),
        }

    def nudge(self, right_px: int, down_px: int) -> None:
        """Move the selected box by pixels of the picture."""
        self._boxes.change(moved(self._boxes.told()[1], right_px, down_px))

    def stretch(self, right_px: int, down_px: int) -> None:
        """Move the right and the lower edge of the selected box by pixels of the picture."""
        _, label = self._boxes.told()
        w, h = label.box.w + right_px, label.box.h + down_px
        if min(w, h) < SMALLEST_PX:
            raise UserError(f"a box has to be at least {SMALLEST_PX:g} pixels wide and high")
        self._boxes.change(reshaped(label, Box(label.box.x, label.box.y, w, h)))

    def switch_rear(self) -> None:
        """Have the next box that is drawn be the rear face of the selected one; one that has it loses it."""
        _, label = self._boxes.told()
        if label.rear_box is not None:
            self._boxes.change(replace(label, rear_box=None))
            return
        self._boxes.switch_drawing(rear=True)
        if self._boxes.draws_rear:
            self._notify("Draw the rear face", "Drag over the selected box.")

    def copy_on(self) -> None:
        """Put the selected box into the next frame as it stands, and go there."""
        box_id, label = self._boxes.told()
        row = self._place.row + 1
        if row > self._place.opened.last_row:
            raise UserError("this is the last frame")
        self._boxes.say(BoxEdit(self._frame(row), box_id, label, MadeBy.COPIED))
        self._go_to(row)

    def interpolate(self) -> None:
        """Set the selected box in all frames since it was last drawn by hand; after a correction in between
        up to the next one by hand, too."""
        box_id, label = self._boxes.told()
        now = self._place.row
        edits = [BoxEdit(self._frame(now), box_id, label)]
        before = self._drawn_row(box_id, range(now - 1, -1, -1))
        if before is None:
            raise UserError(
                "nothing to interpolate from: correct this box in an earlier frame too, then come back here"
            )
        edits += self._between(box_id, before, (now, label))
        # A correction between two that were drawn leads on to the second one.
        if self._made_by(box_id, now + 1) is MadeBy.INTERPOLATED:
            after = self._drawn_row(box_id, range(now + 1, self._place.opened.last_row + 1))
            if after is not None:
                edits += self._between(box_id, (now, label), after)
        self._boxes.say(*edits)
        self._notify("Interpolated", f"{len(edits) - 1} frames have this box now. Ctrl Z undoes it.")

    def follow(self) -> None:
        """Set the selected box in the frames that follow, as long as what is in it looks the same."""
        box_id, label = self._boxes.told()
        drive, now = self._place.opened, self._place.row
        last = drive.row_at(drive.time_s(now) + FOLLOWED_S)
        pictures = drive.pictures()
        try:
            first = pictures.at(self._frame(now))

            def later() -> Iterator[tuple[int, NDArray[np.uint8]]]:
                for row in range(now + 1, last + 1):
                    yield (
                        int(drive.series.time_ns[row] - drive.series.time_ns[now]),
                        pictures.at(self._frame(row)),
                    )

            labels = list(followed(label, first, later()))
        finally:
            pictures.close()
        if not labels:
            raise UserError(
                "this vehicle cannot be followed here: it is too small, or its appearance changes"
            )
        edits = [BoxEdit(self._frame(now), box_id, label)]
        for number, one in enumerate(labels, 1):
            edits.append(BoxEdit(self._frame(now + number), box_id, one, MadeBy.FOLLOWED))
        self._boxes.say(*edits)
        reached = now + len(labels)
        self._notify("Followed", f"for {len(labels)} frames. Check the last one and correct it.")
        self._go_to(reached)

    def _describe(self, **fields: object) -> None:
        self._boxes.change(replace(self._boxes.told()[1], **fields))  # pyright: ignore[reportArgumentType]

    def _between(
        self, box_id: str, first: tuple[int, LabelledBox], last: tuple[int, LabelledBox]
    ) -> list[BoxEdit]:
        """The frames between two rows with the box evenly between."""
        times_ns = self._place.opened.series.time_ns
        start_ns, end_ns = int(times_ns[first[0]]), int(times_ns[last[0]])
        at = partial(interpolated, first[1], last[1])
        return [
            BoxEdit(
                self._frame(row),
                box_id,
                at((int(times_ns[row]) - start_ns) / (end_ns - start_ns)),
                MadeBy.INTERPOLATED,
            )
            for row in range(first[0] + 1, last[0])
        ]

    def _drawn_row(self, box_id: str, rows: range) -> tuple[int, LabelledBox] | None:
        """The first of some rows in which somebody drew a box by hand, with it."""
        frames = self._place.review.review.frames
        if not frames:
            return None
        for row in rows:
            frame = frames.get(self._frame(row))
            label = frame.labels.get(box_id) if frame else None
            if label is not None and self._made_by(box_id, row) is MadeBy.HAND:
                return row, label
        return None

    def _made_by(self, box_id: str, row: int) -> MadeBy | None:
        if row > self._place.opened.last_row:
            return None
        frame = self._place.review.review.frames.get(self._frame(row))
        edits = frame.edits.get(box_id) if frame else None
        return edits[-1].said.made_by if edits else None

    def _frame(self, row: int) -> int:
        return self._place.opened.frame_index(row)
