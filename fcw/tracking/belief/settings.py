"""When a vehicle is believed."""

from dataclasses import dataclass, field

from fcw.tracking.belief.still_picture import StillPictureSettings


@dataclass(frozen=True, slots=True, kw_only=True)
class BeliefSettings:
    """When a vehicle is believed.

    Chosen and tried on the simulated threats and KITTI tracking 0000 to 0010; nothing was left out.

    Attributes:
        far_m: farther than this vehicles appear from nothing all the time, and hide nobody.
        side_part: a box this near to the picture's left or right edge, as a part of its width, came from
            there.
        start_s: what is there so soon after the first frame was there before.
        earned_s: what appeared near us is believed after so long if it comes nearer or moves away,
        earned_surely_s: or after so long where it does so at `surely_sigmas` of the closing speed: a
            reflection does not grow.
        earned_still_s: and after so long if it does not: no vehicle gets there without having moved.
        filling_part: as long as its box is so wide, as a part of the picture's width, it is not believed at
            all: what fills the picture was seen before it did. The whole road at night was boxed for five
            seconds, and seemed to move. Not tuned.
        earned_part: all this where the detector found it in so large a part of its frames, as for a track to
            be confirmed (not tuned): plain road that is boxed now and then seems to move, too, if carried.
        kept_part: what was believed is doubted again where the detector found it in a smaller part: a vehicle
            half hidden in single pictures is found in a third of them (the net's card).
        lately_s: time constant of these two parts: who is found in every frame is no less believed for having
            been far, and rarely found, before. As `earned_still_s`, not tuned.
        well_found_s: what the detector found for so long,
        well_found_part: and in so large a part of its frames, is no longer doubted for how it is found.
        surely_sigmas: see `earned_surely_s`.
        moving_sigmas: it does at this many sigmas of the closing speed,
        moving_mps: and this speed.
        through_part: somebody is seen through it where so much of their box is inside its own,
        through_ratio: and they are so many times as far away,
        through_s: and the detector found them there within this time.
        remembered_s: so long the place of a believed vehicle that was lost is kept: found again, it is
            believed.
        still: see `StillPictureSettings`.
    """

    far_m: float = 25.0
    side_part: float = 0.04
    start_s: float = 1.0
    earned_s: float = 0.6
    earned_surely_s: float = 0.25
    surely_sigmas: float = 4.0
    earned_still_s: float = 4.0
    filling_part: float = 0.5
    earned_part: float = 0.34
    kept_part: float = 0.25
    lately_s: float = 4.0
    well_found_s: float = 1.0
    well_found_part: float = 0.5
    moving_sigmas: float = 2.0
    moving_mps: float = 1.0
    through_part: float = 0.7
    through_ratio: float = 1.5
    through_s: float = 0.5
    remembered_s: float = 2.0
    still: StillPictureSettings = field(default_factory=StillPictureSettings)
