"""`seoro keys`: create, renew and revoke the keys of a lab."""

from __future__ import annotations

import argparse
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from seoro.cli.arguments import add_command, add_keys_argument, add_option, number
from seoro.cli.remote_arguments import add_executor_argument
from seoro.cli.results import print_json
from seoro.cli.tables import table
from seoro.security.keys import VARIABLE
from seoro.security.keys.folder import KeyFolder, chosen_folder, default_folder
from seoro.security.keys.roles import LISTENING, Role

if TYPE_CHECKING:
    from seoro.security.keys.authority import Authority
    from seoro.security.keys.certificates import Identity

EXAMPLES = """examples:
  seoro keys init lab
  seoro keys add lab-a --role executor --host lab-a.example.org
  seoro keys add anna --role operator -o anna.keys
  seoro keys list
  seoro keys revoke anna
  seoro keys publish --executor tls/lab-a.example.org:7470 --keys ada.keys --revoked revoked.crl
  seoro keys audit audit.jsonl

An identity is a folder of keys. Copy it to its user or machine, and name it there with `--keys` or SEORO_KEYS."""
_YEAR = 365.0
_days = number("a positive number of days, 3650 at most", float, lambda days: 0.0 < days <= 3650.0)
_SOON = 30.0  # [days] before the end of a certificate that "expires soon"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the subcommands."""
    what = parser.add_subparsers(title="subcommands", metavar="SUBCOMMAND", required=True, dest="what")
    init = add_command(what, "init", "create the key of a lab")
    init.add_argument("lab", metavar="LAB", help="name of the lab")
    add = add_command(what, "add", "create an identity: a key, and a certificate with a name and a role")
    add.add_argument("name", metavar="NAME", help="name of the user or machine")
    add_option(add, "--role", "role of the identity", required=True, choices=[role.value for role in Role])
    _add_issuing(add)
    renew = add_command(what, "renew", "create a new key and certificate for an identity")
    renew.add_argument("name", metavar="NAME", help="name of the identity")
    _add_issuing(renew)
    revoke = add_command(what, "revoke", "revoke an identity")
    revoke.add_argument("name", metavar="NAME", help="name of the identity")
    listing = add_command(what, "list", "list all identities")
    add_option(listing, "--json", "print one JSON object")
    audit = add_command(what, "audit", "verify that the audit log of an executor or a node was not altered")
    audit.add_argument("file", type=Path, metavar="FILE", help="audit.jsonl in the folder of the executor")
    publish = add_command(what, "publish", "send the revocation list to executors (admins only)")
    add_option(publish, "--revoked FILE", "revocation list (default: revoked.crl in the folder of keys)")
    add_executor_argument(publish)
    add_keys_argument(audit)
    for command in (init, add, renew, revoke, listing):
        add_option(
            command,
            "--authority DIR",
            f"folder with the key of the lab (default: {VARIABLE}, else {_shown(default_folder())})",
        )


def _add_issuing(parser: argparse.ArgumentParser) -> None:
    add_option(parser, "-o --output DIR", "output folder (default: NAME.keys)")
    add_option(
        parser,
        "--host HOST",
        f"host name or address of the {', '.join(sorted(LISTENING))}",
        repeatable=True,
    )
    add_option(parser, "--days DAYS", f"validity in days (default: {_YEAR:g})", type=_days, default=_YEAR)


def run(options: argparse.Namespace) -> None:
    """Run the command."""
    from seoro.security.keys.authority import init_authority, open_authority  # noqa: PLC0415 - on demand

    folder = getattr(options, "authority", None) or chosen_folder() or default_folder()
    match options.what:
        case "publish":
            _publish(options.executor, options.revoked or KeyFolder(folder).revoked)
        case "audit":
            _audit(options.file, folder)
        case "init":
            lab = init_authority(folder, options.lab).lab
            advice = "keep it secret (it can issue any identity) and backed up"
            print(f"created the key of lab '{lab}' in {folder}; {advice}")
        case "add" | "renew":
            _issue(open_authority(folder), options)
        case "revoke":
            open_authority(folder).revoke(options.name)
            print(f"'{options.name}' is revoked")
            print(f"copy {folder / 'revoked.crl'} to the keys of all routers, executors, simulators and bridges")
            print("(for executors, `seoro keys publish` does so)")
            print("to revoke an executor or a node, copy it to the keys of clients, too")
        case "list":
            _list(open_authority(folder), as_json=options.json)


def _issue(authority: Authority, options: argparse.Namespace) -> None:
    to = options.output or Path(f"{options.name}.keys")
    if options.what == "add":
        identity = authority.add(options.name, Role(options.role), to, options.days, options.host)
    else:
        identity = authority.renew(options.name, to, options.days, options.host)
    print(f"{identity}, until {identity.ends:%Y-%m-%d}: {to}")
    if to != options.authority:
        print(f"move this folder to its user or machine, and name it there with `--keys` or {VARIABLE}")


def _audit(file: Path, folder: Path) -> None:
    from seoro.security.keys.files import read_certificate  # noqa: PLC0415 - the same
    from seoro.security.signing.audit_log import check_log  # noqa: PLC0415 - on demand

    checked = check_log(file, read_certificate(KeyFolder(folder).authority))
    print(f"{file} is intact: {checked.count} lines, signed by {', '.join(checked.writers) or 'nobody'}")
    print(f"hash of the last line: {checked.last}")


def _publish(executor: str | None, revoked: Path) -> None:
    import anyio  # noqa: PLC0415 - for this subcommand only

    from seoro.client import Client  # noqa: PLC0415 - Zenoh, for this subcommand only
    from seoro.security.keys.files import read_file  # noqa: PLC0415 - on demand

    async def publish() -> list[str]:
        async with Client(executor) as client:
            return await client.revoke(read_file(revoked))

    print(f"sent the revocation list to {', '.join(anyio.run(publish))}")


def _list(authority: Authority, *, as_json: bool) -> None:
    if as_json:
        print_json(
            {
                "lab": authority.lab,
                "identities": [
                    {
                        "name": identity.name,
                        "role": identity.role.value,
                        "slot": str(identity.slot),
                        "ends": identity.ends.isoformat(),
                        "state": "revoked" if issued.is_revoked else _state(identity),
                        "hosts": list(identity.hosts),
                    }
                    for issued in authority.issued()
                    for identity in [issued.identity]
                ],
            }
        )
        return
    rows = [("NAME", "ROLE", "SLOT", "UNTIL", "STATE", "HOSTS")]
    for issued in authority.issued():
        identity = issued.identity
        hosts = ", ".join(identity.hosts)
        state = "revoked" if issued.is_revoked else _state(identity)
        rows.append(
            (identity.name, identity.role.value, str(identity.slot), f"{identity.ends:%Y-%m-%d}", state, hosts)
        )
    print(f"lab '{authority.lab}'\n{table(rows)}")


def _state(identity: Identity) -> str:
    left = (identity.ends - datetime.now(UTC)).total_seconds() / 86_400.0
    if left < 0.0:
        return "expired"
    return "expires soon" if left < _SOON else "valid"


def _shown(path: Path) -> str:
    home = Path.home()
    return f"~/{path.relative_to(home)}" if path.is_relative_to(home) else str(path)
