"""Folder of a campaign: each file has one writer, lines are only appended, so that nothing is lost on a kill."""
