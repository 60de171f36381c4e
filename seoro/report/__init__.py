"""Reports of runs: one HTML file that shows the verdict, the timeline, the world, the source and the records.

The file contains the pages of `ui/`, built into `static/`, and the data of the run, which is compressed and has an
index. Looks at traces only; imports nothing of the runtime.
"""
