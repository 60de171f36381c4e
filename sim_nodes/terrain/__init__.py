"""Terrain of worlds: ramps, steps and height fields on the floor."""
