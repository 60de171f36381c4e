"""Actions that were written for scenario_execution, as classes with `setup`, `execute`, `update` and `shutdown`.

seoro runs them unchanged, and neither imports nor needs the packages that they inherit from.
"""
