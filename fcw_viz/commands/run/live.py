"""`fcw run --live`: the pipeline on a camera, or on a file at its own rate, with a page that shows it."""

import threading
from datetime import datetime
from pathlib import Path
from shlex import quote

from fcw.camera.file import calibration_path, read_calibration
from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw.job import DriveJob, load_calibration
from fcw.logs.names import MCAP_NAME
from fcw.sources import is_mcap, open_source
from fcw.sources.camera import CameraSource, camera_name, is_camera
from fcw.sources.live import LiveSource
from fcw_viz.commands.demo import demo_folder
from fcw_viz.commands.review.page import login_name
from fcw_viz.commands.run.options import RECORDINGS, RunCommand, job_of
from fcw_viz.commands.run.report import report_drive
from fcw_viz.console import MESSAGES, RESULTS, note, print_json
from fcw_viz.exit_codes import EXIT_INTERRUPTED
from fcw_viz.jobs.drive import run_on_console
from fcw_viz.jobs.rehearsal import rehearse
from fcw_viz.live_app.feed import LiveFeed
from fcw_viz.live_app.server import FOR_FIRST_PICTURE, LivePage
from fcw_viz.page.server import DEFAULT_PORT

GETTING_READY = "getting ready: the first time kernels are compiled, which takes up to two minutes"


def run_live(command: RunCommand) -> int:
    """Run the drive to its end or to Ctrl-C, with complete logs; then, at its end, serve its review.

    Raises:
        UserError: the source, the calibration or an option is wrong.
        KeyboardInterrupt: the end of the review, or before the first picture.
    """
    camera = is_camera(command.source)
    # A camera's drives must not replace each other: they have no names of their own.
    name = f"{camera_name(command.source)}-{datetime.now():%Y%m%d-%H%M%S}"
    out = command.out or (RECORDINGS / name if camera else None)
    job = job_of(command, Path(camera_name(command.source)) if camera else Path(command.source), out)
    stop = threading.Event()
    source = _open_camera(command, job, stop) if camera else _open_file(job, stop)
    if not is_mcap(job.source):
        load_calibration(job, source)  # before a page is opened
    feed = LiveFeed(source)
    port = DEFAULT_PORT if command.port is None else command.port
    # A camera's name is no file's: what follows its last dot belongs to it.
    page = LivePage(feed, source.name if camera else job.source.stem or source.name, port)
    try:
        page.say_waiting(GETTING_READY)
        page.announce(MESSAGES, "live", "Ctrl-C ends the drive, with complete logs", not command.no_open)
        MESSAGES.print(GETTING_READY)
        rehearse(job, demo_folder() / "drive.mp4")
        page.say_waiting(FOR_FIRST_PICTURE)
        rerun_log = not command.no_rerun_log
        outcome = run_on_console(job, MESSAGES, source, (feed,), stop, rerun_log)
        for text in outcome.notes:
            note(text)
        if command.json:
            print_json(outcome.summary)
        else:
            report_drive(outcome, job.out, RESULTS, imperial=job.imperial, rerun_log=rerun_log)
        if outcome.interrupted or not outcome.summary["frames"]:
            page.say_ended(f"The drive was ended by hand. Look at it with: fcw review {quote(str(job.out))}")
            return EXIT_INTERRUPTED
        page.review(job.out / MCAP_NAME, login_name())
        MESSAGES.print(f"the drive has ended; its review is at {page.url} (Ctrl-C ends; everything is saved)")
        page.wait()
    finally:
        page.stop()
    return 0


def _open_file(job: DriveJob, stop: threading.Event) -> LiveSource:
    """A recording, played at its own rate."""
    return LiveSource(open_source(job.source, job.frame_rate_hz, job.topic), stop)


def _open_camera(command: RunCommand, job: DriveJob, stop: threading.Event) -> LiveSource:
    """A camera, asked for pictures as large as its calibration is for."""
    if command.frame_rate is not None or command.topic is not None:
        raise UserError(f"{command.source}: a camera has neither --frame-rate nor --topic; leave them out")
    source = CameraSource(command.source, _calibrated_size(command, job))
    return LiveSource(source, stop, paced=source.recorded)


def _calibrated_size(command: RunCommand, job: DriveJob) -> ImageSize:
    path = command.calibration or calibration_path(job.source)
    if not path.is_file():
        raise UserError(
            f"{path}: no calibration for {job.source}; make one with `fcw calibrate --points ... "
            f"--height ... --image-size WxH --save {quote(str(path))}`, or name an existing one with "
            "--calibration"
        )
    return read_calibration(path).image_size
