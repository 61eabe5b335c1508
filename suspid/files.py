"""Files: read whole, replaced only when complete, and named safely in messages."""

from __future__ import annotations

import difflib
import itertools
import json
import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from suspid.errors import InputError, SuspidError

# Files of a folder that are looked at for a name near one that is not there.
MOST_BESIDE = 1000


def printable(text: str) -> str:
    r"""Return the text on one line with control characters escaped.

    Examples
    --------
    >>> print(printable("seat\x1b[2J"))
    seat\x1b[2J
    """
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)


@contextmanager
def naming(source: str | os.PathLike[str]) -> Iterator[None]:
    """Put the name of a file or record in front of errors about it that have no name; what they carry stays."""
    try:
        yield
    except SuspidError as error:
        raise error.about(printable(os.fspath(source))) from error.__cause__


def check_exists(path: Path, *, error: type[InputError] = InputError) -> None:
    """Raise ``error`` with the nearest name if there is nothing at a path."""
    # Of a name that no file can have `Path.exists` says that it is too long.
    if os.path.lexists(path) and not os.path.exists(path):
        raise error("there is no such file: it is a link to nothing, or to itself")
    if not os.path.exists(path):
        raise error(f"there is no such file{_beside(path)}")


def real_path(path: Path) -> Path:
    """Return the path behind links; `Path.resolve` raises where they lead in a circle."""
    return Path(os.path.realpath(path))


def read_bytes(path: Path, *, error: type[InputError] = InputError) -> bytes:
    """Return the content of a file; raise ``error`` with the reason if it cannot be read."""
    with naming(path):
        try:
            if path.is_dir():
                raise error("is a folder; give a file in it")
            check_exists(path, error=error)
            if not path.is_file():
                raise error("is not a regular file")
            content = path.read_bytes()
        except (OSError, ValueError) as refusal:
            if isinstance(refusal, InputError):
                raise
            raise error(f"cannot be read: {_reason(refusal)}") from None
        if not content:
            raise error("is empty: export it again, or name another file")
    return content


def read_text(path: Path) -> str:
    """Return the UTF-8 text of a file without byte order mark and with line feeds as line ends."""
    content = read_bytes(path)
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as refusal:
        line = content.count(b"\n", 0, refusal.start) + 1
        damage = InputError(f"is not UTF-8 text: byte 0x{content[refusal.start]:02x} on line {line}; save it as UTF-8")
        raise damage.about(printable(str(path))) from None
    if "\0" in text:
        raise InputError("is not text: it contains zero bytes").about(printable(str(path)))
    return text.replace("\r\n", "\n").replace("\r", "\n")


def parsed_json(text: str) -> dict[str, object]:
    """Return the object that a JSON text holds; raise an `InputError` if it is none.

    Examples
    --------
    >>> parsed_json('{"modes": []}')
    {'modes': []}
    """
    try:
        content = json.loads(text)
    except (ValueError, RecursionError) as error:
        why = ""
        if isinstance(error, json.JSONDecodeError) and text.lstrip().startswith("{"):
            why = f": it is invalid at line {error.lineno}, column {error.colno} ({error.msg})"
        raise InputError(f"is not JSON{why}; give JSON that suspid wrote") from None
    if not isinstance(content, dict):
        raise InputError(f"must contain a JSON object, not {type(content).__name__}; give JSON that suspid wrote")
    return content


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a new file to write to; it replaces ``path`` only if no error occurs.

    Enter the context before the work starts, so that a path that cannot be written to is refused at once. A device
    or a pipe is written to directly. Where there is nothing to write after all, remove the new file: the old one stays.

    Raises
    ------
    InputError
        If the path is a folder or cannot be written to.
    """
    target, name = Path(path), printable(str(path))
    try:
        # What is behind a link to a pipe, as /dev/stdout is, has no path.
        target = target if _is_stream(target) else real_path(target)
        with naming(path):
            if target.is_dir():
                raise InputError("is a folder; give the name of a file to write")
            if not target.parent.is_dir():
                raise InputError(
                    f"cannot be written: there is no folder {printable(str(target.parent))}; check the path"
                )
            if target.exists() and not os.access(target, os.W_OK):
                raise InputError("cannot be written: the file is write-protected")
        beside = _is_stream(target)
        draft = target if beside else target.with_name(f".{secrets.token_hex(4)}{target.suffix}")
        if not beside:
            draft.open("xb").close()
    except (OSError, ValueError) as refusal:
        if isinstance(refusal, InputError):
            raise
        raise InputError(f"cannot be written: {_reason(refusal)}").about(name) from None
    try:
        yield draft
        if draft != target and draft.exists():
            draft.replace(target)
    except OSError as refusal:
        raise InputError(f"cannot be written: {_reason(refusal)}").about(name) from None
    finally:
        if draft != target:
            draft.unlink(missing_ok=True)


def _is_stream(path: Path) -> bool:
    """Tell whether there is a device or a pipe at a path."""
    return path.exists() and not path.is_file() and not path.is_dir()


def _reason(refusal: Exception) -> str:
    return printable(refusal.strerror or str(refusal) if isinstance(refusal, OSError) else str(refusal))


def _beside(path: Path) -> str:
    """Return where a file that is not there may be meant: the nearest names in its folder, or that there is none."""
    folder = path.parent
    if not folder.is_dir():
        return f", nor a folder {printable(str(folder))}; check the path"
    try:
        names = [one.name for one in itertools.islice(folder.iterdir(), MOST_BESIDE)]
    except OSError:
        return "; check the path"
    near = difflib.get_close_matches(path.name, names, n=2)
    known = " or ".join(repr(printable(name)) for name in near)
    return f". Did you mean {known}?" if near else f" in {printable(str(real_path(folder)))}; check the path"
