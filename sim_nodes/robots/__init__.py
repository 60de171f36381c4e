"""Robots: declarations, parts, motion and sensors."""
