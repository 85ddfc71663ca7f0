"""How we turn, and how the curvature of our path changes."""
