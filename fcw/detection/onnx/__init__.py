"""Detectors plugged in as ONNX files."""
