"""Traces: records, their writers and readers, and JUnit reports."""
