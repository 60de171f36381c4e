"""Engine of Dask.distributed: chunks are tasks, and each Dask worker has a pool of its own (`seoro[dask]`)."""
