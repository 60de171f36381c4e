"""Checking, in ordered passes: `declare` (names), `resolve` (types, bases and extensions), `members`,
`expressions` with `methods`, `behaviors`.

Each pass reports all it finds and leaves `Unknown` types behind, about which later passes say nothing.
"""
