"""Lenses that bend straight lines: their models, their files, and how they are measured."""
