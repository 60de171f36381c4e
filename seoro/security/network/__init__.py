"""Keys at sessions: who may connect, whose requests are accepted, and which answers are trusted.

- Servers: `Listener` opens sessions, `NodeIdentity` proves who the server is and verifies signatures,
  `NodeAuthorizer` admits requests, `AuditTrail` records them, `RevocationMonitor` follows the list of revoked
  keys.
- Clients: `endpoint_keys` chooses the keys for an endpoint, `PeerSigner` signs requests to one executor or node.

May import `seoro.security.keys` and `signing`, and of the bridges the session and the messages.
"""
