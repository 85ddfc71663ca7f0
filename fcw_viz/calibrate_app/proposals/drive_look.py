"""What a drive shows of its camera without any calibration: where the horizon is, where it looks, its lens.

It is what `fcw calibrate --from-clip` finds (`fcw.self_calibration.clip`): where straight driving leads to,
and where the own lane's lines meet. That row hardly depends on the height and the lens that are taken for
granted here; the yaw that follows from the column does, on the lens.
"""

import logging
import math
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from fcw.camera.calibration import Calibration, Gaussian
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.joint.evidence import Evidence, Ruler
from fcw.camera.joint.known import Known
from fcw.camera.prior_sigmas import CAR_CAMERA_HEIGHT_M
from fcw.camera.straight import Orientation
from fcw.detection.choice import searching_detector
from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw.motion.travel.tracks import PointTracks
from fcw.self_calibration.clip import (
    VEHICLE_HEIGHTS_M,
    ClipObservations,
    calibrate_clip,
    rough_calibration,
)
from fcw.self_calibration.parts import LONGEST_S, longest_part_s, pictures_of, piece_words
from fcw.self_calibration.turning.by_turns import lens_by_turns
from fcw.self_calibration.vehicles import vehicles_of
from fcw.warning.ego_speed import EgoSpeed
from fcw_viz.calibrate_app.document.besides.joint_fit import FEWEST_VEHICLES
from fcw_viz.page.pictures import Pictures

LOGGER = logging.getLogger(__name__)

ASSUMED_VIEW_RAD = math.radians(65.0)
"""Along the longer side of the picture."""
ENOUGH_S = 10.0
"""Of driving."""
LEAST_KNOWN_PART = 0.5
"""Of the pictures whose speed is asked for."""
VEHICLES_S = 20.0
TOLD_EVERY_S = 1.0
"""How far a look has come."""
LARGEST_SIGMA_HEIGHTS = 0.05
"""In picture heights: a horizon that is known less well is not proposed. Set with the clips of
docs/figures/calibration.md, "Horizons of strangers' clips", in view."""
ROAD_SIGMA_HEIGHTS = 0.004
"""In picture heights: roads are not level with the travel."""

LARGEST_YAW_SIGMA_RAD = math.radians(1.5)
"""Less sure, what is believed of every camera is about as good."""


@dataclass(frozen=True, slots=True)
class Look:
    """What came of it.

    Attributes:
        horizon: row, with its standard deviation; None where the drive does not show it.
        words: what to tell, either way.
        scale_per_mps: focal length times height, in px m, for each m/s of the mean speed; None where unknown,
            or where the car stood for most of the time.
        vehicles: seen on the way.
        times_ns: of the pictures whose speed that mean is of.
        first_ns: time of the drive's first picture.
        yaw_rad: of the camera, to the left of the direction of travel; None where the drive does not show it.
        view_rad: horizontal field of view of the whole picture; None where the drive does not show it.
        instead: what else would do, where that was not done yet.
    """

    horizon: Gaussian | None
    words: str
    scale_per_mps: float | None = None
    vehicles: tuple[Ruler, ...] = ()
    times_ns: tuple[int, ...] = ()
    first_ns: int = 0
    yaw_rad: Gaussian | None = None
    view_rad: Gaussian | None = None
    instead: str = ""

    def mean_speed_mps(self, own_speed: EgoSpeed, name: str) -> float:
        """The mean over the same pictures by a file of speeds.

        Args:
            own_speed: over the time of the drive.
            name: of its file.

        Raises:
            UserError: it does not cover them.
        """
        zero_ns = self.first_ns if own_speed.from_first_frame else 0
        found = [own_speed.at(time_ns - zero_ns) for time_ns in self.times_ns]
        speeds_mps = [speed_mps for speed_mps in found if speed_mps is not None]
        if not speeds_mps or len(speeds_mps) < LEAST_KNOWN_PART * len(found):
            raise UserError(
                f"{name}: it has no speed for the seconds that were analysed; expected times on the clock "
                "of the drive, or of a GPX track that begins with it"
            )
        return float(np.mean(speeds_mps))


