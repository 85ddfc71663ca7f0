"""Runs rerun's command line and ends it when the program that wanted it is gone, however that ended.

`python -m fcw_viz.rerun.supervisor ARGUMENTS`, as the leader of a process group. Its standard input is a pipe
that nobody writes to: it ends with the program at its other side, kill -9 included.
"""

import os
import signal
import subprocess
import sys
import threading
import time

PATIENCE_S = 5.0


def main() -> None:
    """Run it to its end, whose exit code is this one's, or to that of the standard input."""
    rerun = subprocess.Popen([sys.executable, "-m", "rerun_cli", *sys.argv[1:]], stdin=subprocess.DEVNULL)
    threading.Thread(target=lambda: os._exit(rerun.wait()), daemon=True).start()
    sys.stdin.buffer.read()
    if sys.platform == "win32":
        command = ["taskkill", "/T", "/F", "/PID", str(rerun.pid)]
        subprocess.run(command, capture_output=True, check=False)
        return
    # rerun's Python wrapper leaves its child behind: the whole group is ended.
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    os.killpg(0, signal.SIGTERM)
    time.sleep(PATIENCE_S)
    os.killpg(0, signal.SIGKILL)


if __name__ == "__main__":
    main()
