"""The ground and what stands beside it."""
