"""Blocks of MDF files, checked before asammdf follows them.

asammdf does not check links and sizes: in a damaged file it follows links in a circle, reads outside its memory, and
takes data beyond the end of the file as empty.
"""

from __future__ import annotations

import struct
import zlib
from collections import defaultdict
from dataclasses import dataclass, field
from enum import IntFlag

from suspid.errors import RecordError

# Bytes before the first block, and those of the head of a block of version 4.
FIRST_BLOCK, BLOCK_HEADER = 64, 24
# Links to follow, by the kind of block; each such block may be linked once. Other links lead to text and
# descriptions, which may be shared.
FOLLOWED_LINKS: dict[bytes, tuple[int, ...]] = dict.fromkeys((b"##CA", b"##FH", b"##AT", b"##EV", b"##HL"), (0,))
FOLLOWED_LINKS |= {b"##HD": (0, 1, 3, 4), b"##DG": (0, 1, 2), b"##CG": (0, 1), b"##CN": (0, 1, 5)}
LISTS = (b"##DL", b"##LD")
DATA = (b"##DT", b"##DV", b"##DI", b"##SD", b"##RD")
ZIPPED = b"##DZ"
# Fewest and most links, and least bytes after them.
LINKS = {b"##HD": (6, 6), b"##DG": (4, 4), b"##CG": (6, 7), b"##CN": (8, 99), b"##HL": (1, 1), ZIPPED: (0, 0)}
LINKS |= {b"##FH": (2, 2), b"##AT": (4, 4), b"##EV": (5, 1 << 32), **dict.fromkeys((b"##CA", *LISTS), (1, 1 << 32))}
LEAST_BODY = {b"##CG": 32, b"##CN": 24, b"##DG": 1, ZIPPED: 24}
# The same links may lead to other kinds, such as a group or an attachment, which are not followed.
ONLY_TO: dict[tuple[bytes, int], tuple[bytes, ...]] = {
    (b"##CN", 1): (b"##CN", b"##CA"),
    (b"##CA", 0): (b"##CN", b"##CA"),
    (b"##CN", 5): (*DATA, *LISTS, ZIPPED, b"##HL"),
}
# The same of versions 2 and 3: least size, and the kinds that the links lead to.
OLD: dict[bytes, tuple[int, tuple[tuple[int, bytes], ...]]] = {
    b"HD": (20, ((0, b"DG"),)),
    b"DG": (24, ((0, b"DG"), (1, b"CG"))),
    b"CG": (26, ((0, b"CG"), (1, b"CN"))),
    b"CN": (218, ((0, b"CN"),)),
}


class GroupFlag(IntFlag):
    """Flags of a group of channels."""

    VARIABLE_LENGTH = 1
    BUS_EVENT = 2
    PLAIN_BUS_EVENT = 4
    REMOTE_MASTER = 8


class ChannelFlag(IntFlag):
    """Flags of a channel: all samples are invalid, or a bit of each tells."""

    ALL_INVALID = 1
    INVALID_BIT = 2


@dataclass(slots=True)
class _Sizes:
    """Sizes that blocks state and hold, by the address of the group."""

    # Bytes by data group, and those of samples and of invalidation bits in a record by channel group.
    stated: defaultdict[int, int] = field(default_factory=lambda: defaultdict(int))
    held: defaultdict[int, int] = field(default_factory=lambda: defaultdict(int))
    records: dict[int, tuple[int, int]] = field(default_factory=dict)
    cycles: int = 0


def check_blocks(content: bytes) -> int:
    """Refuse a file whose blocks are linked in a circle, lie beyond its end or hold less than they state.

    Returns
    -------
    int
        Number of records that all groups state; 0 if the file was not finished, where none need be stated.
    """
    if content[:8].strip() not in (b"MDF", b"UnFinMF"):
        raise RecordError(f"is not an MDF file: it begins with {content[:8]!r}")
    if len(content) < FIRST_BLOCK + BLOCK_HEADER:
        raise RecordError("is cut off: it ends in its header")
    sizes = _check_old(content) if content[FIRST_BLOCK : FIRST_BLOCK + 2] == b"HD" else _check_new(content)
    if content[:3] != b"MDF":
        return 0
    for group, stated in sizes.stated.items():
        if stated > (held := sizes.held[group]):
            raise RecordError(
                f"is cut off or damaged: group {group} states {stated} bytes of samples and contains {held}"
            )
    return sizes.cycles


def _check_new(content: bytes) -> _Sizes:
    """Check a file of version 4."""
    sizes, seen, shared = _Sizes(), set[int](), set[int]()
    # A block belongs to the group at the address beside it: channels to their channel group, others to the data group.
    ahead = [(FIRST_BLOCK, 0)]
    while ahead:
        address, group = ahead.pop()
        kind, links = _block(content, address)
        _refuse_again(address, seen)
        group = address if kind == b"##DG" else group
        _measure(content, address, kind, len(links), group, sizes)
        followed = range(len(links)) if kind in LISTS else FOLLOWED_LINKS.get(kind, ())
        for place, target in enumerate(links):
            only_to = ONLY_TO.get((kind, place))
            if target and place in followed and (only_to is None or content[target : target + 4] in only_to):
                # Samples of a channel do not count for the group.
                ahead.append((target, {(b"##CN", 5): 0, (b"##CG", 1): address}.get((kind, place), group)))
            elif target:
                shared.add(target)
    done = set(seen)
    while shared:
        address = shared.pop()
        done.add(address)
        shared.update(target for target in _block(content, address)[1] if target and target not in done)
    return sizes


def _refuse_again(address: int, seen: set[int]) -> None:
    if address in seen:
        raise RecordError(f"is damaged: its blocks are linked in a circle at byte {address}")
    seen.add(address)


