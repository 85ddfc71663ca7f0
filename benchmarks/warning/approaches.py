"""Are real vehicles warned of in time when they come nearer, on cameras and in weather new to the detector?

    FCW_DATA=DIR PYTHONPATH=benchmarks python benchmarks/warning/approaches.py --models DIR [--each 8]

DIR holds the models that `leave_one_camera_out.py --detector net --models DIR` made. So many labelled
vehicles of each camera are drawn, from its clips in turn: nearly ahead, 12 to 45 m away, neither hidden nor
cut. Each picture is enlarged as if we drove at the vehicle (`fcw.evaluation.warning.approach`); the model
that was trained without that camera, the tracker and the default policy run on it. `--models all` takes the
shipped detector, which has seen these cameras.
"""

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from lines import say, say_row, where_and_with_what
from real_drives import data_folder

from fcw.box import Box
from fcw.detection.choice import NET, load_model, make_detector
from fcw.errors import UserError
from fcw.evaluation.detection.cameras import GROUPS, LabelledCameras, folds, read_cameras
from fcw.evaluation.warning.approach import ApproachTrial, approach, run_approach
from fcw.warning.policies import make_policy

NEAREST_M, FARTHEST_M = 12.0, 45.0
ASIDE_M = 1.6
LEAST_WIDTH_PX = 28.0
MARGIN_PX = 3.0
"""A box that ends nearer to the picture's edge may be cut by it."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--models", required=True, help="folder of the folds' models; `all`: the shipped one")
    parser.add_argument("--each", type=int, default=8, help="vehicles of each camera")
    parser.add_argument("--groups", nargs="+", help="only these, as `leave_one_camera_out.py` names them")
    parser.add_argument("--seed", type=int, default=0, help="of what is drawn")
    arguments = parser.parse_args()
    data = data_folder()
    cv2.setNumThreads(1)
    try:
        run(arguments, read_cameras(data))
    except UserError as error:
        sys.exit(str(error))


def run(arguments: argparse.Namespace, cameras: LabelledCameras) -> None:
    say(where_and_with_what())
    rows: dict[str, list[ApproachTrial]] = {}
    known = [fold.name for fold in folds(cameras, GROUPS)]
    if wrong := [name for name in arguments.groups or () if name not in known]:
        raise UserError(f"--groups {' '.join(wrong)}: no such group; expected some of {', '.join(known)}")
    for fold in folds(cameras, GROUPS):
        if arguments.groups and fold.name not in arguments.groups:
            continue
        path = None if arguments.models == "all" else Path(arguments.models) / f"net-without-{fold.name}.npz"
        model = load_model(NET, path=path)
        for index, box in drawn(cameras, fold.tested, arguments.each, arguments.seed):
            labelled = cameras.images[index].labelled
            calibration = cameras.calibration_of(labelled)
            detector = make_detector(NET, model, calibration, for_tracker=True)
            frames = approach(labelled.read(), box, calibration, index)
            trial = run_approach(frames, calibration, detector, make_policy())
            rows.setdefault(labelled.camera, []).append(trial)
            say(f"{cameras.name(index)}: {words(trial)}")
    say("")
    say_row(
        ("camera", "approaches", "in time", "late", "never", "warning of another", "found", "tracked"),
        head=True,
    )
    rows["all"] = [trial for trials in rows.values() for trial in trials]
    for camera, trials in rows.items():
        late = sum(trial.warned_s is not None and not trial.in_time for trial in trials)
        found, tracked = (
            np.mean([getattr(trial, name) for trial in trials]) for name in ("found_part", "tracked_part")
        )
        say_row(
            (
                camera,
                len(trials),
                sum(trial.in_time for trial in trials),
                late,
                sum(trial.warned_s is None for trial in trials),
                sum(trial.others > 0 for trial in trials),
                f"{found:.2f}",
                f"{tracked:.2f}",
            )
        )


def drawn(cameras: LabelledCameras, indices: np.ndarray, each: int, seed: int) -> Iterator[tuple[int, Box]]:
    """So many vehicles of each camera, of its clips in turn."""
    chance = np.random.default_rng(seed)
    found: dict[str, dict[str, list[tuple[int, Box]]]] = {}
    for index in indices.tolist():
        labelled = cameras.images[index].labelled
        for box in ahead(cameras, index):
            found.setdefault(labelled.camera, {}).setdefault(labelled.clip, []).append((index, box))
    for clips in found.values():
        waiting = [chance.permutation(np.array(vehicles, object)).tolist() for vehicles in clips.values()]
        chance.shuffle(waiting)
        left = each
        while left and any(waiting):
            for vehicles in waiting:
                if vehicles and left:
                    yield tuple(vehicles.pop())
                    left -= 1


def ahead(cameras: LabelledCameras, index: int) -> Iterator[Box]:
    """The vehicles of a picture that one may drive at."""
    image = cameras.images[index]
    labelled, calibration = image.labelled, cameras.calibration_of(image.labelled)
    for sides, ignored, attributes in zip(labelled.boxes, labelled.ignored, image.attributes, strict=True):
        box = Box(*sides.tolist())
        cut = (
            box.x < MARGIN_PX
            or box.x + box.w > labelled.size.width - MARGIN_PX
            or box.y + box.h > labelled.size.height - MARGIN_PX
        )
        if (
            ignored
            or cut
            or attributes.get("occluded")
            or attributes.get("truncated")
            or box.w < LEAST_WIDTH_PX
        ):
            continue
        distance_m = calibration.distance_at(box.y + box.h)
        aside_m = calibration.lateral_at(box.x + box.w / 2, box.y + box.h)
        if NEAREST_M <= distance_m <= FARTHEST_M and abs(aside_m) <= ASIDE_M:
            yield box


def words(trial: ApproachTrial) -> str:
    """What came of a trial."""
    warned = "never warned of" if trial.warned_s is None else f"warned of at {trial.warned_s:.2f} s"
    others = f"; {trial.others} pictures with a warning of something else" if trial.others else ""
    return (
        f"{warned}, due at {trial.due_s:.2f} s; found in {trial.found_part:.0%}, tracked in "
        f"{trial.tracked_part:.0%} of the pictures{others}"
    )


if __name__ == "__main__":
    main()
