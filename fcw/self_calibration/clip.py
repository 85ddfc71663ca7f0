"""Calibrates a camera from a recorded clip, without any mark on the road.

On a straight drive, everything in the picture flows out of the point that the car drives to. It lies on the
horizon and gives the yaw. The vehicles ahead have about the usual widths. Turns give the focal length. How
fast the road flows by depends on the height of the camera, so that a known speed gives the height. All of it
becomes `fcw.camera.joint.Evidence`, together with what the user clicked.
"""

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from fcw.box import Box
from fcw.camera.calibration import Calibration, Gaussian, Priors
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.joint.evidence import Evidence, Ruler
from fcw.camera.joint.known import Known
from fcw.camera.joint.solve import calibrate_jointly
from fcw.camera.lens.model import Lens
from fcw.camera.lens.usual import usual_lens
from fcw.camera.prior_sigmas import CAR_CAMERA_HEIGHT_M, CAR_CAMERA_HEIGHT_SIGMA_M
from fcw.camera.vanishing import PixelPoint
from fcw.detection.detector import Detector
from fcw.errors import UserError
from fcw.frame import ImageSize, Source
from fcw.motion.travel.direction import TravelDirection
from fcw.motion.travel.tracks import PointTracks
from fcw.self_calibration.contradiction import Contradiction, contradiction_in
from fcw.self_calibration.lane_lines import YAWED_PICTURES, agreed_meeting, lanes_aside, lanes_meet
from fcw.self_calibration.moved import leads_to_one_row, moved_at
from fcw.self_calibration.parts import WHOLE_CLIP_S, ClipParts, longest_of, pictures_of, piece_words
from fcw.self_calibration.speed import MeanSpeed, mean_speed
from fcw.self_calibration.turning.by_turns import LensByTurns, lens_by_turns
from fcw.self_calibration.vehicles import DETECTED_EVERY_S, VehicleRulers

VEHICLE_HEIGHTS_M = {
    "car": Gaussian(CAR_CAMERA_HEIGHT_M, CAR_CAMERA_HEIGHT_SIGMA_M),
    "van": Gaussian(1.75, 0.25),
    "lorry": Gaussian(2.4, 0.35),
}
"""Height of a camera behind the windscreen, for each class of vehicle."""
ASSUMED_PITCH_RAD = math.radians(2.0)
ANY_YAW_RAD = math.radians(15.0)
"""Standard deviation of a yaw that the drive does not show; so large that it has no influence."""
LANES_EVERY_S = 0.5
FARTHEST_SIGN_PART = 0.15
"""A vehicle that looks wider than this part of the focal length is too near to show where the horizon is."""
BEFORE_MOVE_S = 1.0
"""The car may brake, and pitch, for this time before the camera is seen to move."""
SHORTEST_PIECE_S = 3.0
"""A shorter piece of a clip shows hardly anything."""


@dataclass(frozen=True, slots=True)
class ClipObservations:
    """What a clip shows.

    Attributes:
        travel_px: column and row that the car drives to when it goes straight; None if it stood, or too
            little flows. If it turned all the time, the column is practically unknown.
        lanes_px: column and row where the lines of the own lane meet; None if few are seen, or they disagree.
        rulers: vehicles of about known width.
        frames: number of pictures that were searched for vehicles.
        moved_s: the times between which the camera was moved; None if it was not.
        parts_s: start and end of each part that was looked at; one part if the clip is not cut.
        by_turns: the lens, from the turns of the clip; None if it was not asked for, or there are too few.
    """

    travel_px: tuple[Gaussian, Gaussian] | None
    lanes_px: tuple[Gaussian, Gaussian] | None
    rulers: tuple[Ruler, ...]
    frames: int
    moved_s: tuple[float, float] | None = None
    by_turns: LensByTurns | None = None
    parts_s: tuple[tuple[float, float], ...] = (WHOLE_CLIP_S,)

    def evidence(self) -> Evidence:
        """The observations in the form that the joint fit needs."""
        focal_px = None if self.by_turns is None else self.by_turns.focal_px
        return Evidence(travel_px=self.leads_to_px, rulers=self.rulers, focal_px=focal_px)

    @property
    def leads_to_px(self) -> tuple[Gaussian, Gaussian] | None:
        """Column and row that the road leads to, from the direction of travel and from the lane lines."""
        if self.travel_px is None or self.lanes_px is None:
            return self.travel_px or self.lanes_px
        column, row = map(_together, self.travel_px, self.lanes_px)
        return column, row


