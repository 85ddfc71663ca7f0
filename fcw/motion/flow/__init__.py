"""What is measured from picture to picture: tracked points, own car, cuts, sight, and the pictures' true
times."""
