"""Boxes: their overlaps, which one stands for many, and where its vehicle truly stands."""
