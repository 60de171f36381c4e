"""Files: inputs that users name, caches, durable writes, YAML with line numbers, path mapping of bundles.

May import `seoro.errors` only.
"""
