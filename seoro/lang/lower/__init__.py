"""Lowering: creates the plan of one scenario, with overrides and reached behaviors."""
