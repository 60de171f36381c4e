"""Coverage of `cover` and `record` items (7.5): sampling, buckets and grades."""
