"""What a recorded clip shows of its camera, without any mark on the road.

Driving straight, all things flow out of the point that we drive to: it lies on the horizon and tells the yaw.
The vehicles ahead are about as wide as vehicles are. Turns tell the focal length. And the road below flows by
as fast as the camera is high: with a known speed, the height follows. All of it becomes
`fcw.camera.joint.Evidence`, beside whatever a person clicked.
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
from fcw.camera.vanishing import PixelPoint
from fcw.detection.detector import Detector
from fcw.errors import UserError
from fcw.frame import ImageSize, Source
from fcw.motion.estimator import MotionEstimator
from fcw.motion.settings import MotionSettings
from fcw.motion.state import Mount
from fcw.self_calibration.contradiction import Contradiction, contradiction_in
from fcw.self_calibration.lane_lines import YAWED_PICTURES, agreed_meeting, lanes_aside, lanes_meet
from fcw.self_calibration.moved import moved_at
from fcw.self_calibration.turning.by_turns import LensByTurns, lens_by_turns
from fcw.self_calibration.turning.tracks import PointTracks
from fcw.self_calibration.vehicles import DETECTED_EVERY_S, LONGEST_S, VehicleRulers

VEHICLE_HEIGHTS_M = {"car": Gaussian(1.3, 0.12), "van": Gaussian(1.75, 0.25), "lorry": Gaussian(2.4, 0.35)}
"""Of a camera at the windscreen of each class."""
ASSUMED_PITCH_RAD = math.radians(2.0)
SLOPE_SIGMA_RAD = math.radians(0.25)
"""The road ahead is not level with the direction of travel, averaged over a clip."""
FASTEST_TURN_RADPS = math.radians(3.0)
SLOWEST_TRAVEL_MPS = 3.0
GUESS_PITCH_SIGMA_RAD = math.radians(2.0)
"""Of the guess that own motion begins with."""
LANES_EVERY_S = 0.5
TOLD_PART = 0.5
"""A drive tells where it leads to if that is so much surer than the guess was."""
SPEED_SIGMA = 0.04
"""Of the speed by the picture, over a clip: on KITTI odometry 03 it is off by 3 % a second."""
FEWEST_SPEEDS = 10
SLOWEST_MEAN_MPS = 1.0
"""Who is slower over a clip stood in most of it: what is seen of the speed tells no scale then."""
PASSES = 4
SETTLED_PX = 1.0
WHOLE_CLIP_S = (0.0, LONGEST_S)
FARTHEST_SIGN_PART = 0.15
"""A vehicle that looks wider, in parts of the focal length, is too near to say where the horizon is."""
BEFORE_MOVE_S = 1.0
"""So long before a camera is seen to be knocked the car may brake, and pitch."""
SHORTEST_PIECE_S = 3.0
"""A shorter piece of a clip tells hardly anything."""


@dataclass(frozen=True, slots=True)
class ClipObservations:
    """What a clip shows.

    Attributes:
        travel_px: column and row that straight driving leads to; None where the car stood, or turned always.
        lanes_px: column and row where the own lane's lines meet; None where few are seen, or they disagree.
        rulers: vehicles.
        speed_heights: speed by the picture in camera heights a second; None where it is not known, or the car
            stood for most of the clip.
        frames: how many pictures were looked at for vehicles.
        moved_s: between which times the camera was moved; None where it was not.
        by_turns: the lens, by how the picture turns; None where that was not asked, or it turns too little.
        focal_px: focal length that was taken for granted: with another one the speed is another, too.
        speed_times_ns: of the pictures whose speed that mean is of.
    """

    travel_px: tuple[Gaussian, Gaussian] | None
    lanes_px: tuple[Gaussian, Gaussian] | None
    rulers: tuple[Ruler, ...]
    speed_heights: float | None
    frames: int
    moved_s: tuple[float, float] | None = None
    by_turns: LensByTurns | None = None
    focal_px: float = 0.0
    speed_times_ns: tuple[int, ...] = ()

    def evidence(self) -> Evidence:
        """As the joint fit takes it."""
        focal_px = None if self.by_turns is None else self.by_turns.focal_px
        return Evidence(travel_px=self.leads_to_px, rulers=self.rulers, focal_px=focal_px)

    @property
    def leads_to_px(self) -> tuple[Gaussian, Gaussian] | None:
        """Column and row that the road leads to: by the drive, and by its lines."""
        if self.travel_px is None or self.lanes_px is None:
            return self.travel_px or self.lanes_px
        column, row = map(_together, self.travel_px, self.lanes_px)
        return column, row

    def height_by_speed(self, speed_mps: float) -> Gaussian:
        """Height of the camera, where the mean speed over the clip is known.

        Raises:
            UserError: the picture does not tell how fast the road went by.
        """
        if self.speed_heights is None:
            raise UserError(
                f"speed {speed_mps:g} m/s: the picture does not tell how fast the road goes by, so "
                "no height follows; measure the camera's height"
            )
        height_m = speed_mps / self.speed_heights
        return Gaussian(height_m, SPEED_SIGMA * height_m)


@dataclass(frozen=True, slots=True)
class ClipCalibration:
    """What a clip tells of its camera.

    Attributes:
        calibration: with what is not known in its intervals.
        seen: what it is made of.
        shows_road: whether anything tells where the road lies; else the camera looks as most cameras do.
        by_motion: whether the motion of the camera tells where the road lies.
        piece_s: the piece of the clip that it holds for, where the camera was moved in it; else None.
        focal_px: what the turns of the clip tell; None where they tell nothing, or the view was stated.
        lens: of a camera that bends straight lines, by the turns. Unless somebody clicked in a picture,
            nothing more was looked for: the calibration is a guess until the clip is seen through the lens.
        contradiction: between its drive and its vehicles, which the intervals have; None where they agree, or
            something else that was stated decides.
    """

    calibration: Calibration
    seen: ClipObservations
    shows_road: bool
    by_motion: bool
    piece_s: tuple[float, float] | None = None
    focal_px: Gaussian | None = None
    lens: Lens | None = None
    contradiction: Contradiction | None = None

    @property
    def piece_words(self) -> str:
        """For which piece of the clip it holds; empty for all of it."""
        if self.piece_s is None:
            return ""
        begin_s, end_s = self.piece_s
        return f"from {begin_s:.0f} s on" if begin_s else f"until {end_s:.0f} s"


def rough_calibration(image_size: ImageSize, height_m: float, priors: Priors | None = None) -> Calibration:
    """A camera that nothing is known of but its height: the usual lens, looking slightly down."""
    priors = priors or Priors()
    view = priors.field_of_view_rad or usual_lens(image_size).field_of_view_rad
    assert view is not None
    camera = GroundPlaneCamera(
        ASSUMED_PITCH_RAD,
        image_size.width / 2 / math.tan(view.value / 2),
        (image_size.height - 1) / 2 if priors.principal_row_px is None else priors.principal_row_px.value,
        height_m,
        (image_size.width - 1) / 2,
    )
    return Calibration.from_camera(camera, image_size)


def calibrate_clip(
    source: Source,
    detector: Detector,
    height_m: Gaussian,
    evidence: Evidence | None = None,
    priors: Priors | None = None,
    lens: Lens | None = None,
    speed_mps: float | None = None,
    on_frame: Callable[[], None] = lambda: None,
    turns: bool = True,
    enough_s: float = math.inf,
) -> ClipCalibration:
    """Calibrate a recorded clip from what it shows and what is known besides.

    Args:
        source: pictures of the camera; straight ones where a lens is given (`fcw.sources.straight`).
        detector: that needs no calibration: it looks everywhere.
        height_m: of the camera; a class of `VEHICLE_HEIGHTS_M` where nobody measured it.
        evidence: what somebody clicked in a picture.
        priors: what else is stated.
        lens: intrinsics where they are known.
        speed_mps: mean speed over the clip, where it is known.
        on_frame: called after each picture.
        turns: whether to look for the lens in the turns of the clip, where it is not stated.
        enough_s: so much straight driving is enough.

    Raises:
        UserError: a speed is given, and the clip does not show how fast the road goes by.
    """
    priors, evidence, size = priors or Priors(), evidence or Evidence(), source.image_size
    if lens is not None and priors.field_of_view_rad is None:
        known_rad = 2 * math.atan(size.width / 2 / lens.focal_y_px)
        guess = rough_calibration(size, height_m.value, Priors(Gaussian(known_rad, 0.01)))
    else:
        guess = rough_calibration(size, height_m.value, priors)
    calibration, piece_s, shows_road = guess, None, False
    asks_turns = turns and lens is None and priors.field_of_view_rad is None
    look = partial(observe_clip, source, on_frame=on_frame, enough_s=enough_s)
    seen = look(guess, detector, asks_turns=asks_turns)
    if seen.moved_s is not None:
        piece_s = _before_or_after(seen.moved_s)
        seen = look(guess, detector, piece_s, asks_turns=asks_turns)
    focal_px = None if seen.by_turns is None else seen.by_turns.focal_px
    bent = None if seen.by_turns is None else seen.by_turns.bent_lens(size)
    if bent is not None:
        if evidence == Evidence():
            return ClipCalibration(guess, seen, False, False, piece_s, focal_px, bent)
        seen = replace(seen, by_turns=None)
    known = Known(evidence, size, height_m, priors=priors, lens=lens, rough=True)
    for turn in range(PASSES):
        # Own motion believes the camera that it is given: what it finds is the next guess.
        if turn:
            seen = look(calibration, None, piece_s or WHOLE_CLIP_S, seen=seen)
        told = seen.evidence()
        all_known = replace(evidence, travel_px=told.travel_px, rulers=told.rulers, focal_px=told.focal_px)
        if speed_mps is not None:
            # How fast the road flows by tells height times focal length: with another lens another height.
            by_speed = seen.height_by_speed(speed_mps)
            scale = Gaussian(by_speed.value * seen.focal_px, by_speed.sigma * seen.focal_px)
            all_known = replace(all_known, scale_px_m=scale)
        known = replace(known, evidence=all_known)
        before, calibration = calibration, calibrate_jointly(known)
        shows_road = known.tells_of_the_road or bool(seen.rulers)
        if abs(calibration.horizon_row_px - before.horizon_row_px) < SETTLED_PX:
            break
    contradiction = None
    if evidence == Evidence() and priors.horizon_row_px is None:
        contradiction = contradiction_in(known)
    if contradiction is not None:
        calibration = contradiction.widened(calibration)
    by_motion = seen.travel_px is not None
    return ClipCalibration(calibration, seen, shows_road, by_motion, piece_s, focal_px, bent, contradiction)


def _before_or_after(moved_s: tuple[float, float]) -> tuple[float, float]:
    """The piece that counts of a clip in which the camera was moved: what led to it, or all that follows."""
    end_s = moved_s[0] - BEFORE_MOVE_S
    return (0.0, end_s) if end_s >= SHORTEST_PIECE_S else (moved_s[1], LONGEST_S)


def observe_clip(
    source: Source,
    guess: Calibration,
    detector: Detector | None,
    piece_s: tuple[float, float] = WHOLE_CLIP_S,
    on_frame: Callable[[], None] = lambda: None,
    seen: ClipObservations | None = None,
    asks_turns: bool = False,
    enough_s: float = math.inf,
) -> ClipObservations:
    """Look through a clip.

    Args:
        source: straight pictures.
        guess: a rough calibration; its height is the unit of the speed, its angles are taken out again.
        detector: that needs no calibration: it looks everywhere; None takes the vehicles of an earlier look.
        piece_s: from when to when the clip is looked at.
        on_frame: called after each picture.
        seen: the earlier look.
        asks_turns: whether to look for the lens in the turns.
        enough_s: so much straight driving is enough.
    """
    # What the road as a whole tells of the speed is too rough for a scale, and tells nothing of the mount.
    settings = MotionSettings(calibration_pitch_sigma_rad=GUESS_PITCH_SIGMA_RAD, asks_road=False)
    camera = guess.camera
    estimator = MotionEstimator(guess, settings)
    tracks = PointTracks(guess.image_size.width) if asks_turns else None
    boxes: tuple[Box, ...] = ()
    vehicles = VehicleRulers(guess.image_size)
    mounts: list[Mount] = []
    speeds: list[float] = []
    speed_times_ns: list[int] = []
    straight_s, last_s = 0.0, None
    meetings: list[PixelPoint] = []
    signs: list[tuple[float, float]] = []
    pictures: list[NDArray[np.uint8]] = []
    first_ns = detected_ns = lanes_ns = None
    frames = 0
    for frame in source.frames():
        first_ns = frame.time_ns if first_ns is None else first_ns
        time_s = (frame.time_ns - first_ns) / 1e9
        if time_s > piece_s[1]:
            break
        if time_s < piece_s[0]:
            continue
        if seen is None and (lanes_ns is None or (frame.time_ns - lanes_ns) / 1e9 >= LANES_EVERY_S):
            lanes_ns = frame.time_ns
            with suppress(UserError):
                meetings.append(lanes_meet(frame.image, camera))
                signs.append((time_s, meetings[-1][1]))
            if len(pictures) < YAWED_PICTURES:
                pictures.append(frame.image)
        if detector is not None and (
            detected_ns is None or (frame.time_ns - detected_ns) / 1e9 >= DETECTED_EVERY_S
        ):
            detected_ns, frames = frame.time_ns, frames + 1
            found = detector.detect(frame.image)
            boxes = tuple(detection.box for detection in found)
            signs += [
                (time_s, ruler.row_px - ruler.width_px * camera.height_m / ruler.width_m.value)
                for ruler in vehicles.look(boxes)
                if ruler.width_px < FARTHEST_SIGN_PART * camera.focal_y_px
            ]
        motion = estimator.update(frame.time_ns, frame.image, boxes)
        if tracks is not None:
            tracks.update(time_s, frame.image)
        if motion.mount is not None and motion.speed_mps is not None:
            speeds.append(motion.speed_mps / camera.height_m)
            speed_times_ns.append(frame.time_ns)
            turns = abs(motion.yaw_rate_radps or 0.0) >= FASTEST_TURN_RADPS
            if motion.speed_mps > SLOWEST_TRAVEL_MPS and not turns:
                mounts.append(motion.mount)
                straight_s += 0.0 if last_s is None else time_s - last_s
        last_s = time_s
        on_frame()
        if straight_s >= enough_s:
            break
    travel = _travel(mounts[-1], camera, settings) if mounts else None
    speed = float(np.mean(speeds)) if len(speeds) >= FEWEST_SPEEDS else None
    if speed is not None and speed * camera.height_m < SLOWEST_MEAN_MPS:
        speed = None
    if seen is not None:
        # A later look may tell less than an earlier one did, in a short clip.
        seen = replace(seen, travel_px=travel or seen.travel_px, moved_s=None)
        if speed is None:
            return seen
        times_ns = tuple(speed_times_ns)
        return replace(seen, speed_heights=speed, focal_px=camera.focal_y_px, speed_times_ns=times_ns)
    lanes = agreed_meeting(meetings, guess.image_size) or lanes_aside(pictures, camera)
    moved_s = moved_at(signs, camera.focal_y_px)
    by_turns = None if tracks is None or moved_s is not None else lens_by_turns(tracks)
    return ClipObservations(
        travel,
        lanes,
        vehicles.spread(),
        speed,
        frames,
        moved_s,
        by_turns,
        camera.focal_y_px,
        tuple(speed_times_ns),
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


def _travel(
    mount: Mount, guess: GroundPlaneCamera, settings: MotionSettings
) -> tuple[Gaussian, Gaussian] | None:
    """Column and row that straight driving leads to, by the drive alone; None where it tells too little.

    What is believed of the mount began with the guess, which is no evidence: it is taken out again.
    """
    places = []
    for believed_rad, sigma_rad, guessed_rad, guess_sigma_rad in (
        (mount.yaw_rad, mount.yaw_sigma_rad, 0.0, settings.calibration_yaw_sigma_rad),
        (mount.pitch_rad, mount.pitch_sigma_rad, guess.pitch_rad, settings.calibration_pitch_sigma_rad),
    ):
        if sigma_rad > TOLD_PART * guess_sigma_rad:
            return None
        precision, guessed = sigma_rad**-2, guess_sigma_rad**-2
        told_rad = (precision * believed_rad - guessed * guessed_rad) / (precision - guessed)
        places.append(Gaussian(told_rad, math.hypot((precision - guessed) ** -0.5, SLOPE_SIGMA_RAD)))
    (yaw, pitch), focal_px = places, guess.focal_y_px
    return (
        Gaussian(guess.principal_column_px + focal_px * math.tan(yaw.value), focal_px * yaw.sigma),
        Gaussian(guess.principal_row_px - focal_px * math.tan(pitch.value), focal_px * pitch.sigma),
    )
