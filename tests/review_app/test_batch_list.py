"""A batch's list is shown without opening its logs."""

import re
import threading
from dataclasses import replace
from pathlib import Path

from export_drives import drive_header, marked_drive, write_log

from fcw.batch.ledger import DRIVES_NAME, Record, State, write_record
from fcw.batch.review_list import read_review_list
from fcw.batch.tables import unfinished_drives, write_tables
from fcw.logs.export.clip import find_drives
from fcw.logs.names import MCAP_NAME
from fcw_viz.review_app.drive import Drive
from fcw_viz.review_app.drive_card import DriveCard, listed_card, read_card
from fcw_viz.review_app.folder import Folder
from fcw_viz.review_app.panels.folder_list import folder_html
from fcw_viz.review_app.triage.drive_filter import DriveFilter, Listed, Order


def test_what_the_batch_wrote_is_shown_without_opening_a_log(tmp_path, monkeypatch):
    drive = marked_drive(60)
    for name in ("a", "b"):
        write_log(tmp_path / name / MCAP_NAME, drive, drive_header())
    write_tables(
        tmp_path, [Record(name, f"/{name}.mp4", "van", State.DONE, duration_s=2.4) for name in ("a", "b")]
    )
    later = write_log(tmp_path / "later" / MCAP_NAME, drive, drive_header())
    opened: list[Path] = []
    open_drive = Drive.open
    monkeypatch.setattr(Drive, "open", lambda name, path: (opened.append(path), open_drive(name, path))[1])
    told = threading.Event()
    folder = Folder(find_drives([tmp_path]), tmp_path, lambda: told.set() if not folder.unread else None)
    folder.start()
    try:
        assert told.wait(60)
    finally:
        folder.close()
    assert {card.name for card in folder.cards if card.read and card.events} == {"a", "b", "later"}
    assert set(opened) == {later.path}  # its events, and its picture


def test_drives_that_a_batch_has_not_done_are_followed_with_their_reasons(tmp_path):
    write_log(tmp_path / "a" / MCAP_NAME, marked_drive(60), drive_header())
    done = Record("a", "/a.mp4", "van", State.DONE, duration_s=2.4)
    torn = Record("torn", "/torn.mp4", "bus", State.FAILED, "/torn.mp4: cannot be read; copy it again")
    write_tables(tmp_path, [done, torn])
    told = threading.Event()
    folder = Folder(find_drives([tmp_path]), tmp_path, told.set)
    folder.start()
    try:
        assert told.wait(60)
        assert folder.unfinished == (torn,)
        html = folder_html("drives", folder.cards, 0, 1000.0, unfinished=folder.unfinished)
        assert "1 drive not done" in html
        asked = DriveFilter(listed=Listed.UNFINISHED)
        html = folder_html("drives", folder.cards, 0, 1000.0, asked, unfinished=folder.unfinished)
        assert all(words in html for words in ("torn", "bus", "failed"))
        assert f'<p class="fcw-told">{torn.reason}</p>' in html  # which is as wide as its row
        told.clear()
        write_tables(tmp_path, [done])
        while folder.unfinished:
            assert told.wait(60)
    finally:
        folder.close()
    (tmp_path / DRIVES_NAME).write_bytes(b"PAR1")
    assert unfinished_drives(tmp_path) == ()


def test_of_a_batch_without_a_drive_that_is_done_the_list_says_why_at_once(tmp_path):
    torn = Record("torn", "/torn.mp4", "bus", State.FAILED, "/torn.mp4: cannot be read; copy it again")
    write_tables(tmp_path, [torn])
    html = folder_html("drives", [], 0, 1000.0, unfinished=unfinished_drives(tmp_path))
    assert "Drives that the batch has not done, and why" in html
    assert torn.reason in html


def test_keys_lead_to_every_row_and_open_those_that_have_something_to_open(tmp_path):
    whole = DriveCard("whole", tmp_path)
    cards = [whole, replace(whole, name="unread", read=False), replace(whole, name="torn", trouble="torn")]
    torn = Record("lost", "/lost.mp4", "bus", State.LOST, "/lost.mp4: not finished")
    for listed, names, opening in (
        (Listed.DRIVES, {"whole", "unread", "torn"}, 2),
        (Listed.UNFINISHED, {"lost"}, 0),
    ):
        html = folder_html("drives", cards, 0, 1000.0, DriveFilter(listed=listed), unfinished=[torn])
        assert set(re.findall('data-fcw-item="(.*?)" tabindex="0"', html)) == names
        assert html.count('role="link"') == opening


def test_drives_of_a_batch_show_their_cameras_and_where_files_have_one_name_their_paths(tmp_path):
    files = {"FILE0001": ("van", "/mon/van/FILE0001.mp4"), "FILE0001-1f": ("van", "/tue/van/FILE0001.mp4")}
    files |= {"own": ("bus", "/mon/bus/own.mp4")}
    records = []
    for name, (camera, file) in files.items():
        write_log(tmp_path / name / MCAP_NAME, marked_drive(30), drive_header())
        records.append(Record(name, file, camera, State.DONE, duration_s=1.2))
        write_record(records[-1], tmp_path / name)
    write_tables(tmp_path, records)
    listed = read_review_list(tmp_path)
    assert len(listed) == 3
    for cards in (
        [listed_card(log.parent.name, log, one) for log, one in listed.items()],
        [read_card(log.parent.name, log) for log in listed],
    ):
        _, *rows = folder_html("drives", cards, 0, 1000.0, DriveFilter(order=Order.NAME)).split("<header>")
        for row, (name, (camera, file)) in zip(rows, files.items(), strict=True):
            assert f"<b>{name}</b><span>{camera}</span>" in row
            assert (file in row) == (name != "own")


def test_a_long_list_is_drawn_in_parts(tmp_path):
    cards = [DriveCard(f"drive {number}", tmp_path / str(number), read=False) for number in range(300)]
    html = folder_html("drives", cards, 300, 1000.0)
    assert html.count("fcw-row") == 30
    assert "200 of 270 more drives" in html
    assert "70 more drives" in folder_html("drives", cards, 300, 1000.0, most=230)
    assert "more drives" not in folder_html("drives", cards, 300, 1000.0, most=430)
