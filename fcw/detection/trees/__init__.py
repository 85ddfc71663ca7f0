"""Boosted trees: learnt, and run over windows in two stages."""
