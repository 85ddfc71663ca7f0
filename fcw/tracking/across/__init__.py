"""Where a vehicle is across the road, how it moves there, and what its bearing tells of that."""
