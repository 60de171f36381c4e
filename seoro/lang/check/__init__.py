"""Checking, in ordered passes: `declare` (names), `resolve` (types and bases), `expressions`, `behaviors`.

Each pass reports all it finds and leaves `Unknown` types behind, about which later passes say nothing.
"""
