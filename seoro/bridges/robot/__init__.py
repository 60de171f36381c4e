"""Robots behind a bridge as a backend: the runtime's contracts, spoken over the wire, in real time."""
