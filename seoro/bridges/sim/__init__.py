"""A simulator node as a backend: the runtime's contracts, spoken over the wire."""
