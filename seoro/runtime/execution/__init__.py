"""Shared state of a run: execution contexts, services, resources, contacts and actor assignment."""
