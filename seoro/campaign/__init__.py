"""Campaigns: many runs of one scenario, planned, resumable, and evaluated with statistics."""
