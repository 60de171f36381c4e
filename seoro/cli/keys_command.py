"""`seoro keys`: make the keys of a lab, and take them back."""

from __future__ import annotations

import argparse
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from seoro.cli.arguments import number
from seoro.cli.exits import Exit
from seoro.cli.remote_arguments import add_executor_argument
from seoro.keys.folder import VARIABLE, KeyFolder, chosen_folder, default_folder
from seoro.keys.roles import LISTENING, Role

if TYPE_CHECKING:
    from seoro.keys.authority import Authority
    from seoro.keys.certificates import Identity

EXAMPLES = """examples:
  seoro keys init lab
  seoro keys add lab-a --role executor --host lab-a.example.org
  seoro keys add anna --role operator -o anna.keys
  seoro keys list
  seoro keys revoke anna
  seoro keys tell --executor tls/lab-a.example.org:7470 --keys ada.keys --revoked revoked.crl
  seoro keys audit audit.jsonl

Identities are folders, which are carried to whoever they are for; `--keys` or SEORO_KEYS names them there."""
_YEAR = 365.0
_SOON = 30.0  # [days] before its end in which a certificate is said to expire


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what can be done."""
    what = parser.add_subparsers(title="what to do", metavar="WHAT", required=True, dest="what")
    init = what.add_parser("init", help="make the key of a lab", allow_abbrev=False)
    init.add_argument("lab", metavar="LAB", help="name of the lab")
    add = what.add_parser("add", help="make an identity: a key, and a certificate with a name and a role")
    add.add_argument("name", metavar="NAME", help="who or what it is for")
    add.add_argument("--role", required=True, choices=[role.value for role in Role], help="what it takes part as")
    _add_issuing(add)
    renew = what.add_parser("renew", help="a new key and a new certificate for an identity")
    renew.add_argument("name", metavar="NAME", help="the identity")
    _add_issuing(renew)
    revoke = what.add_parser("revoke", help="take an identity back")
    revoke.add_argument("name", metavar="NAME", help="the identity")
    listing = what.add_parser("list", help="all identities that were made")
    audit = what.add_parser("audit", help="check that nothing was changed in the log of an executor or a node")
    audit.add_argument(
        "file", type=Path, metavar="FILE", help="the log: audit.jsonl in the folder of the executor"
    )
    tell = what.add_parser("tell", help="tell executors who is revoked; for admins")
    tell.add_argument(
        "--revoked", type=Path, metavar="FILE", help="the list (default: revoked.crl in the folder of keys)"
    )
    add_executor_argument(tell)
    for command in (init, add, renew, revoke, listing, audit):
        command.add_argument(
            "--keys",
            dest="authority",
            type=Path,
            metavar="DIR",
            help=f"folder of the key of the lab (default: that of {VARIABLE}, else {_shown(default_folder())})",
        )


def _add_issuing(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "-o", "--output", type=Path, metavar="DIR", help="put it into this folder (default: NAME.keys)"
    )
    parser.add_argument(
        "--host",
        action="append",
        default=[],
        metavar="HOST",
        help=f"name or address at which others reach it; for {', '.join(sorted(LISTENING))} (repeatable)",
    )
    parser.add_argument(
        "--days", type=_days, default=_YEAR, metavar="DAYS", help=f"valid for so long (default: {_YEAR:g})"
    )


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    from seoro.keys.authority import init_authority, open_authority  # noqa: PLC0415 - on demand

    if options.what == "tell":
        return _tell(options)
    folder = options.authority or chosen_folder() or default_folder()
    if options.what == "audit":
        return _audit(options.file, folder)
    if options.what == "init":
        lab = init_authority(folder, options.lab).lab
        print(f"the key of the lab '{lab}' is in {folder}: whoever has it can be anybody. Keep a copy of it.")
        return Exit.PASSED
    authority = open_authority(folder)
    match options.what:
        case "add" | "renew":
            _issue(authority, options)
        case "revoke":
            authority.revoke(options.name)
            print(f"'{options.name}' is revoked")
            print("whoever listens has to be told, be it a router, an executor, a simulator or a bridge:")
            print(f"copy {folder / 'revoked.crl'} to their keys,")
            print("or, for executors, `seoro keys tell`")
            print("copy it to the keys of clients, too, if they must not trust an executor or a node any more")
        case "list":
            _list(authority)
    return Exit.PASSED


def _issue(authority: Authority, options: argparse.Namespace) -> None:
    to = options.output or Path(f"{options.name}.keys")
    if options.what == "add":
        identity = authority.add(options.name, Role(options.role), to, options.days, options.host)
    else:
        identity = authority.renew(options.name, to, options.days, options.host)
    print(f"{identity}, until {identity.ends:%Y-%m-%d}: {to}")
    if to != options.authority:
        print(f"carry that folder to whoever it is for, and delete it here; they use it by `--keys` or {VARIABLE}")


def _audit(file: Path, folder: Path) -> int:
    from seoro.keys.audit import check_log  # noqa: PLC0415 - on demand
    from seoro.keys.files import read_certificate  # noqa: PLC0415 - the same

    checked = check_log(file, read_certificate(KeyFolder(folder).authority))
    print(f"{file} holds: {checked.count} lines of {', '.join(checked.writers) or 'nobody'}")
    print(f"hash of the last: {checked.last}")
    return Exit.PASSED


def _tell(options: argparse.Namespace) -> int:
    import anyio  # noqa: PLC0415 - for this only

    from seoro.client import Client  # noqa: PLC0415 - Zenoh, for this only
    from seoro.keys.files import read_file  # noqa: PLC0415 - on demand

    revoked = options.revoked or KeyFolder(chosen_folder() or default_folder()).revoked

    async def tell() -> list[str]:
        async with Client(options.executor) as client:
            return await client.revoke(read_file(revoked))

    print(f"told {', '.join(anyio.run(tell))} who is revoked")
    return Exit.PASSED


def _list(authority: Authority) -> None:
    rows = [("NAME", "ROLE", "SEAT", "UNTIL", "STATE", "HOSTS")]
    for issued in authority.issued():
        who = issued.identity
        hosts = ", ".join(who.hosts)
        state = "revoked" if issued.is_revoked else _state(who)
        rows.append((who.name, who.role.value, str(who.seat), f"{who.ends:%Y-%m-%d}", state, hosts))
    print(f"lab '{authority.lab}'")
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        print("  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip())


def _state(identity: Identity) -> str:
    left = (identity.ends - datetime.now(UTC)).total_seconds() / 86_400.0
    if left < 0.0:
        return "expired"
    return "expires soon" if left < _SOON else "valid"


def _shown(path: Path) -> str:
    home = Path.home()
    return f"~/{path.relative_to(home)}" if path.is_relative_to(home) else str(path)


def _days(text: str) -> float:
    return number(text, "a positive number of days, 3650 at most", lambda value: 0.0 < value <= 3650.0)
