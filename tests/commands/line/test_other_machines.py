"""The program on machines that are not ours: Windows, other code pages, nowhere to keep anything.

Windows is played by taking away what its Python does not have.
"""

import os
import subprocess
import sys
import tempfile
import types
from pathlib import Path

import pytest

from fcw.files import write_whole
from fcw.kernels.jit import private_temporary_folder
from fcw.locked_file import LockedFile
from fcw_viz.commands.review.page import login_name

ROOT = Path(__file__).parents[3]
POINTS = ["--points", "10:400", "20:350", "40:325", "--image-size", "1280x720", "--height", "1.3"]
ALL_MODULES = """
import importlib, pkgutil
import fcw, fcw_viz

def load_all():
    for package in (fcw, fcw_viz):
        for module in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
            needs_torch = module.name.startswith("fcw.detection.net.training.")
            if not needs_torch and not module.name.endswith("__main__"):
                importlib.import_module(module.name)
"""
AS_ON_WINDOWS = f"""{ALL_MODULES}
import os, signal, sys, types
load_all()  # the libraries of others too, which have files of their own for Windows
for name in [name for name in sys.modules if name.split(".")[0] in ("fcw", "fcw_viz")]:
    del sys.modules[name]
sys.modules |= dict.fromkeys(("fcntl", "resource", "pwd", "grp", "termios"))
sys.modules["msvcrt"] = types.ModuleType("msvcrt")
for module, names in (
    (os, "fork getuid geteuid killpg getloadavg sysconf sched_getaffinity O_NOFOLLOW O_NONBLOCK O_CLOEXEC"),
    (signal, "SIGHUP SIGKILL SIGALRM SIGPIPE setitimer"),
):
    for name in names.split():
        delattr(module, name)
sys.platform = "win32"
import fcw, fcw_viz
load_all()
from fcw_viz.cli import main
sys.exit(main(sys.argv[1:]))
"""


def in_python(*arguments: str, **environment: str) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(
        [sys.executable, *arguments],
        env=os.environ | {"PYTHONPATH": str(ROOT)} | environment,
        capture_output=True,
    )


@pytest.mark.slow
def test_all_modules_load_and_a_camera_is_calibrated_without_what_windows_lacks(tmp_path: Path) -> None:
    save = tmp_path / "camera.yaml"
    process = in_python("-c", AS_ON_WINDOWS, "calibrate", *POINTS, "--save", str(save))
    assert process.returncode == 0, process.stderr.decode()
    assert save.is_file()


@pytest.mark.slow
def test_no_text_file_is_read_in_the_code_page_of_the_machine() -> None:
    process = in_python(
        *("-X", "warn_default_encoding", "-c"),
        f"{ALL_MODULES}\nimport warnings\n"
        'warnings.filterwarnings("error", category=EncodingWarning, module=r"fcw(_viz)?\\.")\nload_all()',
    )
    assert process.returncode == 0, process.stderr.decode()


@pytest.mark.parametrize(
    ("encoding", "pitch"), [("utf-8", "4.33 ± 1.55"), ("cp1252", "4.33 ± 1.55"), ("ascii", r"4.33 \xb1 1.55")]
)
def test_results_are_printed_in_any_code_page(encoding: str, pitch: str) -> None:
    process = in_python("-m", "fcw_viz", "calibrate", *POINTS, PYTHONIOENCODING=encoding)
    assert process.returncode == 0, process.stderr.decode()
    assert f"pitch {pitch} degrees down" in process.stdout.decode(encoding)


def test_help_is_printed_in_a_code_page_without_its_characters() -> None:
    process = in_python("-m", "fcw_viz", "--help", PYTHONIOENCODING="cp437")
    assert process.returncode == 0, process.stderr.decode()
    assert b"calibrate" in process.stdout


def test_line_ends_are_the_same_on_every_machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plain_open = Path.open

    def with_windows_line_ends(
        path: Path,
        mode: str = "r",
        buffering: int = -1,
        encoding: str | None = None,
        errors: str | None = None,
        newline: str | None = None,
    ) -> object:
        ends = "\r\n" if "b" not in mode and newline is None else newline
        return plain_open(path, mode, buffering, encoding, errors, ends)

    monkeypatch.setattr(Path, "open", with_windows_line_ends)
    write_whole(tmp_path / "table.csv", "a,b\n1,2\n")
    assert (tmp_path / "table.csv").read_bytes() == b"a,b\n1,2\n"


def test_where_open_files_cannot_be_removed_a_lock_goes_away_all_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "platform", "win32")
    locking = types.SimpleNamespace(LK_NBLCK=2, locking=lambda descriptor, mode, count: None)
    monkeypatch.setattr("fcw.locked_file.msvcrt", locking, raising=False)
    lock = LockedFile.open(tmp_path / "lock")
    assert lock is not None
    plain_unlink = Path.unlink

    def unlink_unless_open(path: Path) -> None:
        if not lock.closed:
            raise PermissionError(13, "used by another process")
        plain_unlink(path)

    monkeypatch.setattr(Path, "unlink", unlink_unless_open)
    lock.remove(tmp_path / "lock")
    assert not (tmp_path / "lock").exists()


def test_somebody_whom_windows_does_not_name_can_review(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("LOGNAME", "USER", "LNAME", "USERNAME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setitem(sys.modules, "pwd", None)
    assert login_name() == "reviewer"


def test_without_any_folder_for_temporary_files_kernels_are_not_kept_there(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def none_usable() -> str:
        raise FileNotFoundError(2, "No usable temporary directory found")

    monkeypatch.setattr(tempfile, "gettempdir", none_usable)
    assert private_temporary_folder() is None
