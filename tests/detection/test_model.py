"""The model file: comes back as it was saved; anything else is refused in one clear message."""

import json
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from fcw.detection.model import (
    SHIPPED_MODEL_PATH,
    BoostedTrees,
    BoxRegressor,
    Model,
    SecondStage,
    VehicleStatistics,
    Window,
)
from fcw.errors import UserError

STATISTICS = VehicleStatistics(1.2, 2.1, 3.6, (5.0, 20.0, 80.0), (1.5, 1.25, 1.0))


def random_trees(rng: np.random.Generator, features: int) -> BoostedTrees:
    return BoostedTrees(
        rng.integers(0, features, (7, 3)).astype(np.uint16),
        rng.integers(0, 256, (7, 3)).astype(np.uint8),
        rng.normal(size=(7, 4)).astype(np.float32),
    )


def model() -> Model:
    rng = np.random.default_rng(0)
    second = SecondStage(
        rng.integers(-100, 101, (10, 4, 5, 5)).astype(np.int8),
        rng.integers(-9999, 9999, (10, 4)).astype(np.int32),
        rng.integers(0, 9, (10, 4)).astype(np.uint8),
        random_trees(rng, 5760),
    )
    regressor = BoxRegressor(
        rng.normal(size=(2560, 3)).astype(np.float32), rng.normal(size=3).astype(np.float32), 0.0125
    )
    return Model(Window(), random_trees(rng, 2560), second, regressor, STATISTICS, -2.5, 6.0, 4.0)


def arrays_of(model: Model) -> list[NDArray[Any]]:
    parts = [model.trees, model.second, model.second and model.second.trees, model.regressor]
    values = [getattr(part, field.name) for part in parts if part for field in fields(part)]
    return [value for value in values if isinstance(value, np.ndarray)]


@pytest.mark.parametrize("plain", [False, True])
def test_a_saved_model_comes_back_bit_for_bit(tmp_path: Path, plain: bool):
    saved = model().plain() if plain else model()
    saved.save(tmp_path / "model.npz")
    loaded = Model.load(tmp_path / "model.npz")
    assert len(arrays_of(saved)) == (3 if plain else 3 + 6 + 2)
    for before, after in zip(arrays_of(saved), arrays_of(loaded), strict=True):
        assert before.dtype == after.dtype
        np.testing.assert_array_equal(before, after)
    assert loaded.window == saved.window
    assert loaded.statistics == saved.statistics
    assert (loaded.regressor and loaded.regressor.bottom) == (None if plain else 0.0125)
    thresholds = (loaded.rejection_threshold, loaded.score_threshold, loaded.first_stage_threshold)
    assert thresholds == (-2.5, 4.0 if plain else 6.0, 4.0)
    assert [path.name for path in tmp_path.iterdir()] == ["model.npz"]


def test_the_aspect_ratio_meets_its_statistics_and_lies_between_them():
    assert STATISTICS.aspect_ratio(20.0) == pytest.approx(1.25)
    assert STATISTICS.aspect_ratio(10.0) == pytest.approx((1.5 + 1.25) / 2)  # the middle in log distance
    assert STATISTICS.aspect_ratio(1.0) == 1.5
    np.testing.assert_allclose(STATISTICS.aspect_ratio(np.array([5.0, 200.0])), [1.5, 1.0])


def test_trees_of_unequal_length_are_refused():
    trees = model().trees
    with pytest.raises(ValueError, match=r"\(6, 4\)"):
        BoostedTrees(trees.feature, trees.threshold, trees.leaf[:6])


def test_a_missing_file_says_how_to_train_one(tmp_path: Path):
    with pytest.raises(UserError, match=r"gone\.npz: no such model file.*fcw train"):
        Model.load(tmp_path / "gone.npz")


@pytest.mark.parametrize("content", [b"", b"not a model", b"PK\x03\x04 broken archive"])
def test_another_file_is_refused_by_name(tmp_path: Path, content: bytes):
    path = tmp_path / "other.npz"
    path.write_bytes(content)
    with pytest.raises(UserError, match=r"other\.npz: not a detector model"):
        Model.load(path)


def test_a_cut_file_and_an_archive_of_something_else_are_refused(tmp_path: Path):
    cut, other = tmp_path / "cut.npz", tmp_path / "else.npz"
    whole = SHIPPED_MODEL_PATH.read_bytes()
    cut.write_bytes(whole[: len(whole) // 2])
    np.savez(other, picture=np.zeros(3))
    for path in (cut, other):
        with pytest.raises(UserError, match=rf"{path.name}: not a detector model"):
            Model.load(path)


def without_number(values: NDArray[np.float32]) -> NDArray[np.float32]:
    wrong = values.copy()
    wrong.reshape(-1)[1] = np.nan
    return wrong


def test_parts_that_hold_no_numbers_or_do_not_fit_are_refused(tmp_path: Path):
    good = model()
    assert good.second
    assert good.regressor
    trees, second, regressor = good.trees, good.second, good.regressor
    far = trees.feature.copy()
    far[0, 0] = 5760  # of responses there are 40 planes of 12 x 12
    wrong = {
        "a leaf that is no number": replace(good, trees=replace(trees, leaf=without_number(trees.leaf))),
        "asks for feature 5760 of 5760": replace(
            good, second=replace(second, trees=replace(second.trees, feature=far))
        ),
        "a weight that is no number": replace(
            good, regressor=replace(regressor, weights=without_number(regressor.weights))
        ),
        r"a regressor of the shapes \(2560, 3\) and \(2,\)": replace(
            good, regressor=replace(regressor, constant=regressor.constant[:2])
        ),
    }
    for message, each in wrong.items():
        each.save(tmp_path / "model.npz")
        with pytest.raises(UserError, match=rf"model\.npz: not a detector model of fcw \(.*{message}"):
            Model.load(tmp_path / "model.npz")


def test_another_format_version_is_named(tmp_path: Path):
    path = tmp_path / "later.npz"
    with np.load(SHIPPED_MODEL_PATH) as archive:
        arrays = {name: archive[name] for name in archive.files}
    header = json.loads(arrays["header"].tobytes()) | {"format_version": 99}
    arrays["header"] = np.frombuffer(json.dumps(header).encode(), np.uint8)
    np.savez(path, **arrays)
    with pytest.raises(UserError, match=r"later\.npz: model format version 99, expected 2"):
        Model.load(path)