def _block(content: bytes, address: int) -> tuple[bytes, tuple[int, ...]]:
    """Return kind and links of a block of version 4 that lies within the file."""
    if address + BLOCK_HEADER > len(content):
        raise RecordError(f"is cut off: a block at byte {address} lies beyond its end")
    kind, _, size, count = struct.unpack_from("<4sIQQ", content, address)
    # The last data block of an unfinished file states no size.
    size = max(size, BLOCK_HEADER) if kind in DATA and content[:3] == b"UnF" else size
    fewest, most = LINKS.get(kind, (0, 1 << 32))
    if kind[:2] != b"##" or not fewest <= count <= most or size < BLOCK_HEADER + 8 * count + LEAST_BODY.get(kind, 0):
        raise RecordError(f"is damaged: there is no whole block at byte {address}")
    if address + size > len(content):
        raise RecordError(f"is cut off: it ends in the block {kind[2:].decode('latin1')!r} at byte {address}")
    return kind, struct.unpack_from(f"<{count}Q", content, address + BLOCK_HEADER)


def _measure(content: bytes, address: int, kind: bytes, links: int, group: int, sizes: _Sizes) -> None:
    """Note what a channel group states and a data block holds, and refuse channels that do not fit in the record."""
    body, size = address + BLOCK_HEADER + 8 * links, struct.unpack_from("<Q", content, address + 8)[0]
    if kind == b"##CG":
        _, cycles, flags, _, _, samples, invalid = struct.unpack_from("<QQHHIII", content, body)
        if (links == 7) != bool(flags & GroupFlag.REMOTE_MASTER):
            raise RecordError(f"is damaged: the channel group at byte {address} has {links} links")
        sizes.records[address] = (0, 0) if flags & GroupFlag.VARIABLE_LENGTH else (samples, invalid)
        if not flags & GroupFlag.VARIABLE_LENGTH:
            record_id = content[group + BLOCK_HEADER + 8 * struct.unpack_from("<Q", content, group + 16)[0]]
            sizes.stated[group] += cycles * (samples + invalid + record_id)
            sizes.cycles += cycles
    elif kind == b"##CN":
        what, _, _, shift, start, bits, flags, mark = struct.unpack_from("<4B4I", content, body)
        samples, invalid = sizes.records.get(group, (0, 0))
        # Virtual channels take no place.
        _check_fits(address, 8 * start + shift + bits if what not in (3, 6) else 0, samples)
        _check_fits(address, mark + 1 if flags & ChannelFlag.INVALID_BIT or (flags and invalid) else 0, invalid)
    elif kind == ZIPPED:
        method, whole, zipped = struct.unpack_from("<2xB5xQQ", content, body)
        if zipped > size - (body - address) - LEAST_BODY[ZIPPED]:
            raise RecordError(f"is damaged: the block at byte {address} states {zipped} compressed bytes")
        if method < 2 and _inflated(content[body + LEAST_BODY[ZIPPED] :][:zipped], whole) != whole:
            raise RecordError(f"is damaged: the block at byte {address} does not contain {whole} bytes")
        sizes.held[group] += whole
    elif kind in DATA:
        sizes.held[group] += max(0, size - BLOCK_HEADER)


def _check_fits(address: int, bits: int, record: int) -> None:
    if bits > 8 * record:
        raise RecordError(f"is damaged: the channel at byte {address} ends at bit {bits} of a record of {record} bytes")


def _inflated(zipped: bytes, most: int) -> int:
    """Return how many bytes compressed ones make, or how many more than ``most`` were made before giving up."""
    inflater, piece, size = zlib.decompressobj(), b"", 0
    try:
        while (zipped or piece) and not inflater.eof and size <= most:
            piece = inflater.decompress(zipped, 1 << 20)
            zipped, size = inflater.unconsumed_tail, size + len(piece)
    except zlib.error as refusal:
        raise RecordError(f"is damaged: its samples cannot be decompressed: {refusal}") from None
    return size


def _check_old(content: bytes) -> _Sizes:
    """Check a file of version 2 or 3."""
    order = ">" if content[24:26] not in (b"\0\0", b"  ") else "<"
    sizes, seen = _Sizes(), set[int]()
    ahead = [(FIRST_BLOCK, 0, b"HD")]
    while ahead:
        address, group, expected = ahead.pop()
        _refuse_again(address, seen)
        inside = address + 4 <= len(content)
        kind, size = struct.unpack_from(f"{order}2sH", content, address) if inside else (b"", 0)
        if kind != expected or address + size > len(content) or size < OLD[kind][0]:
            raise RecordError(f"is damaged or cut off: there is no whole block {expected.decode()!r} at byte {address}")
        links = struct.unpack_from(f"{order}4I", content, address + 4)
        if kind == b"DG":
            group = address
            sizes.held[group] = max(0, len(content) - links[3]) if links[3] else 0
        elif kind == b"CG":
            samples, cycles = struct.unpack_from(f"{order}HI", content, address + 20)
            sizes.stated[group] += cycles * (samples + struct.unpack_from(f"{order}H", content, group + 22)[0])
            sizes.records[address] = (samples, 0)
            sizes.cycles += cycles
        elif kind == b"CN":
            start, bits = struct.unpack_from(f"{order}HH", content, address + 186)
            more = struct.unpack_from(f"{order}H", content, address + 226)[0] if size >= 228 else 0
            _check_fits(address, start + bits + 8 * more, sizes.records[group][0])
        for place, target in OLD[kind][1]:
            if links[place]:
                ahead.append((links[place], address if (kind, target) == (b"CG", b"CN") else group, target))
    return sizes
