"""Sandboxes of runs: namespaces and mounts by bubblewrap, and limits of the kernel.

`command` builds the command line of bubblewrap, `enter` joins a process to a sandbox, and `Broker` connects the
run to the endpoints that the policy allows. `kernel_limits` sets resource limits with and without a sandbox.

May import `seoro.executor.job` and `permissions`.
"""
