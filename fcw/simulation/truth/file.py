"""The truth of a drive as a CSV file: a line for each vehicle ahead at each frame, distances in metres."""

import csv
import io
from collections.abc import Iterable
from itertools import groupby
from pathlib import Path

from fcw.bounded.files import MalformedError, read_text
from fcw.box import Box
from fcw.errors import UserError
from fcw.files import write_whole
from fcw.simulation.truth.truth import FrameTruth, VehicleTruth

FRAME_COLUMNS = ("time_s", "ego_speed_mps", "pitch_deviation_rad", "bounce_m", "horizon_row_px")
VEHICLE_COLUMNS = (
    "vehicle",
    "distance_m",
    "lateral_m",
    "path_lateral_m",
    "closing_speed_mps",
    "ttc_s",
    "box_x",
    "box_y",
    "box_w",
    "box_h",
    "body_x",
    "body_y",
    "body_w",
    "body_h",
    "visible_fraction",
    "oncoming",
    "in_path",
)
COLUMNS = ("frame", *FRAME_COLUMNS, *VEHICLE_COLUMNS)
"""See `FrameTruth` and `VehicleTruth`; a frame without vehicles has one line with nothing after its own."""


def write_truth(path: Path, frames: Iterable[FrameTruth]) -> None:
    """Write the file, whole or not at all.

    Raises:
        UserError: it cannot be written there.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for index, frame in enumerate(frames):
        # Nine decimals: times are whole nanoseconds and come back as such.
        head = (
            str(index),
            f"{frame.time_ns / 1e9:.9f}",
            f"{frame.ego_speed_mps:.4f}",
            f"{frame.pitch_deviation_rad:.6f}",
            f"{frame.bounce_m:.4f}",
            f"{frame.horizon_row_px:.3f}",
        )
        for vehicle in frame.vehicles:
            writer.writerow((*head, *_vehicle_cells(vehicle)))
        if not frame.vehicles:
            writer.writerow((*head, *("" for _ in VEHICLE_COLUMNS)))
    write_whole(path, text.getvalue())


def read_truth(path: Path) -> list[FrameTruth]:
    """The frames of a file that `write_truth` wrote.

    Raises:
        UserError: it cannot be read, or a line is not one of its lines.
    """
    try:
        text = read_text(path)
    except (OSError, MalformedError) as error:
        raise UserError(f"{path}: cannot read the truth ({error}); make it with `fcw simulate`") from None
    reader = csv.DictReader(text.splitlines())
    try:
        columns = tuple(reader.fieldnames or ())
    except csv.Error:  # a field beyond all bounds
        columns = ()
    if columns != COLUMNS:
        raise UserError(f"{path}: not a truth file: the first line must be {','.join(COLUMNS)}")
    frames = []
    try:
        for _, lines in groupby(reader, key=lambda line: line["frame"]):
            rows = list(lines)
            head = rows[0]
            numbers = [float(head[name]) for name in FRAME_COLUMNS[1:]]
            vehicles = tuple(_vehicle(row) for row in rows if row["vehicle"])
            frames.append(FrameTruth(round(float(head["time_s"]) * 1e9), *numbers, vehicles=vehicles))
    except (ValueError, TypeError, OverflowError, csv.Error) as error:
        raise UserError(
            f"{path}, line {reader.line_num}: {error}; make the file again with `fcw simulate`"
        ) from error
    return frames


def _vehicle_cells(vehicle: VehicleTruth) -> tuple[str, ...]:
    edges = [edge for box in (vehicle.box, vehicle.body_box) for edge in (box.x, box.y, box.w, box.h)]
    metres = (vehicle.distance_m, vehicle.lateral_m, vehicle.path_lateral_m, vehicle.closing_speed_mps)
    return (
        vehicle.name,
        *(f"{number:.4f}" for number in metres),
        "" if vehicle.ttc_s is None else f"{vehicle.ttc_s:.4g}",
        *(f"{edge:.1f}" for edge in edges),
        f"{vehicle.visible_fraction:.3f}",
        str(int(vehicle.oncoming)),
        str(int(vehicle.in_path)),
    )


def _vehicle(row: dict[str, str]) -> VehicleTruth:
    distance_m, lateral_m, path_lateral_m, closing_mps = (float(row[name]) for name in VEHICLE_COLUMNS[1:5])
    return VehicleTruth(
        name=row["vehicle"],
        distance_m=distance_m,
        lateral_m=lateral_m,
        path_lateral_m=path_lateral_m,
        closing_speed_mps=closing_mps,
        ttc_s=float(row["ttc_s"]) if row["ttc_s"] else None,
        box=Box(*(float(row[f"box_{edge}"]) for edge in "xywh")),
        body_box=Box(*(float(row[f"body_{edge}"]) for edge in "xywh")),
        visible_fraction=float(row["visible_fraction"]),
        oncoming=bool(int(row["oncoming"])),
        in_path=bool(int(row["in_path"])),
    )
