"""Engines of other machines. Their rows are checked, and stored by the coordinator."""
