"""Rewriting of scenarios that were written for scenario_execution, where the standard wants another form.

A rewriting follows an error of the check, changes a few sections of the text, and keeps everything else: comments,
labels, and layout.
"""
