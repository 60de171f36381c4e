"""Security of a lab: who takes part over the network, in which role, and with which proof.

- `keys`: identities, roles, certificates, the authority of the lab and its list of revoked keys.
- `signing`: signatures of commands, answers and statements, and the signed audit log.
- `network`: the same at sessions: listeners, authorizers, the audit trail.

`keys` and `signing` are data and functions: they import neither Zenoh nor asyncio. Modules that load
`cryptography` are imported on demand, since most processes have no keys.
"""