@dataclass(frozen=True, slots=True)
class ClipCalibration:
    """The calibration of a camera from a clip.

    Attributes:
        calibration: the result; its intervals contain what is not known.
        seen: the observations from which it was made.
        shows_road: whether anything shows where the road is; else the usual pitch is assumed.
        by_motion: whether the motion of the camera shows where the road is.
        piece_s: the piece of the clip that was used and for which the result holds, if the camera was moved
            or the clip is cut; else None.
        focal_px: focal length from the turns of the clip; None if they do not show it, or it was stated.
        lens: a lens with distortion, from the turns. Then nothing else was looked for, unless the user
            clicked in a picture: the calibration is a guess until the clip is straightened with this lens.
        contradiction: between direction of travel and vehicles; the intervals allow for it. None if they
            agree, or if something that was stated decides.
        speed: mean speed from the pictures; None if it was not asked for, or they do not show it.
        is_cut: whether the clip is cut.
    """

    calibration: Calibration
    seen: ClipObservations
    shows_road: bool
    by_motion: bool
    piece_s: tuple[float, float] | None = None
    focal_px: Gaussian | None = None
    lens: Lens | None = None
    contradiction: Contradiction | None = None
    speed: MeanSpeed | None = None
    is_cut: bool = False

    @property
    def piece_words(self) -> str:
        """The piece of the clip for which it holds, in words; empty if it is the whole clip."""
        return "" if self.piece_s is None else piece_words(self.piece_s)


def rough_calibration(
    image_size: ImageSize, height_m: float, priors: Priors | None = None, axis_column_px: float | None = None
) -> Calibration:
    """A calibration from the height alone: the usual lens, looking slightly down."""
    priors = priors or Priors()
    view = priors.field_of_view_rad or usual_lens(image_size).field_of_view_rad
    assert view is not None
    camera = GroundPlaneCamera(
        ASSUMED_PITCH_RAD,
        image_size.width / 2 / math.tan(view.value / 2),
        (image_size.height - 1) / 2 if priors.principal_row_px is None else priors.principal_row_px.value,
        height_m,
        (image_size.width - 1) / 2 if axis_column_px is None else axis_column_px,
    )
    return Calibration.from_camera(camera, image_size)


def calibrate_clip(
    source: Source,
    detector: Detector,
    stated: Known,
    speed_mps: float | None = None,
    on_frame: Callable[[], None] = lambda: None,
    turns: bool = True,
    asks_speed: bool = False,
    enough_s: float = math.inf,
) -> ClipCalibration:
    """Calibrate a recorded clip from what it shows and from what else is known.

    Args:
        source: pictures of the camera, straightened if its lens is known (`fcw.sources.straight`).
        detector: a detector that needs no calibration because it searches the whole picture.
        stated: what the user said, or clicked in a picture of the source. If nobody measured the height, it
            is that of a class of `VEHICLE_HEIGHTS_M`.
        speed_mps: mean speed over the clip, if it is known.
        on_frame: called after each picture.
        turns: whether to find the lens from the turns of the clip if it is not stated.
        asks_speed: whether to measure how fast the road flows by; this is done for a given speed anyway.
        enough_s: after so many seconds of driving, the rest of the clip is not read.

    Raises:
        UserError: a speed is given, but the clip does not show how fast the road flows by.
    """
    priors, evidence = stated.priors, stated.evidence
    guess = rough_calibration(stated.image_size, stated.height_m.value, priors, stated.axis_column_px)
    asks_turns = turns and priors.field_of_view_rad is None
    look = partial(
        observe_clip, source, guess, detector, on_frame=on_frame, asks_turns=asks_turns, enough_s=enough_s
    )
    seen, piece_s, is_cut = _observe_one_piece(look)
    focal_px = None if seen.by_turns is None else seen.by_turns.focal_px
    bent = None if seen.by_turns is None else seen.by_turns.bent_lens(stated.image_size)
    if bent is not None:
        if evidence == Evidence():
            return ClipCalibration(guess, seen, False, False, piece_s, focal_px, bent, is_cut=is_cut)
        seen = replace(seen, by_turns=None)
    told = seen.evidence()
    all_known = replace(evidence, travel_px=told.travel_px, rulers=told.rulers, focal_px=told.focal_px)
    known = replace(stated, evidence=all_known, rough=True)
    calibration, speed = calibrate_jointly(known), None
    if asks_speed or speed_mps is not None:
        frames = (frame for _, frame in pictures_of(source, piece_s or WHOLE_CLIP_S))
        speed = mean_speed(frames, calibration, on_frame, enough_s)
    if speed_mps is not None:
        known = replace(known, evidence=replace(all_known, scale_px_m=_scale_px_m(speed, speed_mps)))
        calibration = calibrate_jointly(known)
    contradiction = None
    if evidence == Evidence() and priors.horizon_row_px is None:
        contradiction = contradiction_in(known)
    if contradiction is not None:
        calibration = contradiction.widened(calibration)
    return ClipCalibration(
        calibration,
        seen,
        shows_road=known.tells_of_the_road or bool(seen.rulers),
        by_motion=seen.travel_px is not None,
        piece_s=piece_s,
        focal_px=focal_px,
        lens=bent,
        contradiction=contradiction,
        speed=speed,
        is_cut=is_cut,
    )


