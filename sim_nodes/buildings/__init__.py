"""Doors and lifts: parts of a building that move."""
