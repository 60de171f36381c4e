"""`seoro completion`: print the script that completes commands in a shell."""

from __future__ import annotations

import argparse
from typing import Final

SHELLS: Final = ("bash", "zsh", "fish", "powershell")

EXAMPLES = """examples:
  seoro completion bash > ~/.local/share/bash-completion/completions/seoro
  seoro completion zsh > ~/.zfunc/_seoro      (in a folder of fpath, before compinit)
  seoro completion fish > ~/.config/fish/completions/seoro.fish
  seoro completion powershell >> $PROFILE
  eval "$(seoro completion bash)"             (for this shell alone)

The script asks seoro at each TAB, so it knows the options of the installed version, scenarios and parameters of
the named file, worlds, executors and runs of this machine."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("shell", metavar="SHELL", choices=SHELLS, help=", ".join(SHELLS))


def run(options: argparse.Namespace) -> None:
    """Run the command."""
    from argcomplete.shell_integration import shellcode  # noqa: PLC0415 - for this command only

    print(shellcode(["seoro"], shell=options.shell))
