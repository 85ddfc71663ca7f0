"""What a drive shows of its camera without any calibration: where the horizon is, and where it looks.

While a car drives straight, everything that stands streams out of one point of the picture, which lies on the
horizon of a flat road (`fcw.motion` finds it together with speed and turning). That row hardly depends on the
height and the lens that are taken for granted here; the yaw that follows from the column does, on the lens.
"""

import logging
import math
import threading
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from fcw.camera.calibration import Calibration, Gaussian
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.joint.evidence import Ruler
from fcw.detection.choice import searching_detector
from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw.motion.estimator import MotionEstimator
from fcw.motion.settings import MotionSettings
from fcw.motion.state import Mount
from fcw.self_calibration.vehicles import vehicles_of
from fcw.warning.ego_speed import EgoSpeed
from fcw_viz.calibrate_app.document.besides.joint_fit import FEWEST_VEHICLES
from fcw_viz.page.pictures import Pictures

LOGGER = logging.getLogger(__name__)

ASSUMED_HEIGHT_M, ASSUMED_VIEW_RAD = 1.3, math.radians(65.0)
"""The field of view is that along the longer side of the picture."""
SETTINGS = replace(
    MotionSettings(),
    calibration_pitch_sigma_rad=math.radians(4.0),
    calibration_yaw_sigma_rad=math.radians(4.0),
    calibration_roll_sigma_rad=math.radians(2.0),
    mount_after_s=0.0,
    direction_s=math.inf,
)
"""Nothing has been calibrated yet: only that somebody put the camera up to look ahead. Whether the motion was
understood is judged at the end, of the whole look (`LEAST_KNOWN_PART`), not second by second. And nobody has
looked for vehicles: without the road, what moves in the picture may be them."""
LONGEST_LOOK_S, ENOUGH_S = 90.0, 10.0
"""So much of the drive is looked at, or until so much of it had a known speed."""
LEAST_KNOWN_S = 1.0
LEAST_KNOWN_PART = 0.5
"""Of the time since the speed was first known: where it comes and goes, the motion was not understood."""
VEHICLES_S = 20.0
LARGEST_SIGMA_HEIGHTS = 0.012
ROAD_SIGMA_HEIGHTS = 0.004
"""In picture heights: root mean square of what the drives of `test_drive_look.py` missed, with the error of
their own truth; roads are not level with the travel."""

LARGEST_YAW_SIGMA_RAD = math.radians(1.0)
ROAD_YAW_SIGMA_RAD = math.radians(0.5)
"""Roads bend. Twice what nine drives missed (root mean square) of the yaw by `--from-clip`, which is not
independent: it sees the same motion, and lane lines besides."""
LENS_PART = 0.2
"""Other lenses have so much more or less focal length than the one assumed, and the yaw less or more."""


