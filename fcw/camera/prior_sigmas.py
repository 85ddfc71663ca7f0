"""Standard deviations of what is known about a camera before any click, used if none is given.

From data sheets and the cameras of the data (KITTI, TuSimple, Udacity), not from the error of any
calibration.
"""

import math

FIELD_OF_VIEW_SIGMA_DEG = 3.0
"""1-sigma of a stated field of view: data sheets round, state the diagonal, or ignore what stabilisation
crops."""
PRINCIPAL_ROW_SIGMA_HEIGHTS = 0.03
"""1-sigma of the optical axis about the middle of the picture in ordinary cameras, in picture heights."""
USUAL_FIELD_OF_VIEW_DEG, USUAL_FIELD_OF_VIEW_SIGMA_DEG = 75.0, 25.0
"""Field of view along the longer side of the picture, for any camera behind a windscreen. Telephones and
cropped pictures have 45 degrees, wide dash cameras 110 once they are rectilinear."""
UNKNOWN_FIELD_OF_VIEW_DEG, UNKNOWN_FIELD_OF_VIEW_SIGMA_DEG = 66.0, 16.0
"""The same if no distance is marked, so that every distance is proportional to the focal length, and this
prior decides. It is the centre and the spread of the cameras of published drives: 49 (Cityscapes), 58
(Udacity), 65 (nuScenes, comma2k19), 66 (RobotCar), 73 (ApolloScape), 81 (KITTI) and 84 degrees (TuSimple).
The median stays between 65 and 66 whichever is left out. Wide dash cameras are within two sigmas."""
USUAL_TANGENT, USUAL_TANGENT_SIGMA = 0.05, 0.12
"""Tangent of the pitch of a camera that was mounted to look ahead: 3 degrees down, plus or minus 7."""
YAW_SIGMA_RAD = math.radians(5.0)
"""1-sigma of the yaw of a camera that was pointed ahead by eye."""
ROLL_SIGMA_RAD = math.radians(1.5)
"""1-sigma of the roll of a camera that was levelled by eye."""
TAPE_ERROR = 0.01
"""Common relative 1-sigma of taped distances: the tape sags, or is not straight."""
MARK_ERROR_PART = 0.25
"""Independent error of each mark, as a fraction of the tape's error: it is laid, and clicked, by its edge."""
CAR_CAMERA_HEIGHT_M, CAR_CAMERA_HEIGHT_SIGMA_M = 1.3, 0.12
"""Height above the road of a camera at the mirror of an ordinary car."""
UNKNOWN_HEIGHT_M, UNKNOWN_HEIGHT_SIGMA_M = 1.5, 0.5
"""Height of a camera behind any windscreen, from a sports car's to a lorry's, if lengths on the road
determine the scale."""
SIDE_SIGMA_M = 0.02
"""Independent 1-sigma of a taped side of a rectangle, in addition to the tape's error: paint is as wide as a
hand, and may be clicked and taped by different edges."""
HORIZON_ROW_SIGMA_PX = 2.0
"""1-sigma of a horizon that is dragged by eye, or found by extending two straight lane lines by eye."""
