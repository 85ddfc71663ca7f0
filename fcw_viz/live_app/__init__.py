"""The live page: a drive that is running now, with a warning that is seen and heard."""
