"""Finished stages: kept, taken up again, and dropped where they belong to another training."""

from pathlib import Path

import numpy as np
import pytest

from fcw.detection.training.checkpoints import Checkpoints
from fcw.errors import UserError


def forbidden():
    raise AssertionError("computed again")


def test_a_finished_stage_is_not_computed_again(tmp_path: Path):
    made = Checkpoints(tmp_path / "parts", "a").stage("one", lambda: {"x": np.arange(3, dtype=np.uint8)})
    kept = Checkpoints(tmp_path / "parts", "a").stage("one", forbidden)
    assert kept["x"].dtype == np.uint8
    assert made["x"].tolist() == kept["x"].tolist() == [0, 1, 2]


def test_stages_of_another_training_are_dropped(tmp_path: Path):
    Checkpoints(tmp_path / "parts", "a").stage("one", lambda: {"x": np.zeros(1)})
    assert Checkpoints(tmp_path / "parts", "b").stage("one", lambda: {"x": np.ones(1)})["x"] == 1
    with pytest.raises(AssertionError, match="computed again"):
        Checkpoints(tmp_path / "parts", "a").stage("one", forbidden)


def test_a_stage_that_was_killed_or_damaged_is_computed_again(tmp_path: Path):
    checkpoints = Checkpoints(tmp_path / "parts", "a")
    with pytest.raises(AssertionError):
        checkpoints.stage("one", forbidden)
    assert [path.name for path in (tmp_path / "parts").iterdir()] == ["identity"]
    checkpoints.stage("one", lambda: {"x": np.zeros(1)})
    (tmp_path / "parts/one.npz").write_bytes(b"PK\x03\x04 half a file")
    assert checkpoints.stage("one", lambda: {"x": np.ones(1)})["x"] == 1


def test_without_a_folder_nothing_is_kept():
    checkpoints = Checkpoints(None, "a")
    assert checkpoints.stage("one", lambda: {"x": np.zeros(1)})["x"] == 0
    assert checkpoints.stage("one", lambda: {"x": np.ones(1)})["x"] == 1


def test_a_folder_that_cannot_be_is_named(tmp_path: Path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match=r"file/parts: cannot keep the training's finished stages"):
        Checkpoints(tmp_path / "file/parts", "a")
