"""Instances of scenarios, actions and modifiers, before and while they run: data, without evaluation.

It imports values, and the kernel for scopes and channels of running instances.
"""
