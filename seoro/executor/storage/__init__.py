"""Storage of an executor: runs in SQLite, their folders, the blobs of bundles, and quotas.

`Store` keeps runs and `RunFolder` names their files. `Blobs` keeps files of bundles within a `BlobQuota` for each
client, `Intake` unpacks bundles, and `make_room` keeps part of the disk free.

May import `seoro.executor.limits`.
"""
