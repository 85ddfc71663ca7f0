"""Messages of the drive log that are the project's own."""
