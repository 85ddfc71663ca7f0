"""`fcw calibrate`: from points of the road at known distances to a calibration."""
