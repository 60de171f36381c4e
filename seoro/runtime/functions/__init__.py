"""Python functions that implement actions, modifiers and methods: decorators, signature checks and calls.

It imports values and contracts.
"""
