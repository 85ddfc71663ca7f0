"""What is wrong with a drive's review files is read on the page, also when it goes wrong later."""

import json
from pathlib import Path

from review_helpers import OpenPage, Review, Reviewer, WaitFor

from fcw.annotation.store import review_path


def test_a_file_that_is_no_review_is_named_in_the_list_and_in_the_drive(
    drive_log: Path, review: Review, open_page: OpenPage, wait_for: WaitFor
):
    path = review_path(drive_log, "bert")
    path.write_text("my notes\n")
    person = Reviewer(open_page(review({"made": drive_log, "again": drive_log}).url, picture=False))
    wait_for(lambda: "bert.jsonl: not a review of fcw" in person.words(".fcw-row .fcw-troubles"))
    person.at(".fcw-row .fcw-mark").click()
    wait_for(lambda: person.row >= 0)
    panel = ".mantine-Paper-root .fcw-troubles"
    wait_for(lambda: "bert.jsonl: not a review of fcw" in person.words(panel))
    path.unlink()
    wait_for(lambda: not person.words(panel))


def test_what_the_run_told_is_read_in_the_list_and_among_the_notes(
    drive_log: Path, review: Review, open_page: OpenPage, wait_for: WaitFor
):
    told = "5.0 pictures a second: tracking is made for 10 and more"
    drive_log.with_name("summary.json").write_text(json.dumps({"notes": [told]}))
    person = Reviewer(open_page(review({"made": drive_log, "again": drive_log}).url, picture=False))
    wait_for(lambda: told in person.words(".fcw-row .fcw-told"))
    person.at(".fcw-row .fcw-mark").click()
    wait_for(lambda: person.row >= 0)
    person.tab("Notes")
    wait_for(lambda: told in person.words(".mantine-Paper-root .fcw-told"))
