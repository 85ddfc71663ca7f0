"""A drive's signals as columns, one row per frame, small enough to be in memory as a whole.

A log stores them in addition to its messages, so that plots of an hour, lists of events and jumps need no
pass over it.
"""

import io
import json
from array import array
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fcw.bounded.arrays import npz_arrays
from fcw.bounded.formats import json_value
from fcw.frame import VideoPacket
from fcw.logs.records import MOMENTS, FrameResult
from fcw.threat.threat import required_deceleration_mps2

NO_TRACK = -1
_NAN = float("nan")


@dataclass(frozen=True, slots=True, eq=False)
class DriveSeries:
    """Columns of shape (N,), one row per frame in the order of time. NaN means that there is no value.

    Attributes:
        frame_index: int64, `FrameResult.index`. The same as the row, except in a log cut out of a drive.
        time_ns: int64, presentation times.
        level: int8, the `WarningLevel` shown.
        warned_id: int64, track that the warning is about; `NO_TRACK` if there is none.
        rule: int32, index in `rules` of the rule behind the level; int8 in logs from before a user's policy
            could have more than 127 rules.
        lead_id: int64, track of the lead; `NO_TRACK` if the own path is free.
        distance_m: float32, distance of the lead.
        distance_low_m: float32, 16th percentile of that distance.
        distance_high_m: float32, 84th percentile of that distance; inf when unbounded.
        closing_speed_mps: float32, closing speed of the lead.
        ttc_s: float32, TTC of the lead; NaN when not closing.
        headway_s: float32, headway to the lead; NaN if the own speed is unknown or zero.
        required_deceleration_mps2: float32, braking needed to avoid the lead; NaN when not closing.
        ego_speed_mps: float32, own speed; NaN when unknown.
        ego_speed_sigma_mps: float32, standard deviation of the own speed, 0 if it was given; NaN when
            unknown, and in logs from before it was stored.
        warned_distance_m: float32, distance of the vehicle that the warning is about, which may be the lead
            or not. The same holds for the other columns `warned_...`.
        warned_distance_low_m: float32.
        warned_distance_high_m: float32.
        warned_closing_speed_mps: float32.
        warned_ttc_s: float32.
        warned_headway_s: float32.
        warned_required_deceleration_mps2: float32.
        warned_probability: float32, probability of a collision.
        extrapolated: int8, 1 if that vehicle is no longer tracked.
        keyframe_ns: (K,) int64, times of the video packets at which decoding can start, ascending; negative
            if they only feed the decoder.
        note_ns: (M,) int64, time of the first frame of each note. Notes that nothing could be seen are
            separate from all others.
        note_end_ns: (M,) int64, time of its last frame.
        rules: names of rules; the first is empty, for no level.
        notes: (M,) notes, as worded at their last frame, when most was known.
    """

    frame_index: NDArray[np.int64]
    time_ns: NDArray[np.int64]
    level: NDArray[np.int8]
    warned_id: NDArray[np.int64]
    rule: NDArray[np.int32] | NDArray[np.int8]
    lead_id: NDArray[np.int64]
    distance_m: NDArray[np.float32]
    distance_low_m: NDArray[np.float32]
    distance_high_m: NDArray[np.float32]
    closing_speed_mps: NDArray[np.float32]
    ttc_s: NDArray[np.float32]
    headway_s: NDArray[np.float32]
    required_deceleration_mps2: NDArray[np.float32]
    ego_speed_mps: NDArray[np.float32]
    ego_speed_sigma_mps: NDArray[np.float32]
    warned_distance_m: NDArray[np.float32]
    warned_distance_low_m: NDArray[np.float32]
    warned_distance_high_m: NDArray[np.float32]
    warned_closing_speed_mps: NDArray[np.float32]
    warned_ttc_s: NDArray[np.float32]
    warned_headway_s: NDArray[np.float32]
    warned_required_deceleration_mps2: NDArray[np.float32]
    warned_probability: NDArray[np.float32]
    extrapolated: NDArray[np.int8]
    keyframe_ns: NDArray[np.int64]
    note_ns: NDArray[np.int64]
    note_end_ns: NDArray[np.int64]
    rules: tuple[str, ...]
    notes: tuple[str, ...]

    def __len__(self) -> int:
        """Number of frames."""
        return len(self.time_ns)

    @property
    def duration_s(self) -> float:
        """Time from the first frame to the last."""
        return float(self.time_ns[-1] - self.time_ns[0]) / 1e9 if len(self) else 0.0

    def about(self, name: str) -> NDArray[np.float32]:
        """A column for display: of the vehicle that is warned of, or of the lead if there is no warning.

        Args:
            name: `distance_m`, `distance_low_m`, `distance_high_m`, `closing_speed_mps`, `ttc_s`, `headway_s`
                or `required_deceleration_mps2`.
        """
        warned, lead = getattr(self, f"warned_{name}"), getattr(self, name)
        return np.where(self.warned_id == NO_TRACK, lead, warned)

    def row_of(self, frame_index: int) -> int:
        """Row of a frame.

        Raises:
            IndexError: the log has no such frame.
        """
        row = int(np.searchsorted(self.frame_index, frame_index))
        if row == len(self) or self.frame_index[row] != frame_index:
            raise IndexError(f"no frame {frame_index} in a drive of {len(self)} frames")
        return row

    def row_at(self, time_ns: int) -> int:
        """Row of the frame shown at a time: the last one that is not later, or the first row."""
        return max(int(np.searchsorted(self.time_ns, time_ns, side="right")) - 1, 0)

    def keyframe_before(self, time_ns: int) -> int | None:
        """Time of the last keyframe that is not later; None if there is none."""
        before = int(np.searchsorted(self.keyframe_ns, time_ns, side="right")) - 1
        return int(self.keyframe_ns[before]) if before >= 0 else None

    def to_bytes(self) -> bytes:
        """All columns as a compressed NumPy .npz archive."""
        columns = {name: getattr(self, name) for name in _COLUMNS}
        texts = json.dumps({name: getattr(self, name) for name in _TEXTS}).encode()
        buffer = io.BytesIO()
        np.savez_compressed(buffer, **columns, texts=np.frombuffer(texts, np.uint8))
        return buffer.getvalue()

    @staticmethod
    def from_bytes(data: bytes) -> "DriveSeries":
        """Read what `to_bytes` wrote.

        Raises:
            ValueError: the bytes are something else.
        """
        try:
            stored = npz_arrays(data)
            columns: dict[str, Any] = {name: stored[name] for name in _COLUMNS if name not in _LATER}
            unknown = np.full(len(columns["time_ns"]), _NAN, np.float32)
            columns |= {name: stored.get(name, unknown) for name in _LATER}
            texts = json_value(stored["texts"].tobytes().decode())
            columns |= {name: tuple(texts[name]) for name in _TEXTS}
        except (ValueError, KeyError, TypeError, OSError) as error:
            raise ValueError(f"no columns of a drive: {error}") from error
        return DriveSeries(**columns)


