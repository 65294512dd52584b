"""TCPROS on the wire: blocks of bytes with their length in front, and the header that opens a connection."""

from __future__ import annotations

import socket
import struct
from collections.abc import Mapping

from fsm_calib.errors import LinkLost

LENGTH = struct.Struct("<I")
LONGEST_BLOCK = 1 << 26
"""A longer block is no message but a wrong protocol [bytes]."""


class Closed(Exception):
    """The other side ended the connection."""


def pack_header(fields: Mapping[str, str]) -> bytes:
    """Return a connection header as one block: u32 length, then fields of u32 length and ``key=value``."""
    parts = [f"{key}={value}".encode() for key, value in fields.items()]
    body = b"".join(LENGTH.pack(len(part)) + part for part in parts)
    return LENGTH.pack(len(body)) + body


def unpack_header(body: bytes) -> dict[str, str]:
    """Return the fields of a connection header's body.

    Raises
    ------
    LinkLost
        The bytes are no header.
    """
    fields, at = {}, 0
    try:
        while at < len(body):
            (size,) = LENGTH.unpack_from(body, at)
            key, found, value = body[at + 4 : at + 4 + size].decode().partition("=")
            if not found:
                raise ValueError(f"a field without '=': {key!r}")
            fields[key], at = value, at + 4 + size
    except (struct.error, ValueError) as error:
        raise LinkLost(f"the other side sent no ROS header ({error})", cure="Check the port.") from error
    return fields


def read_exactly(connection: socket.socket, size: int) -> bytes:
    """Return `size` bytes from a connection.

    Raises
    ------
    Closed
        The connection ended before them.
    """
    parts, missing = [], size
    while missing:
        part = connection.recv(min(missing, 1 << 20))
        if not part:
            raise Closed
        parts.append(part)
        missing -= len(part)
    return b"".join(parts)


def read_block(connection: socket.socket) -> bytes:
    """Return the next block, without its length.

    Raises
    ------
    Closed
        The connection ended, or what came is too long to be a message.
    """
    (size,) = LENGTH.unpack(read_exactly(connection, LENGTH.size))
    if size > LONGEST_BLOCK:
        raise Closed
    return read_exactly(connection, size)


def block(body: bytes) -> bytes:
    """Return a block: the body with its length in front."""
    return LENGTH.pack(len(body)) + body
