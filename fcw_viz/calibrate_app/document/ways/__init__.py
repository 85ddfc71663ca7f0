"""The ways to calibrate, and what each brings along."""
