"""Binding of actions, modifiers and external methods to Python when a scenario is loaded.

The modules of libraries are imported before a scenario is checked, since parameters of their functions determine
which arguments are valid. Afterwards, functions are matched with declarations. Mismatches are diagnostics of the
scenario.
"""
