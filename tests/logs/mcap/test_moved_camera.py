"""Where the camera looks elsewhere than it was calibrated, transforms and rows of distances go with it.

The distances of the vehicles do, so that all else would contradict them: 2 degrees are 35 rows at 1000 px.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from scipy.spatial.transform import Rotation

from fcw.logs.mcap.writer import McapSink
from fcw.logs.overlay import PITCH_STEP_RAD
from fcw.motion.state import Mount, OwnMotion

TURNED_RAD = 0.035
PITCH_ROUNDING_RAD = PITCH_STEP_RAD / 2


@pytest.fixture
def moved_log(tmp_path, header, short_drive) -> Path:
    """Ten frames as calibrated, and ten in which the camera looks farther down."""
    pitch_rad = header.calibration.camera.pitch_rad
    sink = McapSink(tmp_path / "drive.mcap")
    sink.open(header)
    for index, (result, packets) in enumerate(short_drive[:20]):
        mount = Mount(pitch_rad=pitch_rad + TURNED_RAD * (index >= 10) + PITCH_ROUNDING_RAD / 2)
        sink.write(replace(result, own_motion=OwnMotion(mount=mount)), packets)
    sink.close()
    return tmp_path / "drive.mcap"


def messages(path: Path, topic: str) -> list[tuple[int, Any]]:
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        return [(message.log_time, decoded) for *_, message, decoded in reader.iter_decoded_messages(topic)]


def test_the_transform_is_written_anew_and_puts_the_road_where_it_is_seen(moved_log, header):
    (first_ns, first), (moved_ns, moved) = messages(moved_log, "/tf")
    ((_, camera),) = messages(moved_log, "/camera/calibration")
    assert (first_ns, moved_ns) == (0, 1_000_000_000)
    pitch_rad = header.calibration.camera.pitch_rad
    for (mount,), looks_rad in ((first.transforms, pitch_rad), (moved.transforms, pitch_rad + TURNED_RAD)):
        q, t = mount.rotation, mount.translation
        to_camera = Rotation.from_quat([q.x, q.y, q.z, q.w]).inv()
        seen = np.reshape(list(camera.K), (3, 3)) @ to_camera.apply(np.array([40.0, 0, 0]) - [t.x, t.y, t.z])
        looking = replace(header.calibration.camera, pitch_rad=looks_rad)
        row_px = looking.row_at(40.0 + header.calibration.reference_offset_m)
        tolerance_px = PITCH_ROUNDING_RAD * 1.01 * looking.focal_y_px
        assert seen[1] / seen[2] == pytest.approx(row_px, abs=tolerance_px)


def test_the_rows_of_distances_move_by_as_much(moved_log, header):
    annotations = messages(moved_log, "/camera/annotations")
    assert len(annotations) == 20
    near = [message.points[-1].points[0].y for _, message in annotations]
    assert len(set(near[:10])) == len(set(near[10:])) == 1
    looking = replace(header.calibration.camera, pitch_rad=header.calibration.camera.pitch_rad + TURNED_RAD)
    distance_m = 5.0 + header.calibration.reference_offset_m
    assert near[0] == pytest.approx(header.calibration.camera.row_at(distance_m) + 0.5, abs=0.6)
    assert near[-1] == pytest.approx(looking.row_at(distance_m) + 0.5, abs=0.6)
    assert near[0] - near[-1] > 30
