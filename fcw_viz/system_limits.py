"""What the shell lets a program have: too little is said at once, before libraries fail in their own ways."""

import sys
from contextlib import suppress

from fcw.threads import available_cores

FEWEST_FILES = 64
WANTED_FILES = 1024
"""A page has one for each tab and each of its files."""
LEAST_MEMORY_MB, MEMORY_OF_A_CORE_MB = 4000, 200
"""Of addresses, not of memory used: each thread reserves 72 MB, and on more cores there are more of them.

`fcw run` reaches 3.9 GB on one core, 4.2 on two, 4.5 on four; with less, libraries end it in the middle.
"""


def limits_trouble() -> str:
    """Why this program cannot run within the limits of its shell, and the mend; empty where it can.

    A limit on open files that may be raised is raised.
    """
    if sys.platform == "win32":
        return ""
    import resource

    files, most_files = resource.getrlimit(resource.RLIMIT_NOFILE)
    if 0 <= files < WANTED_FILES:
        wanted = WANTED_FILES if most_files == resource.RLIM_INFINITY else min(WANTED_FILES, most_files)
        with suppress(OSError, ValueError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, most_files))
            files = wanted
        if files < FEWEST_FILES:
            return (
                f"a program here may have {files} files open (ulimit -n), expected at least {FEWEST_FILES}; "
                f"raise the limit: ulimit -n {WANTED_FILES}"
            )
    memory = resource.getrlimit(resource.RLIMIT_AS)[0]
    least_mb = LEAST_MEMORY_MB + MEMORY_OF_A_CORE_MB * available_cores()
    if memory != resource.RLIM_INFINITY and memory < least_mb << 20:
        return (
            f"a program here may have {memory >> 20} MB of memory (ulimit -v), expected at least "
            f"{least_mb} MB; raise the limit: ulimit -v unlimited"
        )
    return ""
