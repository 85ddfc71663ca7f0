"""The drive log: its records, its formats, and what is found in it."""
