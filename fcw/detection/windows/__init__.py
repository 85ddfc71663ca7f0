"""The distance prior: which windows can hold a vehicle, by the calibration and the sizes of vehicles."""