def look_at(pictures: Pictures, going_on: Callable[[], bool] = lambda: True) -> Look:
    """Go through the drive's pictures until they have told enough.

    Args:
        pictures: of the drive.
        going_on: whether somebody still wants to know.

    Raises:
        UserError: the pictures cannot be read.
    """
    if pictures.count < 2:
        return Look(None, "One picture shows no motion: drag the horizon, or draw two lane lines.")
    size = pictures.image_size

    def on_frame() -> None:
        if not going_on():
            raise _NobodyAsksError

    try:
        found = calibrate_clip(
            pictures.source,
            searching_detector(rough_calibration(size, CAR_CAMERA_HEIGHT_M)),
            Known(Evidence(), size, VEHICLE_HEIGHTS_M["car"]),
            on_frame=on_frame,
            turns=False,
            asks_speed=True,
            enough_s=ENOUGH_S,
        )
    except _NobodyAsksError:
        return Look(None, "")
    seen, speed = found.seen, found.speed
    scale, times_ns = (None, ()) if speed is None else (speed.scale_per_mps, speed.times_ns)
    first_ns = next(pictures.source.frames()).time_ns
    horizon = None if seen.leads_to_px is None else seen.leads_to_px[1]
    if horizon is None or horizon.sigma > LARGEST_SIGMA_HEIGHTS * size.height:
        instead = "use the vehicles ahead as rulers, or " if len(seen.rulers) >= FEWEST_VEHICLES else ""
        words = f"The drive shows no horizon: {_why_not(seen)}; {instead}drag the horizon."
        return Look(None, words, scale, times_ns=times_ns, first_ns=first_ns)
    horizon = Gaussian(horizon.value, math.hypot(horizon.sigma, ROAD_SIGMA_HEIGHTS * size.height))
    yaw_rad = _yaw(found.calibration.orientation)
    words = (
        f"By the drive's {_sources(seen)}, the horizon is at row {horizon.value:.0f} ± {horizon.sigma:.0f}"
    )
    words += "." if yaw_rad is None else f", and the yaw is {_turn_words(yaw_rad)}."
    if seen.travel_px is None:
        words += " Does a flat road end there? If not, drag it."
    if found.piece_words:
        why = "the clip is cut there" if found.is_cut else "the horizon jumps there, the camera was moved"
        words += f" This holds {found.piece_words}: {why}."
    return Look(horizon, words, scale, times_ns=times_ns, first_ns=first_ns, yaw_rad=yaw_rad)


class _NobodyAsksError(Exception):
    """Nobody wants to know any more."""


def _sources(seen: ClipObservations) -> str:
    if seen.travel_px is None:
        return "lane lines alone"
    return "motion alone" if seen.lanes_px is None else "motion and lane lines"


def _why_not(seen: ClipObservations) -> str:
    """Why there is no horizon to propose."""
    by_motion, by_lanes = (
        None if place is None else f"row {place[1].value:.0f} ± {place[1].sigma:.0f}"
        for place in (seen.travel_px, seen.lanes_px)
    )
    if by_motion and by_lanes:
        return f"its motion says {by_motion}, its lane lines {by_lanes}"
    if by_motion or by_lanes:
        return f"by its {_sources(seen)}, it is at {by_motion or by_lanes}"
    return "neither its motion nor its lane lines show it"


def _yaw(orientation: Orientation) -> Gaussian | None:
    """With what another lens and the road may make of it; None where that is too much."""
    if orientation.yaw_sigma_rad > LARGEST_YAW_SIGMA_RAD:
        return None
    return Gaussian(orientation.yaw_rad, orientation.yaw_sigma_rad)


def _turn_words(yaw_rad: Gaussian) -> str:
    side = "left" if yaw_rad.value >= 0 else "right"
    return f"{math.degrees(abs(yaw_rad.value)):.1f} ± {math.degrees(yaw_rad.sigma):.1f}° to the {side}"


def find_vehicles(pictures: Pictures, going_on: Callable[[], bool] = lambda: True) -> Look:
    """Vehicles ahead in the drive, each once, for the width that vehicles have.

    Args:
        pictures: of the drive.
        going_on: whether somebody still wants to know.

    Raises:
        UserError: the pictures cannot be read.
    """
    size = pictures.image_size
    detector = searching_detector(Calibration.from_camera(assumed_camera(size), size))
    part_s = longest_part_s(pictures.source, VEHICLES_S, going_on)
    rulers, frames = vehicles_of(pictures.source, detector, part_s, going_on)
    if len(rulers) < FEWEST_VEHICLES:
        found = "1 vehicle" if len(rulers) == 1 else f"{len(rulers)} vehicles"
        return Look(
            None,
            f"{found} found in {frames} pictures; at least {FEWEST_VEHICLES} are needed.",
            instead="Use the horizon that the drive shows instead, or draw two lane lines.",
        )
    words = f"{len(rulers)} vehicles found in {frames} pictures; press again to use them as rulers."
    return Look(None, words + _part_words(part_s, VEHICLES_S), vehicles=rulers)


