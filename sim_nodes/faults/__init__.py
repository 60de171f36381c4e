"""Faults of sensors and actuators: injecting them, and checking that they take effect."""
