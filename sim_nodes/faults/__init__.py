"""Faults of sensors and motors: where they may be injected, and whether they take effect."""