def find_view(pictures: Pictures, going_on: Callable[[], bool] = lambda: True) -> Look:
    """The field of view, by how the picture moves in turns.

    Args:
        pictures: of the drive.
        going_on: whether somebody still wants to know.

    Raises:
        UserError: the pictures cannot be read.
    """
    size = pictures.image_size
    tracks = PointTracks(size.width)
    part_s = longest_part_s(pictures.source, LONGEST_S, going_on)
    for time_s, frame in pictures_of(pictures.source, part_s):
        if not going_on():
            return Look(None, "")
        tracks.update(time_s, frame.image)
    told = lens_by_turns(tracks)
    if told is None:
        return Look(
            None,
            "The drive does not show the field of view: it turns too little, or traffic hides what stands "
            "still.",
        )
    half_px, focal_px = size.width / 2, told.focal_px
    if told.bend is not None:
        words = (
            f"The turns show that the lens bends straight lines (its focal length is {focal_px.value:.0f} px"
        )
        return Look(None, f"{words} ± {focal_px.sigma:.0f}): import it, or click along something straight.")
    sigma_rad = 2 * half_px * focal_px.sigma / (focal_px.value**2 + half_px**2)
    view = Gaussian(2 * math.atan(half_px / focal_px.value), sigma_rad)
    view_deg, sigma_deg = math.degrees(view.value), math.degrees(sigma_rad)
    words = f"By the drive's turns, the field of view is {view_deg:.0f} ± {sigma_deg:.0f}°."
    return Look(None, words + _part_words(part_s, LONGEST_S), view_rad=view)


def _part_words(part_s: tuple[float, float], longest_s: float) -> str:
    """Which part of a clip that is cut was looked at; empty where it is not cut."""
    if part_s == (0.0, longest_s):
        return ""
    return f" The clip is cut: this is from its longest part, {piece_words(part_s)}."


class DriveLook:
    """One look at a drive, in a thread of its own, for all tabs.

    Attributes:
        running: whether it is under way.
        picture_count: how many pictures were looked at so far, each as often as it was.
        look: what came of it; None before.
    """

    def __init__(
        self, pictures: Pictures, look: Callable[[Pictures, Callable[[], bool]], Look] = look_at
    ) -> None:
        self._pictures, self._look_at = pictures, look
        self._listeners: list[Callable[[], None]] = []
        self._closed = threading.Event()
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self._told_s = 0.0
        self.running = False
        self.picture_count = 0
        self.look: Look | None = None

    def listen(self, listener: Callable[[], None]) -> Callable[[], None]:
        """Call `listener` when there is something new; returns what ends that."""
        self._listeners.append(listener)
        return lambda: self._listeners.remove(listener)

    def start(self) -> None:
        """Look, unless that was done or is under way."""
        with self._lock:
            if self.running or self.look is not None:
                return
            self.running = True
        self._tell()
        self._thread = threading.Thread(target=self._run, name="drive look", daemon=True)
        self._thread.start()

    def wait(self) -> None:
        """Until it is done, where it was started."""
        if self._thread is not None:
            self._thread.join()

    def close(self) -> None:
        """Nobody wants to know any more."""
        self._closed.set()

    def _run(self) -> None:
        try:
            look = self._look_at(self._pictures, self._going_on)
        except UserError as error:
            look = Look(None, f"{error}. Type it yourself instead.")
        except Exception:
            LOGGER.exception("the look at the drive failed")
            look = Look(None, "That failed because of a fault in the program; type it yourself instead.")
        self.look, self.running = look, False
        if not self._closed.is_set():
            self._tell()

    def _going_on(self) -> bool:
        self.picture_count += 1
        if time.monotonic() - self._told_s >= TOLD_EVERY_S:
            self._tell()
        return not self._closed.is_set()

    def _tell(self) -> None:
        self._told_s = time.monotonic()
        for listener in list(self._listeners):
            listener()


@dataclass(frozen=True, slots=True)
class DriveLooks:
    """All that is looked for in a drive, each once it is wanted.

    Attributes:
        horizon: and where the camera looks.
        vehicles: as rulers.
        view: the field of view.
    """

    horizon: DriveLook
    vehicles: DriveLook
    view: DriveLook

    @classmethod
    def at(cls, pictures: Pictures) -> "DriveLooks":
        """The looks at a drive; none has begun."""
        return cls(DriveLook(pictures), DriveLook(pictures, find_vehicles), DriveLook(pictures, find_view))

    def __iter__(self) -> Iterator[DriveLook]:
        return iter((self.horizon, self.vehicles, self.view))


def assumed_camera(size: ImageSize, horizon: Gaussian | None = None) -> GroundPlaneCamera:
    """An ordinary camera that nothing is known of, but where a drive showed the horizon."""
    focal_px = max(size.width, size.height) / 2 / math.tan(ASSUMED_VIEW_RAD / 2)
    middle_px = (size.height - 1) / 2
    pitch_rad = 0.0 if horizon is None else math.atan((middle_px - horizon.value) / focal_px)
    return GroundPlaneCamera(pitch_rad, focal_px, middle_px, CAR_CAMERA_HEIGHT_M, (size.width - 1) / 2)
