"""What distances and closing speeds are worth, on real and simulated vehicles."""
