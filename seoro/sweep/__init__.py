"""A scenario run once for each combination of the values that its parameters may have."""
