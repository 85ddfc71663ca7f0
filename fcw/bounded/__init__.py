"""Reading what others wrote, within bounds: of size, depth, digits and pixels."""
