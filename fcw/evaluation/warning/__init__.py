"""Whether warnings come in time, and never for nothing."""
