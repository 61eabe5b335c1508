"""Encodings: the bytes of a text file as UTF-8 with newlines."""

from __future__ import annotations

import codecs
import re

from suspid.errors import RecordError
from suspid.words import LeftOut, Remark

HEAD = 1 << 16
PIECE = 1 << 22
CONTROL = re.compile(rb"[\x00-\x08\x0e-\x1f\x7f]")
NO_CONTROL = bytes(code for code in range(256) if not CONTROL.match(bytes([code])))


def decoded(content: bytes) -> tuple[bytes, dict[str, Remark]]:
    r"""Return a text as UTF-8 with newlines, and in which other encoding it was read.

    Raises
    ------
    RecordError
        If it is no text, or in an encoding that is not known.

    Examples
    --------
    >>> str(decoded("seat [°]\r\n".encode("cp1252"))[1]["encoding"])
    'is not UTF-8 (byte 0xb0 on line 1); read as Windows-1252'
    """
    told: dict[str, Remark] = {}
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        try:
            content = content.decode("utf-16").encode()
        except UnicodeError as refusal:
            raise RecordError(f"is not UTF-16 text, as its first bytes say: {refusal.__class__.__name__}") from None
        told["encoding"] = Remark(LeftOut.UTF_16)
    content = content.removeprefix(codecs.BOM_UTF8)
    if not content.isascii():
        try:
            content.decode()
        except UnicodeDecodeError as refusal:
            byte, line = content[refusal.start], content.count(b"\n", 0, refusal.start) + 1
            try:
                content = content.decode("cp1252").encode()
            except UnicodeDecodeError:
                raise RecordError(
                    f"is neither UTF-8 nor Windows-1252 text: byte 0x{byte:02x} on line {line}; save it as UTF-8"
                ) from None
            told["encoding"] = Remark(LeftOut.WINDOWS_1252, {"byte": byte, "line": line})
    content = content.rstrip(b"\x1a")
    # Deleting what is allowed is ten times faster than looking for what is not.
    starts = range(0, len(content), PIECE)
    odd = next((k for k in starts if content[k : k + PIECE].translate(None, NO_CONTROL)), None)
    control = None if odd is None else CONTROL.search(content, odd)
    if control:
        what = "zero bytes" if control[0] == b"\0" else f"the control byte 0x{control[0][0]:02x}"
        line = content.count(b"\n", 0, control.start()) + 1
        raise RecordError(f"is not text: it holds {what} (line {line}); if it is UTF-16, save it as UTF-8")
    if b"\r" in content:
        content = content.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    # The serial monitor of Arduino parts its stamps from the text so.
    if re.match(rb"\d\d:\d\d:\d\d\.\d+ -> ", content):
        start = content[:HEAD]
        content = content.replace(b" -> ", next((d for d in (b"\t", b";", b",") if d in start), b"\t"))
    return content if content.endswith(b"\n") else content + b"\n", told
