"""The live page: a running drive with visible and audible warnings."""
