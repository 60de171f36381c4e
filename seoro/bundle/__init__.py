"""Bundles: a scenario with all its files and options, for a run on an executor.

A bundle consists of a manifest (`seoro.bridges.executor.messages`) and blobs, which are files identified by the
SHA-256 of their content. No archive is written or read. `pack.py` makes a bundle of a loaded scenario and its
options. `unpack.py` writes an untrusted bundle to a folder, and `paths.py` checks its paths.
"""
