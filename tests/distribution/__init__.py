"""Distributions as users install them: the wheel, its types, and files for CI services."""
