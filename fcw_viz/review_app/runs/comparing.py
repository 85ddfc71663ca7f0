"""The run that a person compares the open one with, and the differences between the two."""

import threading
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from fcw.detection.boxes.overlap import intersection_over_union
from fcw.errors import UserError
from fcw.logs.comparison import LEAST_OVERLAP, Difference, find_differences, matching_rows
from fcw.logs.events import DriveEvent
from fcw.tracking.types import Track
from fcw_viz.page.controls import Run as InOrder
from fcw_viz.review_app.drive import Drive
from fcw_viz.review_app.drive_card import DriveCard
from fcw_viz.review_app.place import Place


class Comparing:
    """The other run of one tab, in the tab's thread.

    Attributes:
        other: the run that is compared with; None for none.
        differences: by time; None while they are looked for.
        at: number of the one that was gone to last; None for none.
    """

    def __init__(
        self,
        place: Place,
        run: InOrder,
        go_to_time: Callable[[float], object],
        changed: Callable[[], object],
    ) -> None:
        """Compare with nothing.

        Args:
            place: where the person is.
            run: runs work in the tab's thread.
            go_to_time: shows a moment of the open drive.
            changed: draws it.
        """
        self._place, self._run = place, run
        self._go_to_time, self._changed = go_to_time, changed
        self.other: Drive | None = None
        self.differences: tuple[Difference, ...] | None = ()
        self.at: int | None = None
        self._compared: tuple[object, object] = None, None

    @property
    def messages(self) -> Mapping[str, Callable[[str], object]]:
        """What the page says, and what is done then."""
        return {"compare": self.choose, "difference": lambda about: self.go_to(int(about))}

    def candidates(self, cards: Sequence[DriveCard]) -> list[str]:
        """Names of the other runs over the same source, as the list of drives knows them."""
        drive = self._place.opened
        return sorted(
            card.name for card in cards if card.source == drive.header.source and card.name != drive.name
        )

    def choose(self, name: str) -> None:
        """Compare with another run from now on; an empty name for none.

        Raises:
            UserError: it cannot be read, or the two share no time.
        """
        place = self._place
        self.leave()
        if name:
            drive, other = place.opened, place.session.open(self, name)
            if not len(matching_rows(drive.series, other.series)[0]):
                place.session.release(self)
                self._changed()
                raise UserError(
                    f"{name!r} does not overlap this drive in time: choose another run of "
                    f"{drive.header.source}"
                )
            self.other, self.differences = other, None
            self._compared = drive.origin, other.origin
            threading.Thread(target=self._find, args=(drive, other), name="differences", daemon=True).start()
        self._changed()

    def leave(self) -> None:
        """Compare with nothing."""
        self.other, self.differences, self.at = None, (), None
        self._place.session.release(self)

    def follow(self) -> None:
        """Go on with the other run as its log stands by now; compare anew where one of them was run again."""
        if self.other is None:
            return
        name = self.other.name
        self.other = self._place.session.current(name)
        if (self._place.opened.origin, self.other.origin) != self._compared:
            self.choose(name)

    def go_to(self, number: int) -> None:
        """Show a difference where it is largest."""
        if self.differences and 0 <= number < len(self.differences):
            self.at = number
            self._go_to_time(self.differences[number].peak_s)
            self._changed()

    def step(self, forward: bool) -> None:
        """Go to the next difference, or to the one before.

        Raises:
            UserError: there is none.
        """
        if self.other is None:
            raise UserError("choose a run to compare with first, under Runs")
        if not self.differences:
            raise UserError(
                "the two runs are still being compared" if self.differences is None else "no difference"
            )
        time_s, peaks_s = self._place.time_s, [one.peak_s for one in self.differences]
        # Whoever is at the one gone to last goes on from there; several may be of one moment.
        if self.at is not None and abs(peaks_s[self.at] - time_s) < 0.1:
            number = self.at + (1 if forward else -1)
        elif forward:
            number = next((k for k, peak_s in enumerate(peaks_s) if peak_s > time_s), len(peaks_s) - 1)
        else:
            number = max((k for k, peak_s in enumerate(peaks_s) if peak_s < time_s), default=0)
        self.go_to(min(max(number, 0), len(peaks_s) - 1))

    def row_at(self, row: int) -> int | None:
        """The other run's row of the same moment; None where there is none."""
        if self.other is None:
            return None
        time_ns = int(self._place.opened.series.time_ns[row])
        other = self.other.series.row_at(time_ns)
        step_ns = 1e9 / self._place.opened.header.frame_rate_hz
        return other if abs(int(self.other.series.time_ns[other]) - time_ns) <= step_ns / 2 else None

    def events(self) -> tuple[DriveEvent, ...]:
        """The other run's."""
        return () if self.other is None else self.other.events

    @property
    def later_s(self) -> float:
        """How much later the other run begins than the open one."""
        return 0.0 if self.other is None else (self.other.first_ns - self._place.opened.first_ns) / 1e9

    def _find(self, drive: Drive, other: Drive) -> None:
        """Find the differences; in a thread of its own."""
        try:
            found = find_differences(
                drive.series, other.series, lambda *rows: _same_lead(drive, other, *rows)
            )
        except UserError:
            found = ()  # a damaged log says so where its frames are shown
        self._run(lambda: self._found(other, found))

    def _found(self, other: Drive, differences: tuple[Difference, ...]) -> None:
        if self.other is other and self._place.drive is not None:
            self.differences = differences
            self._changed()


def _same_lead(drive: Drive, other: Drive, row: int, other_row: int) -> bool:
    """Whether the leads of two runs at one moment have one box."""
    boxes = [
        np.array([[track.box.x, track.box.y, track.box.w, track.box.h]])
        for track in (_lead(drive, row), _lead(other, other_row))
        if track is not None
    ]
    return len(boxes) == 2 and float(intersection_over_union(*boxes)[0, 0]) >= LEAST_OVERLAP


def _lead(drive: Drive, row: int) -> Track | None:
    return drive.log.result_at(drive.frame_index(row)).lead
