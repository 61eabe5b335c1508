"""Encodings: the bytes of a text file as UTF-8 lines.

Detection by statistics (charset-normalizer) reads the ° of a short Windows-1252 header as Big5, so that only the
encodings that loggers and spreadsheets write are tried, in a fixed order.
"""

from __future__ import annotations

import codecs
import re

import numpy as np

from suspid.errors import RecordError
from suspid.words import LeftOut, Remark

# The beginning of a file, in which its layout shows, and pieces that are read at a time [bytes]: larger ones do not
# stay in the cache of a processor, smaller ones are begun too often.
TOP = 1 << 16
PIECE = 1 << 20
# Bytes that are compared at a time: as many as stay in the cache of a processor.
COMPARED = 1 << 17

MINUS = "\N{MINUS SIGN}".encode()
MINUS_OF_NUMBER = re.compile(MINUS + rb"(?=[.,]?\d)")

# A matrix as it is printed in brackets, with a semicolon after each row; a name may stand before it.
OPENING = rb"^[^\S\n]*(?:[A-Za-z]\w*[^\S\n]*=[^\S\n]*)?\["
PRINTED_MATRIX = re.compile(OPENING + rb"[^\S\n]*\n?[^\[\];\n]*\d[^\[\];\n]*;[^\S\n]*$", re.M)
# The same on a line, as a program prints an array: nothing but brackets may follow it.
ROW = rb"[^\[\]\n;]*\d[^\[\]\n;]*"
ONE_LINE = re.compile(rb"(?:^|\n)[^\S\n]*(?:[A-Za-z]\w*[^\S\n]*=[^\S\n]*)?\[(%b(?:;%b)+;?)\][;\s]*\Z" % (ROW, ROW))
BRACKETS = re.compile(OPENING + rb"(?=[^\S\n]*(?:[-+.\d]|$))|(?:;|\];?)[^\S\n]*$", re.M)


def decoded(content: bytes) -> tuple[bytes, dict[str, Remark]]:
    r"""Return a text as UTF-8 with newlines, and its encoding where that is another one.

    Examples
    --------
    >>> str(decoded("seat [°]\r\n".encode("cp1252"))[1]["encoding"])
    'is not UTF-8 (byte 0xb0 on line 1); read as Windows-1252'
    """
    said: dict[str, Remark] = {}
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        try:
            content = content.decode("utf-16").encode()
        except UnicodeError:
            raise RecordError("is not UTF-16 text, although it begins with the mark of UTF-16") from None
        said["encoding"] = Remark(LeftOut.UTF_16)
    elif (wide := _wide(content[:TOP])) is not None:
        content = content.decode(wide, errors="replace").encode()
        said["encoding"] = Remark(LeftOut.UTF_16)
    content = content.removeprefix(codecs.BOM_UTF8)
    try:
        # The test for ASCII takes a tenth of the time.
        content.isascii() or content.decode()
    except UnicodeDecodeError as refusal:
        byte, line = content[refusal.start], content.count(b"\n", 0, refusal.start) + 1
        try:
            content = content.decode("cp1252").encode()
        except UnicodeDecodeError:
            # No encoding of text writes these in letters.
            if np.any(np.frombuffer(content[:TOP], np.uint8) < ord("\t")):
                raise RecordError(
                    "is no text: it holds bytes of numbers or of another format; export it as text, one sample a line"
                ) from None
            raise RecordError(
                f"is neither UTF-8 nor Windows-1252 text: byte 0x{byte:02x} on line {line}; save it as UTF-8"
            ) from None
        said["encoding"] = Remark(LeftOut.WINDOWS_1252, {"byte": byte, "line": line})
    # Loggers that lose their power leave zero bytes behind the last row.
    content = content.rstrip(b"\x1a\0")
    _refuse_control(content)
    # The minus sign that spreadsheets write in Swedish and other languages.
    if not content.isascii() and MINUS in content:
        content = MINUS_OF_NUMBER.sub(b"-", content)
    if b"\r" in content:
        content = content.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    # The serial monitor of Arduino writes an arrow between stamp and text.
    if re.match(rb"\d\d:\d\d:\d\d\.\d+ -> ", content):
        start = content[:TOP]
        content = content.replace(b" -> ", next((d for d in (b"\t", b";", b",") if d in start), b"\t"))
    # The search takes longer than reading the numbers; only a text that ends in a bracket is one.
    closed = content[-TOP:].rstrip(b"; \t\n\r\f\v").endswith(b"]")
    if closed and (whole := ONE_LINE.search(content)) is not None:
        rows = whole[1].replace(b";", b"\n").replace(b"...", b"")
        content = content[: whole.start()].rstrip(b" \t") + b"\n" + rows + b"\n"
    top = content[:TOP]
    if b"[" in top and b";" in top and PRINTED_MATRIX.search(top):
        content = BRACKETS.sub(lambda found: b" " * len(found[0]), content)
    return content if content.endswith(b"\n") else content + b"\n", said


def _wide(start: bytes) -> str | None:
    """Return the encoding of UTF-16 text without a mark: digits have a zero byte each."""
    half = len(start) // 2
    if half < 8 or b"\0" not in start or not set(start) & set(b"0123456789"):
        return None
    for encoding, zeros, others in (("utf-16-le", start[1::2], start[::2]), ("utf-16-be", start[::2], start[1::2])):
        if zeros.count(0) > 0.9 * half and not others.count(0):
            return encoding
    return None


def _refuse_control(content: bytes) -> None:
    # Comparisons of all bytes are five times faster than a search for some of them.
    for start in range(0, len(content), COMPARED):
        codes = np.frombuffer(content, np.uint8, min(COMPARED, len(content) - start), start)
        odd = codes < ord("\t")
        # Differences of unsigned bytes wrap around: from 0x0e to 0x1f.
        odd |= codes - np.uint8(0x0E) < 0x20 - 0x0E
        odd |= codes == 0x7F
        if odd.any():
            first = int(np.argmax(odd))
            line = content.count(b"\n", 0, start + first) + 1
            if codes[first]:
                what = f"the control byte 0x{codes[first]:02x}"
                raise RecordError(f"is not text: it contains {what} (line {line}); remove it, or export it anew")
            raise RecordError(
                f"is not text: it contains zero bytes (line {line}); if it is UTF-16, save it as UTF-8; if the logger "
                f"lost its power there, remove that line"
            )
