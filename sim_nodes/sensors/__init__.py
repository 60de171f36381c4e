"""Sensors of robots, with their noise and faults."""
