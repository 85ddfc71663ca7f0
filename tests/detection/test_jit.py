"""Kernels on a machine that lets nothing be cached."""

import sys
from pathlib import Path

import pytest
from numba.core import caching

from fcw.detection.jit import kernel

SOURCE = """
def double(x):
    return 2 * x
"""


def test_a_kernel_compiles_where_no_cache_can_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "a_kernel.py").write_text(SOURCE)
    monkeypatch.syspath_prepend(tmp_path)
    # No place to keep the machine code: what a read-only install without a home folder amounts to.
    monkeypatch.setattr(caching.CompileResultCacheImpl, "_locator_classes", [])
    import a_kernel  # pyright: ignore[reportMissingImports]

    monkeypatch.delitem(sys.modules, "a_kernel")
    assert kernel()(a_kernel.double)(21) == 42
