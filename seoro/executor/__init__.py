"""Executors: services that accept scenarios over the network, run them and keep their results.

- `service` starts an executor; `endpoint` receives its requests, `authorizer` admits them within `limits`, and
  `handlers` answers them.
- `permissions` rejects what scenarios must not do here; `job` describes one run to its process.
- `runs`: queued and active runs, their slots and limits.
- `process`: the processes in which runs execute.
- `sandbox`: what these processes see of the machine.
- `storage`: runs, bundles and disk quotas.

May import everything of seoro but `cli`, `doctor`, `lsp` and `client`.
"""
