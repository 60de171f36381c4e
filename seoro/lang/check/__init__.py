"""Checker: ordered passes over the trees, whose results live beside the trees.

The passes are `declare` (names), `resolve` (types, bases and extensions), `members`, `expressions` with `methods`,
and `behaviors`. Each pass reports all its errors and leaves `Unknown` types, which later passes accept silently.
"""
