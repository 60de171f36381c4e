"""Bundles: a scenario with all that it consists of, as it travels to where it is run.

A bundle is a manifest (`seoro.bridges.executor.messages`) and blobs, which are single files known by the
SHA-256 of their content: no archive is written or read. `packing.py` makes one of a scenario that was loaded,
and of how it is to be run; `unpacking.py` lays one out in a folder, and trusts nothing in it; `places.py` says
which paths may stand in one.
"""
