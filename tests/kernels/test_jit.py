"""Kernels on machines that let little or nothing be kept."""

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from numba.core import caching

from fcw.kernels.jit import in_whole_registers, kernel, private_temporary_folder

ROOT = Path(__file__).parents[2]
SOURCE = """
from fcw.kernels.jit import kernel

@kernel()
def double(x):
    return 2 * x

if __name__ == "__main__":
    import a_kernel
    print(a_kernel.double(21), sum(a_kernel.double.stats.cache_hits.values()))
"""


@pytest.fixture
def read_only_install(tmp_path: Path) -> Path:
    """A module in a folder where no cache can be made, also not by root: a file stands in its place."""
    install = tmp_path / "install"
    install.mkdir()
    (install / "a_kernel.py").write_text(SOURCE)
    (install / "__pycache__").write_text("not a folder")
    return install


def run(install: Path, temporary: Path, home: str | None = "/dev/null/no-home") -> tuple[int, int]:
    """What the kernel gives in a process of its own, and how often it was loaded and not compiled."""
    environment = {
        name: value for name, value in os.environ.items() if name not in ("HOME", "XDG_CACHE_HOME")
    }
    environment |= {"PYTHONPATH": f"{ROOT}:{install}", "TMPDIR": str(temporary)}
    if home is not None:
        environment["HOME"] = home
    process = subprocess.run(
        [sys.executable, str(install / "a_kernel.py")], env=environment, capture_output=True, text=True
    )
    assert process.returncode == 0, process.stderr
    value, hits = map(int, process.stdout.split())
    return value, hits


@pytest.mark.slow
def test_in_a_read_only_install_without_a_home_kernels_are_kept_for_the_next_process(
    read_only_install: Path, tmp_path: Path
) -> None:
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    assert run(read_only_install, temporary) == (42, 0)
    (folder,) = temporary.glob("fcw-kernels*")
    assert list(folder.rglob("*.nbi"))
    assert run(read_only_install, temporary) == (42, 1)


@pytest.mark.slow
def test_kernels_that_were_compiled_here_give_what_loaded_ones_do(tmp_path: Path) -> None:
    program = (
        "import hashlib, numpy as np\n"
        "from fcw.detection.channels.aggregated import compute_channels\n"
        "picture = np.random.default_rng(0).integers(0, 256, (480, 854, 3), np.uint8)\n"
        "print(hashlib.sha256(compute_channels(picture).tobytes()).hexdigest())"
    )
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": str(ROOT)}
    compiled, loaded = (
        subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, check=True)
        for _ in range(2)
    )
    assert compiled.stdout == loaded.stdout


@pytest.mark.slow
def test_a_kernel_is_compiled_anew_when_a_constant_in_another_file_changes(tmp_path: Path) -> None:
    install = tmp_path / "install"
    install.mkdir()
    (install / "a_kernel.py").write_text(
        SOURCE.replace("2 * x", "FACTOR * x").replace("@", "from b import FACTOR\n\n@", 1)
    )
    (install / "b.py").write_text("FACTOR = 2\n")
    assert run(install, tmp_path) == (42, 0)
    assert run(install, tmp_path) == (42, 1)
    (install / "b.py").write_text("FACTOR = 3\n")
    assert run(install, tmp_path) == (63, 0)


@pytest.mark.slow
def test_of_processes_that_want_a_kernel_at_once_one_compiles_it(tmp_path: Path) -> None:
    (tmp_path / "a_kernel.py").write_text(SOURCE)
    with ThreadPoolExecutor() as at_once:
        ran = [at_once.submit(run, tmp_path, tmp_path) for _ in range(3)]
    assert sorted(one.result() for one in ran) == [(42, 0), (42, 1), (42, 1)]


@pytest.mark.slow
def test_with_home_unset_a_kernel_runs(read_only_install: Path, tmp_path: Path) -> None:
    assert run(read_only_install, tmp_path, home=None)[0] == 42


def test_where_nothing_can_be_kept_a_kernel_is_compiled_each_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "plain.py").write_text("def double(x):\n    return 2 * x\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(caching.CompileResultCacheImpl, "_locator_classes", [])
    import plain  # pyright: ignore[reportMissingImports]

    monkeypatch.delitem(sys.modules, "plain")
    assert kernel()(plain.double)(21) == 42


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="users share the temporary folder on POSIX alone")
def test_a_folder_that_others_can_write_to_is_not_trusted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    folder = private_temporary_folder()
    assert folder is not None
    assert folder.stat().st_mode & 0o777 == 0o700
    folder.chmod(0o777)
    assert private_temporary_folder() is None
    folder.rmdir()
    folder.symlink_to(tmp_path)
    assert private_temporary_folder() is None
    folder.unlink()
    folder.write_text("a file")
    assert private_temporary_folder() is None


def test_only_processors_with_wide_registers_are_told_to_use_them():
    assert in_whole_registers("+avx2,+fma,-avx512f") is None
    assert in_whole_registers("") is None
    told = in_whole_registers("+avx2,+avx512f,+fma")
    assert told is not None
    assert told.split(",")[-1] == "-prefer-256-bit"
