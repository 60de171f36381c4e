"""Stopping rules of campaigns."""
