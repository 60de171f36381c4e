"""Keys of a lab: identities, their roles, and the authority that issues and revokes them.

A lab has a certificate authority (`authority`). Each participant has an *identity*: a private key and a
certificate with its name and role (`certificates`), both in one folder (`folder`). `roles` lists what each role
may do; `access_control` turns that into rules for routers. The authority signs a list of revoked keys
(`revocation`), which clients read from their folder of keys (`RevokedFile`).

May import `seoro.errors` and `seoro.files`.
"""

from __future__ import annotations

from typing import Final

VARIABLE: Final = "SEORO_KEYS"
"""Environment variable with the folder of keys."""
