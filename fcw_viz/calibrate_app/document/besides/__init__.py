"""What is known besides marks and rows, and the fit that takes it."""
