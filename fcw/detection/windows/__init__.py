"""The distance prior: which windows can contain a vehicle, given calibration and vehicle sizes."""
