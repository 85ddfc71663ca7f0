"""What the program is worth, measured against truth."""
