"""The simulated world: the road, the vehicles on it and how they move."""
