"""The drive log as MCAP: written, read and recovered."""
