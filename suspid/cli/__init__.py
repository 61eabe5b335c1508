"""The command ``suspid``.

One module per group of commands. A command parses its options, calls one public function of the library and
prints the result; nothing is decided here.
"""

from suspid.cli.main import main

__all__ = ["main"]
