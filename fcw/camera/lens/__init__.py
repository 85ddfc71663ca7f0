"""Lenses with distortion: their models, their files, and how they are measured."""
