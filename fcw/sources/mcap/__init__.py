"""Drives out of MCAP files, by this program or by others."""
