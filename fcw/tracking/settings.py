"""Settings of the tracker."""

from dataclasses import dataclass, field

from fcw.tracking.belief.settings import BeliefSettings
from fcw.tracking.horizon import MountWatchSettings
from fcw.tracking.lead import Corridor
from fcw.tracking.lead_speed import SpeedPrior
from fcw.tracking.picture.follower import FollowingSettings
from fcw.tracking.range.model import RangeModel
from fcw.tracking.ranging import BoxNoise


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackerSettings:
    """How tracks are associated, born and ended.

    Attributes:
        box_noise: errors of the detector's boxes.
        model: the range filter's model of vehicles, camera and road.
        corridor: the own path.
        minimum_iou: least overlap of a detection with the predicted box of a track.
        faint_iou: the same for a faint detection, without allowance for noise or for parts of vehicles.
        maximum_scale_ratio: largest ratio of their widths: above twice the noise of small boxes, below the
            ratio between a car and the second car ahead of it.
        confirm_hits: detections that a track needs to be confirmed. They must also be half of its frames
            (false alarms rarely repeat in place), or `confirm_part` of them.
        confirm_part: a part of its frames that is enough if `confirm_in_a_row` of the detections were in
            consecutive frames and its box is clear: detectors lose vehicles in more than half of the frames.
        confirm_in_a_row: see `confirm_part`.
        unconfirmed_s: time for which a track with a clear box is kept without a detection before it is
            confirmed.
        clear_sigmas: a box is clear if it is this many times as high as the noise of its edges. Smaller ones
            are too often no vehicle.
        coast_s: a track without a detection for longer than this ends.
        box_smoothing_s: time constant of the filtered box.
        padding_sigmas: boxes are widened by this many sigmas of their noise before their overlap is judged,
            as the smallest ones are no larger than their noise.
        part_hits: number of detections after which a vehicle is known well enough to tell when only a part of
            it is boxed.
        part_s: longest time since its last detection for that, and longest time for which it may be believed
            that only a part is boxed.
        new_s: every frame is searched while a vehicle within `aside_m` was first found less than this time
            ago.
        soon_s: every frame is also searched while such a vehicle would be reached within this time.
        aside_m: largest lateral distance from the camera, for `new_s` and `soon_s`.
        mount: when a moved mount is reported.
        speed_prior: prior of other vehicles' speeds.
        following: how vehicles are followed by the picture.
        belief: when a detected object is believed to be a vehicle.
    """

    box_noise: BoxNoise = field(default_factory=BoxNoise)
    model: RangeModel = field(default_factory=RangeModel)
    corridor: Corridor = field(default_factory=Corridor)
    minimum_iou: float = 0.2
    faint_iou: float = 0.5
    maximum_scale_ratio: float = 1.5
    confirm_hits: int = 3
    confirm_part: float = 0.34
    confirm_in_a_row: int = 2
    unconfirmed_s: float = 0.3
    clear_sigmas: float = 10.0
    coast_s: float = 0.8
    box_smoothing_s: float = 0.1
    padding_sigmas: float = 2.0
    part_hits: int = 5
    part_s: float = 1.0
    new_s: float = 0.7
    soon_s: float = 5.0
    aside_m: float = 5.0
    mount: MountWatchSettings = field(default_factory=MountWatchSettings)
    speed_prior: SpeedPrior = field(default_factory=SpeedPrior)
    following: FollowingSettings = field(default_factory=FollowingSettings)
    belief: BeliefSettings = field(default_factory=BeliefSettings)
