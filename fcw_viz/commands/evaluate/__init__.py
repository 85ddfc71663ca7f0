"""`fcw evaluate`: what the program is worth, measured against truth."""
