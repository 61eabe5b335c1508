"""Files that commands read and write; ``-`` is the standard input or output."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import click

from suspid.cli.output import STANDARD_INPUT, STANDARD_OUTPUT, STANDS_FOR, WRITTEN_OUT, Failed, said_when_full

# First bytes of the kinds of binary files that a pipe may carry; everything else is text.
KINDS = {
    b"\x89HDF": ".h5",
    b"MATLAB": ".mat",
    b"RIFF": ".wav",
    b"PAR1": ".parquet",
    b"\x93NUMPY": ".npy",
    b"PK": ".npz",
    b"TDSm": ".tdms",
    b"MDF": ".mf4",
}


def _kept(ctx: click.Context, stream: str, suffix: str) -> Path:
    """Return the path of a file that holds a stream while the command runs; messages show the stream's name."""
    # The context of a command that is refused while its options are read is never closed; the outermost one is.
    folder = ctx.find_root().with_resource(TemporaryDirectory(prefix="suspid-"))
    path = Path(folder, f"{stream}{suffix}")
    ctx.meta.setdefault(STANDS_FOR, {})[path] = stream
    return path


def kind_of(content: bytes, text: str) -> str:
    r"""Return the suffix of what a pipe carries; ``text`` is that of text that is neither JSON nor TOML.

    Examples
    --------
    >>> kind_of(b'{"modes": []}', ".csv"), kind_of(b"[masses]\nwheel = 40", ".csv"), kind_of(b"t,y\n0,1", ".csv")
    ('.json', '.toml', '.csv')
    """
    known = next((kind for start, kind in KINDS.items() if content.startswith(start)), None)
    if known is not None:
        return known
    if content.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"{"):
        return ".json"
    try:
        return ".toml" if tomllib.loads(content.decode("utf-8-sig").replace("\r\n", "\n")) else text
    except (ValueError, RecursionError):
        return text


class Input(click.Path):
    """A file that is read; ``-`` is the standard input, kept in a file while the command runs."""

    def __init__(self, text: str) -> None:
        """Take the suffix of text that does not show what it is."""
        super().__init__(path_type=Path)
        self.text = text

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path."""
        if str(value) != "-" or ctx is None:
            return super().convert(value, param, ctx)
        if STANDARD_INPUT in ctx.meta.get(STANDS_FOR, {}).values():
            self.fail("- is the standard input, which is read once: name a file.", param, ctx)
        content = sys.stdin.buffer.read()
        if not content:
            self.fail("- is the standard input, and it is empty: pipe a file into it, or name a file.", param, ctx)
        try:
            path = _kept(ctx, STANDARD_INPUT, kind_of(content, self.text))
            path.write_bytes(content)
        except OSError as refusal:
            why = refusal.strerror or refusal
            raise Failed(
                f"the standard input cannot be kept in a temporary file: {why}; make room, or name a file"
            ) from None
        return path


def _put_out(path: Path) -> None:
    """Write a file to the standard output, if there is one."""
    if path.exists():
        with said_when_full():
            click.echo(path.read_bytes(), nl=False)


class Output(click.Path):
    """A file that is written; ``-`` is the standard output, the text of the result then goes to the standard error."""

    def __init__(self, suffix: str) -> None:
        """Take the suffix of what is written."""
        super().__init__(path_type=Path)
        self.suffix = suffix

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path."""
        if str(value) != "-" or ctx is None:
            return super().convert(value, param, ctx)
        if WRITTEN_OUT in ctx.meta:
            self.fail("- is the standard output, which is written once: name a file.", param, ctx)
        path = _kept(ctx, STANDARD_OUTPUT, self.suffix)
        ctx.meta[WRITTEN_OUT] = path
        ctx.find_root().call_on_close(lambda: _put_out(path))
        return path


class Named(Output):
    """A file that is written in one format, and named so, as it is read again by its name; or a device."""

    def __init__(self, suffix: str, what: str) -> None:
        """Take the suffix, and what is written as which format."""
        super().__init__(suffix)
        self.what = what

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path."""
        path: Any = super().convert(value, param, ctx)
        # Of a folder it is said elsewhere that it is one.
        other = path.exists() and not path.is_file()
        if path.suffix.lower() != self.suffix and not other:
            self.fail(f"{str(path)!r}: {self.what}; name it {path.stem}{self.suffix}.", param, ctx)
        return path


FILE = click.Path(path_type=Path)
RECORD, CAR, FOUND = Input(".csv"), Input(".toml"), Input(".json")
RECORD_FILE = Output(".csv")
CAR_FILE, JSON_FILE = Named(".toml", "a car is written as TOML"), Named(".json", "the result is written as JSON")
