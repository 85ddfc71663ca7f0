"""What is measured from picture to picture: tracked points, own car, cuts, sight and true times."""
