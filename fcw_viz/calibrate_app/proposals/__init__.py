"""What the program finds in the pictures by itself, for a person to confirm."""
