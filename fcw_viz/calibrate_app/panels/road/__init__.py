"""Step 2 of the job where somebody has something else on the road than points."""
