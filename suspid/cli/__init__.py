"""The command ``suspid``.

One module per group of commands. A command parses its options, calls one public function of the library and
prints the result; nothing is decided here. Below them: `commands` (the group), `options`, `option_names`,
`option_groups`, `quantities` and `parameters` (what can be given), `output` (what is printed).
"""

from suspid.cli.main import main

__all__ = ["main"]
