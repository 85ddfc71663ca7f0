"""`fcw review --rerun`: the rerun viewer on a logged drive, as long as somebody looks."""

import tempfile
import webbrowser
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fcw.errors import UserError
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.names import MCAP_NAME, RRD_NAME
from fcw_viz.commands.review.options import ReviewCommand
from fcw_viz.console import RESULTS, note
from fcw_viz.jobs.drive import stop_on_interrupt
from fcw_viz.rerun.log import RerunSink
from fcw_viz.rerun.viewer import FOREIGN_WORDS, Viewer, has_display, native_viewer, web_viewer

LOOK_S = 0.2
"""How often to look whether the window was closed."""


def review_in_rerun(command: ReviewCommand) -> int:
    """Start the viewer and end it, with its children, on Ctrl-C; returns the exit code.

    Raises:
        UserError: there is no drive, the port is taken, or the viewer does not start.
    """
    in_window = has_display() and not command.no_open and command.port is None
    with stop_on_interrupt() as stop, _recording(command.path) as recording:
        if stop.is_set():
            return 0
        with native_viewer(recording) if in_window else web_viewer(recording, command.port) as viewer:
            _announce(viewer, recording, command.no_open)
            while viewer.process.poll() is None and not stop.wait(LOOK_S):
                pass
    return 0


def _announce(viewer: Viewer, recording: Path, no_open: bool) -> None:
    if viewer.url is None:
        RESULTS.print(f"{recording} in the rerun viewer (Ctrl-C ends)", soft_wrap=True)
        return
    RESULTS.print(f"{recording} in the rerun viewer at {viewer.url} (Ctrl-C ends)", soft_wrap=True)
    note(FOREIGN_WORDS)
    if not no_open and viewer.ticket_url is not None:
        webbrowser.open(viewer.ticket_url)


@contextmanager
def _recording(path: Path) -> Iterator[Path]:
    """The drive's recording; made for the time of the review where there is only the MCAP log."""
    rrd = path / RRD_NAME if path.is_dir() else path.with_suffix(".rrd")
    mcap = path / MCAP_NAME if path.is_dir() else path.with_suffix(".mcap")
    if rrd.is_file():
        yield rrd
    elif mcap.is_file():
        log = DriveLog(mcap)
        with tempfile.TemporaryDirectory() as folder:
            made = Path(folder) / RRD_NAME
            RESULTS.print(f"no {rrd.name} beside {mcap}: making one to look at", soft_wrap=True)
            sink = RerunSink(made)
            sink.open(log.header)
            try:
                for result, packets in log.entries():
                    sink.write(result, packets)
            finally:
                sink.close()
            yield made
    else:
        raise UserError(
            f"{path}: not a drive; expected a folder written by `fcw run`, a drive.mcap or a drive.rrd"
        )