@dataclass(frozen=True, slots=True)
class Look:
    """What came of it.

    Attributes:
        horizon: row, with its standard deviation; None where the drive does not show it.
        words: what to tell, either way.
        scale_per_mps: focal length times height, in px m, for each m/s of the mean speed; None where unknown.
        vehicles: seen on the way.
        times_ns: of the pictures whose speed that mean is of.
        yaw_rad: of the camera, to the left of the direction of travel; None where the drive does not show it.
        instead: what else would do, where that was not done yet.
    """

    horizon: Gaussian | None
    words: str
    scale_per_mps: float | None = None
    vehicles: tuple[Ruler, ...] = ()
    times_ns: tuple[int, ...] = ()
    yaw_rad: Gaussian | None = None
    instead: str = ""

    def mean_speed_mps(self, own_speed: EgoSpeed, name: str) -> float:
        """The mean over the same pictures by a file of speeds.

        Args:
            own_speed: over the time of the drive.
            name: of its file.

        Raises:
            UserError: it does not cover them.
        """
        found = [own_speed.at(time_ns) for time_ns in self.times_ns]
        speeds_mps = [speed_mps for speed_mps in found if speed_mps is not None]
        if not speeds_mps or len(speeds_mps) < LEAST_KNOWN_PART * len(found):
            raise UserError(
                f"{name}: it has no speed for the seconds that were looked at; expected times that count "
                "from the drive's first picture"
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
    camera = assumed_camera(size)
    estimator = MotionEstimator(Calibration.from_camera(camera, size), SETTINGS)
    first_s = last_s = None
    known_s = since_s = 0.0
    speeds_mps: list[float] = []
    times_ns: list[int] = []
    for frame in pictures.source.frames():
        now_s = frame.time_ns / 1e9
        first_s = now_s if first_s is None else first_s
        motion = estimator.update(frame.time_ns, frame.image)
        step_s = 0.0 if last_s is None else now_s - last_s
        last_s = now_s
        known_s += step_s if motion.picture_speed_mps else 0.0
        if motion.picture_speed_mps:
            speeds_mps.append(motion.picture_speed_mps)
            times_ns.append(frame.time_ns)
        since_s += step_s if known_s else 0.0
        if known_s >= ENOUGH_S or now_s - first_s >= LONGEST_LOOK_S or not going_on():
            break
    mount = estimator.state.mount
    sigma_px = math.inf if mount is None else camera.focal_y_px * mount.pitch_sigma_rad
    why_not = _why_not(known_s, since_s, sigma_px, size)
    if mount is None or why_not:
        return Look(None, f"The drive does not show it: {why_not}; drag the horizon.")
    row_px = camera.principal_row_px - camera.focal_y_px * math.tan(mount.pitch_rad)
    sigma_px = math.hypot(sigma_px, ROAD_SIGMA_HEIGHTS * size.height)
    yaw_rad = _yaw(mount)
    words = f"Over {known_s:.0f} s of driving the horizon is at row {row_px:.0f} ± {sigma_px:.0f}"
    words += "." if yaw_rad is None else f", and the camera looks {_turn_words(yaw_rad)}."
    # The road flows by as fast as lens and height together make it: what was assumed for both cancels.
    scale = camera.focal_y_px * camera.height_m / float(np.mean(speeds_mps))
    return Look(Gaussian(row_px, sigma_px), words, scale, times_ns=tuple(times_ns), yaw_rad=yaw_rad)


def _why_not(known_s: float, since_s: float, sigma_px: float, size: ImageSize) -> str:
    """Why a drive shows no horizon; empty where it does."""
    if known_s < LEAST_KNOWN_S:
        return "no motion is seen in it (it is too dark or too short, or it stands)"
    if known_s < LEAST_KNOWN_PART * since_s:
        return f"its motion is understood in only {known_s:.0f} of {since_s:.0f} s"
    if sigma_px > LARGEST_SIGMA_HEIGHTS * size.height:
        spread = f"± {sigma_px:.0f} rows" if math.isfinite(sigma_px) else "any row"
        return f"{known_s:.0f} s of driving leave it at {spread} (a longer or straighter piece may do)"
    return ""


def _yaw(mount: Mount) -> Gaussian | None:
    """Of the assumed lens, with what another one and the road may add."""
    if mount.yaw_sigma_rad > LARGEST_YAW_SIGMA_RAD:
        return None
    sigma_rad = math.hypot(mount.yaw_sigma_rad, ROAD_YAW_SIGMA_RAD, LENS_PART * mount.yaw_rad)
    return Gaussian(mount.yaw_rad, sigma_rad)


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
    rulers, frames = vehicles_of(pictures.source, detector, VEHICLES_S, going_on)
    if len(rulers) < FEWEST_VEHICLES:
        found = "1 vehicle" if len(rulers) == 1 else f"{len(rulers)} vehicles"
        return Look(
            None,
            f"{found} found in {frames} pictures, and {FEWEST_VEHICLES} or more are needed.",
            instead="Take the horizon that the drive shows instead, or draw two lane lines.",
        )
    words = f"{len(rulers)} vehicles found in {frames} pictures; press again to take them as rulers."
    return Look(None, words, vehicles=rulers)


class DriveLook:
    """One look at a drive, in a thread of its own, for all tabs.

    Attributes:
        running: whether it is under way.
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
        self.running = False
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
            look = self._look_at(self._pictures, lambda: not self._closed.is_set())
        except UserError as error:
            look = Look(None, f"{error}. Drag the horizon instead.")
        except Exception:
            LOGGER.exception("the look at the drive failed")
            look = Look(None, "That failed by a fault of the program; drag the horizon instead.")
        self.look, self.running = look, False
        if not self._closed.is_set():
            self._tell()

    def _tell(self) -> None:
        for listener in list(self._listeners):
            listener()


def assumed_camera(size: ImageSize, horizon: Gaussian | None = None) -> GroundPlaneCamera:
    """An ordinary camera that nothing is known of, but where a drive showed the horizon."""
    focal_px = max(size.width, size.height) / 2 / math.tan(ASSUMED_VIEW_RAD / 2)
    middle_px = (size.height - 1) / 2
    pitch_rad = 0.0 if horizon is None else math.atan((middle_px - horizon.value) / focal_px)
    return GroundPlaneCamera(pitch_rad, focal_px, middle_px, ASSUMED_HEIGHT_M, (size.width - 1) / 2)
