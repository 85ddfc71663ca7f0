"""How well a camera is known before any click, where nobody says how well: standard deviations.

From data sheets and the cameras of the data (KITTI, TuSimple, Udacity), not from any calibration's error.
"""

import math

FIELD_OF_VIEW_SIGMA_DEG = 3.0
"""Data sheets round, state the diagonal, or ignore what stabilisation crops."""
PRINCIPAL_ROW_SIGMA_HEIGHTS = 0.03
"""How far lens and sensor are off centre in ordinary cameras, in picture heights."""
USUAL_FIELD_OF_VIEW_DEG, USUAL_FIELD_OF_VIEW_SIGMA_DEG = 75.0, 25.0
"""Along the longer side of the picture, of any camera that somebody puts behind a windscreen; telephones and
cropped pictures see 45 degrees, wide dash cameras 110 once they are rectilinear."""
UNKNOWN_FIELD_OF_VIEW_DEG, UNKNOWN_FIELD_OF_VIEW_SIGMA_DEG = 66.0, 16.0
"""The same where no distance is marked, so that every distance is proportional to the focal length and the
belief decides: the middle and the spread of what the cameras of published drives see, 49 (Cityscapes), 58
(Udacity), 65 (nuScenes, comma2k19), 66 (RobotCar), 73 (ApolloScape), 81 (KITTI) and 84 degrees (TuSimple);
the median stays between 65 and 66 whichever is left out. Wide dash cameras lie within two sigmas."""
USUAL_TANGENT, USUAL_TANGENT_SIGMA = 0.05, 0.12
"""Of the pitch of a camera that somebody put up to look ahead: 3 degrees down, give or take 7."""
YAW_SIGMA_RAD = math.radians(5.0)
"""Of a camera that somebody pointed ahead by eye."""
ROLL_SIGMA_RAD = math.radians(1.5)
"""Of a camera that somebody mounted as level as the eye can."""
TAPE_ERROR = 0.01
"""Of taped distances, all together, as a part of them: the tape sags, or lies askew."""
MARK_ERROR_PART = 0.25
"""Of the tape's error, what each mark has for itself besides: it is laid and clicked by its edge."""
CAR_CAMERA_HEIGHT_M, CAR_CAMERA_HEIGHT_SIGMA_M = 1.3, 0.12
"""Above the road, of a lens at the mirror of an ordinary car."""
UNKNOWN_HEIGHT_M, UNKNOWN_HEIGHT_SIGMA_M = 1.5, 0.5
"""Of a lens behind any windscreen, a sports car's to a lorry's, where lengths on the road tell the rest."""
SIDE_SIGMA_M = 0.02
"""Of a taped side of a rectangle for itself, besides the tape's own error: paint is as wide as a hand, and is
clicked and taped by what should be the same edge."""
HORIZON_ROW_SIGMA_PX = 2.0
"""How well a horizon is dragged by eye, and how well two straight lane lines extended by eye meet."""
