"""What the next unjudged event shows is there before somebody goes to it."""

import shutil
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from review_drives import QUIET_S, write_drive

from fcw.logs.pictures import LogPictures
from fcw_viz.review_app.picture.frames import FramePictures
from fcw_viz.review_app.place import Place
from fcw_viz.review_app.session import ReviewSession
from fcw_viz.review_app.triage.ahead import Ahead


def wait_until_read() -> None:
    for thread in threading.enumerate():
        if thread.name == "read ahead":
            thread.join(60)


def test_the_picture_of_the_next_unjudged_event_is_decoded_before_it_is_asked_for(
    drive_log: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    drives = {
        "quiet": write_drive(tmp_path / "quiet" / "drive.mcap", QUIET_S),
        "made": Path(shutil.copy(drive_log, tmp_path)),
    }
    session = ReviewSession(drives, "anna")
    session.folder.start()
    try:
        end_s = time.monotonic() + 60
        while session.unread and time.monotonic() < end_s:
            time.sleep(0.01)
        place = Place(session)
        ahead = Ahead(place)
        ahead.look()
        wait_until_read()
        found = place.asked.next_unjudged(session.cards, None, None)
        assert found is not None
        drive = session.open(place, found[0])
        place.enter(drive, found[1], None)
        expected, _ = FramePictures(drive).image(place.row, None)

        def decode(*_: object) -> None:
            raise AssertionError("decoded anew")

        monkeypatch.setattr(LogPictures, "_seek", decode)
        shown, trouble = ahead.take(drive).image(place.row, None)
        assert trouble == ""
        assert np.array_equal(shown, expected)
        with pytest.raises(AssertionError, match="anew"):
            ahead.take(drive).image(place.row, None)  # it is given away once
        ahead.close()
    finally:
        session.close()