_TYPECODES = {
    np.dtype(np.int64): "q",
    np.dtype(np.int32): "i",
    np.dtype(np.int8): "b",
    np.dtype(np.float32): "f",
}
_COLUMNS: dict[str, type[np.generic]] = {
    "frame_index": np.int64,
    "time_ns": np.int64,
    "level": np.int8,
    "warned_id": np.int64,
    "rule": np.int32,
    "lead_id": np.int64,
    "distance_m": np.float32,
    "distance_low_m": np.float32,
    "distance_high_m": np.float32,
    "closing_speed_mps": np.float32,
    "ttc_s": np.float32,
    "headway_s": np.float32,
    "required_deceleration_mps2": np.float32,
    "ego_speed_mps": np.float32,
    "ego_speed_sigma_mps": np.float32,
    "warned_distance_m": np.float32,
    "warned_distance_low_m": np.float32,
    "warned_distance_high_m": np.float32,
    "warned_closing_speed_mps": np.float32,
    "warned_ttc_s": np.float32,
    "warned_headway_s": np.float32,
    "warned_required_deceleration_mps2": np.float32,
    "warned_probability": np.float32,
    "extrapolated": np.int8,
    "keyframe_ns": np.int64,
    "note_ns": np.int64,
    "note_end_ns": np.int64,
}
_LATER = ("ego_speed_sigma_mps",)
"""Columns that older logs do not have."""
_TEXTS = ("rules", "notes")


