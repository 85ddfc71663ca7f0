"""When a vehicle is believed."""

from dataclasses import dataclass, field

from fcw.tracking.belief.still_picture import StillPictureSettings


@dataclass(frozen=True, slots=True, kw_only=True)
class BeliefSettings:
    """When a vehicle is believed.

    Chosen and tried on the simulated threats and KITTI tracking 0000 to 0010; no drive was left out.

    Attributes:
        far_m: beyond this distance vehicles appear from nothing all the time, but hide no other one.
        side_part: a box this near to the left or right edge of the picture, as a fraction of the picture's
            width, came in from there.
        start_s: a vehicle seen this soon after the first frame was there before.
        earned_s: a vehicle that appeared near us is believed after this time if it comes nearer or moves
            away.
        earned_surely_s: the same if it does so by `surely_sigmas` of the closing speed, as a reflection does
            not grow.
        earned_still_s: the same if it does neither. This is long, because no vehicle gets there without
            moving.
        filling_part: a box that covers more than this fraction of the picture's width cannot earn belief. A
            vehicle that fills the picture was seen before it did. At night, the whole road was once boxed for
            five seconds, and seemed to move. Not tuned.
        earned_part: belief is earned only while the detector finds the vehicle in at least this fraction of
            its frames, the same as for confirming a track (not tuned). Plain road that is boxed now and then,
            and carried, seems to move, too.
        kept_part: a believed vehicle is doubted again if the detector finds it in a smaller fraction of its
            frames. Half-hidden vehicles are found in a third of single pictures (card of the net).
        lately_s: time constant of the last two fractions, so that a vehicle that is found in every frame now
            is not doubted for having been far away, and rarely found, before. The same as `earned_still_s`;
            not tuned.
        well_found_s: a vehicle that was found for this long, and in `well_found_part` of its frames, is no
            longer doubted for how often it is found.
        well_found_part: see `well_found_s`.
        surely_sigmas: see `earned_surely_s`.
        moving_sigmas: a vehicle moves if its closing speed is more than this many of its sigmas, and more
            than `moving_mps`.
        moving_mps: see `moving_sigmas`.
        through_part: a box is seen through if another vehicle was found within it during the last
            `through_s`: with this part of its own box inside, and `through_ratio` times as far away.
        through_ratio: see `through_part`.
        through_s: see `through_part`.
        remembered_s: time for which the place of a lost believed vehicle is remembered. A new vehicle there
            is believed at once.
        still: when something counts as stationary in the picture.
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
