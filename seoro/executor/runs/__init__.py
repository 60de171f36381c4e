"""Runs that are not over: the queue, the run slots, the limits, and the clients that follow them.

`Queue` starts and finishes runs in the order of the `FairQueue`, within the `RunSlots`. `ActiveRun` is the state
of one run. `enforcement` ends runs that exceed limits, which `usage` and `memory` measure. `tail` sends growing
traces to clients, `Emissions` sends their events to runs. `DryRuns` carries out dry runs.

May import `seoro.executor.job`, `limits`, `process` and `storage`.
"""
