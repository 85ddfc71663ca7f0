"""The detector in which a small convolutional net has the last word on what the distance prior proposes.

A cascade over aggregated channels (ACF) proposes windows where the calibration allows a vehicle. A few of
them, near ones and far ones, are judged by the net, which also says where in each the vehicle stands: regions
with convolutional features (Girshick et al., "Rich feature hierarchies", 2014). Here the windows, and so the
sizes that the net has to know, follow from the camera.
"""
