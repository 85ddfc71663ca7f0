"""What the tracker goes by."""

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
        model: what the range filter believes of vehicles, camera and road.
        corridor: the own path.
        minimum_iou: least overlap of a detection with the box predicted for a track.
        faint_iou: least overlap of a faint one, whose noise is no excuse, nor that it may be a part.
        maximum_scale_ratio: largest ratio of their widths: more than twice the noise of small boxes, less
            than between a car and the car two places ahead of it.
        confirm_hits: detections before a track is believed; false alarms rarely repeat in place.
        confirm_part: and it was found in half of the frames; or in so large a part of them, as detectors lose
            vehicles in more than half,
        confirm_in_a_row: and so often in two in a row.
        unconfirmed_s: a track that is not believed yet is kept so long without a detection.
        clear_sigmas: both for boxes so many times as high as their noise; smaller ones are another's too
            often.
        coast_s: a track without a detection for longer than this ends.
        box_smoothing_s: time constant of the filtered box.
        padding_sigmas: boxes are widened by so many sigmas of their noise before overlap is judged: the
            smallest are as large as their noise.
        part_hits: a vehicle found so often is known well enough to tell when a part of it is boxed,
        part_s: for so long.
        new_s: every frame is worth a search while a vehicle was first found less than this ago,
        soon_s: or while we would be at its rear within this time,
        aside_m: and while it is no farther to the side of the camera than this.
        mount: when a moved mount is said.
        speed_prior: of other vehicles, where the own speed is known.
        following: how vehicles are followed by the picture.
        belief: when what was found is believed to be a vehicle.
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
