"""Processes of runs: a fork server makes them, each executes one run and reports over a pipe.

`Pool` and `Worker` are the executor's side; `fork_server` and `worker` run in the other processes. Both sides
exchange `frames`. `TracePipe` is the observer that reports a run, `Emitter` emits requested events in it.

May import `seoro.executor.job`, `permissions` and `sandbox`.
"""
