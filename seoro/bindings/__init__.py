"""Binds declarations to Python when a scenario is loaded: actions, modifiers and external methods.

The modules of libraries are imported before a scenario is checked, since what their functions take says which
arguments are right; afterwards, functions are matched with declarations. What does not match is a message, like
all else that is wrong with a scenario.
"""
