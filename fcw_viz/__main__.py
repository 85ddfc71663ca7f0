"""Where the program begins, as `fcw` and as `python -m fcw_viz`.

The command line takes a part of a second to load. Whoever ends the program meanwhile gets the same word and
exit code as later.
"""

import sys

from fcw_viz.exit_codes import EXIT_INTERRUPTED, EXIT_WRONG_INPUT
from fcw_viz.signals import keep_exit_code, signals_as_interrupts
from fcw_viz.system_limits import limits_trouble
from fcw_viz.unread_output import go_on_unread


def main() -> int:
    """Load the command line and run it; returns the exit code."""
    go_on_unread()
    if trouble := limits_trouble():
        sys.stderr.write(f"fcw: {trouble}\n")
        return EXIT_WRONG_INPUT
    try:
        with signals_as_interrupts():
            from fcw_viz.cli import main as run_command_line

            code = run_command_line()
    except KeyboardInterrupt:
        sys.stderr.write("fcw: interrupted\n")
        code = EXIT_INTERRUPTED
    keep_exit_code(code)
    return code


if __name__ == "__main__":
    sys.exit(main())