class SeriesBuilder:
    """Collects a series while a drive is written or read, in about 110 bytes of memory per frame."""

    def __init__(self) -> None:
        self._columns = {name: array(_TYPECODES[np.dtype(kind)]) for name, kind in _COLUMNS.items()}
        self._rules = {"": 0}
        self._notes: list[str] = []
        self._standing: dict[str, int] = {}

    def add(self, result: FrameResult, packets: Sequence[VideoPacket]) -> None:
        """Add the next frame and its video packets."""
        lead, warning, own_mps = result.lead, result.told_warning, result.ego_speed_mps
        row: dict[str, float | None] = {
            "frame_index": result.index,
            "time_ns": result.time_ns,
            "level": warning.level,
            "warned_id": NO_TRACK if warning.track_id is None else warning.track_id,
            "rule": self._rules.setdefault(warning.rule, len(self._rules)),
            "lead_id": NO_TRACK if result.lead_id is None else result.lead_id,
            "ego_speed_mps": own_mps,
            "ego_speed_sigma_mps": None if result.own_motion is None else result.own_motion.speed_sigma_mps,
            "warned_distance_m": warning.distance_m,
            "warned_distance_low_m": warning.distance_low_m,
            "warned_distance_high_m": warning.distance_high_m,
            "warned_closing_speed_mps": warning.closing_speed_mps,
            "warned_ttc_s": warning.ttc_s,
            "warned_headway_s": warning.headway_s,
            "warned_required_deceleration_mps2": warning.required_deceleration_mps2,
            "warned_probability": warning.collision_probability,
            "extrapolated": warning.extrapolated,
            "distance_m": None,
            "distance_low_m": None,
            "distance_high_m": None,
            "closing_speed_mps": None,
            "ttc_s": None,
            "headway_s": None,
            "required_deceleration_mps2": None,
        }
        if lead is not None:
            row |= {
                "distance_m": lead.distance_m,
                "distance_low_m": lead.distance_low_m,
                "distance_high_m": lead.distance_high_m,
                "closing_speed_mps": lead.closing_speed_mps,
                "ttc_s": lead.ttc_s,
                "headway_s": lead.distance_m / own_mps if own_mps else None,
                "required_deceleration_mps2": required_deceleration_mps2(
                    lead.distance_m, lead.closing_speed_mps
                ),
            }
        for name, value in row.items():
            self._columns[name].append(_NAN if value is None else value)
        for packet in packets:
            self.add_packet(packet.time_ns, packet.keyframe)
        lasting = (note for note in result.notes if not note.startswith(MOMENTS))
        self._take_note("", "; ".join(lasting), result.time_ns)
        for moment in MOMENTS:
            note = next((note for note in result.notes if note.startswith(moment)), "")
            self._take_note(moment, note, result.time_ns)

    def _take_note(self, kind: str, note: str, time_ns: int) -> None:
        """Add a frame's note of one kind; empty if it has none."""
        number = self._standing.pop(kind, len(self._notes))
        if not note:
            return
        if number == len(self._notes):
            self._notes.append("")
            self._columns["note_ns"].append(time_ns)
            self._columns["note_end_ns"].append(time_ns)
        self._standing[kind] = number
        self._notes[number] = note
        self._columns["note_end_ns"][number] = time_ns

    def add_packet(self, time_ns: int, keyframe: bool) -> None:
        """Add a video packet separately from its frame."""
        if keyframe:
            self._columns["keyframe_ns"].append(time_ns)

    def build(self) -> DriveSeries:
        """The series of the frames so far."""
        columns: dict[str, Any] = {
            name: np.array(self._columns[name], kind) for name, kind in _COLUMNS.items()
        }
        return DriveSeries(**columns, rules=tuple(self._rules), notes=tuple(self._notes))
