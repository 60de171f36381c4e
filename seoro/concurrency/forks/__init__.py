"""Fork servers: they load modules once, and fork a process on each request, which starts within milliseconds.

Forked processes share the memory of the loaded modules. A fork server has a single thread, so that they are
consistent.
"""
