"""Keys of a lab: who may take part over the network, and as what.

A lab has a certificate authority, a key that signs certificates (`authority.py`). Whoever takes part has an
*identity*: a key of its own and a certificate that says its name and its role (`certificates.py`). Both lie in a
folder (`folder.py`). `roles.py` has what each role may do, in one table; routers hold sessions to it by Zenoh's
access control (`access.py`), executors hold each command to it, since commands are sealed by their senders
(`sealing.py`). Who is revoked stands in a list that the authority signs (`revocation.py`), which clients
read in the folder of their keys (`revoked_file.py`). What was asked of an
executor is written into a log that cannot be changed unnoticed (`audit.py`).

Nothing here knows Zenoh or asyncio. What loads `cryptography` is imported on demand: without keys, none of it is
needed.
"""
