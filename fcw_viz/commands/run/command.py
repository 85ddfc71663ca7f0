"""`fcw run`: on a file as fast as it goes, or live."""

from pathlib import Path

from fcw_viz.commands.run.options import RunCommand, job_of
from fcw_viz.commands.run.report import report_drive
from fcw_viz.exit_codes import EXIT_INTERRUPTED


def run_run(command: RunCommand) -> int:
    """Run `fcw run`; returns the exit code."""
    from fcw.errors import UserError
    from fcw.sources.camera import is_camera
    from fcw_viz.console import RESULTS, note, print_json
    from fcw_viz.jobs.drive import run_on_console

    if command.live:
        from fcw_viz.commands.run.live import run_live

        return run_live(command)
    if command.port is not None or command.no_open:
        raise UserError("--port and --no-open need --live; add it, or leave them out")
    path = Path(command.source)
    if not path.exists() and is_camera(command.source):
        raise UserError(f"{command.source}: a camera needs --live; add it")
    job = job_of(command, path)
    rerun_log = not command.no_rerun_log
    outcome = run_on_console(job, rerun_log=rerun_log)
    for text in outcome.notes:
        note(text)
    if command.json:
        print_json(outcome.summary)
    else:
        report_drive(outcome, job.out, RESULTS, imperial=job.imperial, rerun_log=rerun_log)
    return EXIT_INTERRUPTED if outcome.interrupted else 0
