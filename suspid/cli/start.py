"""The command ``suspid`` from its first line on: Ctrl-C during the imports ends in one line, too.

It is installed as the module ``suspid_command`` beside the package: to import anything of the package is to import all.
"""

from __future__ import annotations

import signal
import sys


def main() -> None:
    """Run the command."""
    try:
        from suspid.cli import main as run
    except KeyboardInterrupt:
        sys.stderr.write("suspid: stopped\n")
        sys.exit(128 + signal.SIGINT)
    run()