def _observe_one_piece(
    look: Callable[[tuple[float, float]], ClipObservations],
) -> tuple[ClipObservations, tuple[float, float] | None, bool]:
    """Look through the longest piece of a clip with one camera that is not moved.

    Returns:
        What the piece shows; its start and end, None if it is the whole clip; whether the clip is cut.
    """
    seen, piece_s = look(WHOLE_CLIP_S), None
    is_cut = len(seen.parts_s) > 1
    if is_cut:
        piece_s = longest_of(seen.parts_s)
        seen = look(piece_s)
    if seen.moved_s is not None:
        piece_s = _before_or_after(seen.moved_s, piece_s or WHOLE_CLIP_S)
        seen = look(piece_s)
    return seen, piece_s, is_cut


def _scale_px_m(speed: MeanSpeed | None, speed_mps: float) -> Gaussian:
    """Focal length times height, from how fast the road flows by at a known speed.

    Raises:
        UserError: the pictures do not show how fast it flows by.
    """
    if speed is None:
        raise UserError(
            f"speed {speed_mps:g} m/s: the picture does not show how fast the road goes by, so the "
            "speed gives no height; measure the camera's height"
        )
    return speed.scale_px_m(speed_mps)


def _before_or_after(moved_s: tuple[float, float], whole_s: tuple[float, float]) -> tuple[float, float]:
    """The piece to use if the camera was moved: the one before the move or, if too short, the one after."""
    (begin_s, end_s), before_s = whole_s, moved_s[0] - BEFORE_MOVE_S
    return (begin_s, before_s) if before_s - begin_s >= SHORTEST_PIECE_S else (moved_s[1], end_s)


def observe_clip(
    source: Source,
    guess: Calibration,
    detector: Detector,
    piece_s: tuple[float, float] = WHOLE_CLIP_S,
    on_frame: Callable[[], None] = lambda: None,
    asks_turns: bool = False,
    enough_s: float = math.inf,
) -> ClipObservations:
    """Look through a clip.

    Args:
        source: straight pictures.
        guess: a rough calibration, whose lens is assumed to be right.
        detector: a detector that needs no calibration because it searches the whole picture.
        piece_s: start and end of the piece to look at.
        on_frame: called after each picture.
        asks_turns: whether to find the lens from the turns.
        enough_s: after so many seconds of driving, the rest is not read.
    """
    camera = guess.camera
    tracks = PointTracks(guess.image_size.width)
    travel = TravelDirection(camera, tracks.factor)
    vehicles = VehicleRulers(guess.image_size)
    boxes: tuple[Box, ...] = ()
    meetings: list[PixelPoint] = []
    signs: list[tuple[float, float]] = []
    pictures: list[NDArray[np.uint8]] = []
    detected_ns = lanes_ns = None
    frames, parts = 0, ClipParts(piece_s)
    for time_s, frame in pictures_of(source, piece_s):
        parts.see(time_s, frame)
        if lanes_ns is None or (frame.time_ns - lanes_ns) / 1e9 >= LANES_EVERY_S:
            lanes_ns = frame.time_ns
            with suppress(UserError):
                meetings.append(lanes_meet(frame.image, camera))
                signs.append((time_s, meetings[-1][1]))
            if len(pictures) < YAWED_PICTURES:
                pictures.append(frame.image)
        if detected_ns is None or (frame.time_ns - detected_ns) / 1e9 >= DETECTED_EVERY_S:
            detected_ns, frames = frame.time_ns, frames + 1
            boxes = tuple(detection.box for detection in detector.detect(frame.image))
            signs += [
                (time_s, ruler.row_px - ruler.width_px * camera.height_m / ruler.width_m.value)
                for ruler in vehicles.look(boxes)
                if ruler.width_px < FARTHEST_SIGN_PART * camera.focal_y_px
            ]
        if tracks.update(time_s, frame.image):
            travel.update(tracks.pictures[-1], boxes)
        on_frame()
        if travel.driven_s >= enough_s:
            break
    moved_s, told = moved_at(signs, camera.focal_y_px), travel.told()
    if moved_s is not None and leads_to_one_row(travel, moved_s, camera.focal_y_px):
        moved_s = None
    # Who turns all the time shows the row alone.
    unknown_px = Gaussian(camera.principal_column_px, math.tan(ANY_YAW_RAD) * camera.focal_y_px)
    return ClipObservations(
        travel_px=None if told is None else (told[0] or unknown_px, told[1]),
        lanes_px=agreed_meeting(meetings, guess.image_size) or lanes_aside(pictures, camera),
        rulers=vehicles.spread(),
        frames=frames,
        moved_s=moved_s,
        by_turns=lens_by_turns(tracks) if asks_turns and moved_s is None else None,
        parts_s=parts.parts_s,
    )


def _together(first: Gaussian, second: Gaussian) -> Gaussian:
    """What two independent measurements of one thing say; where they contradict each other, less surely.

    By as much as they are farther apart than their errors allow (Birge 1932): a lane that bends and a drive
    of a few seconds may each be wrong.
    """
    precisions = first.sigma**-2, second.sigma**-2
    mean = (precisions[0] * first.value + precisions[1] * second.value) / sum(precisions)
    apart = abs(first.value - second.value) / math.hypot(first.sigma, second.sigma)
    return Gaussian(mean, max(1.0, apart) * sum(precisions) ** -0.5)
