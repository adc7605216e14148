"""Messages on the contest's socket: a header in JSON and raw arrays. No pickle; sizes are limited before reading.

A message is, in network byte order: the four bytes "TC01", the header's and the arrays' sizes as 32-bit integers, the
header {"kind", "number", "fields", "arrays": [[name, type, shape], ...]}, and the arrays in that order, little-endian.
"""

from __future__ import annotations

import json
import math
import socket
import struct
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[Any]

PREFIX = struct.Struct("!4sII")
MAGIC = b"TC01"
TYPES: Mapping[str, np.dtype[Any]] = {"u1": np.dtype("u1"), "f4": np.dtype("<f4"), "f8": np.dtype("<f8")}
"""The types that an array may have."""

MOST_ARRAYS = 8
MOST_DIMENSIONS = 3
MOST_IN_DIMENSION = 1 << 20


class ProtocolError(Exception):
    """What came over the socket is no message, or too large a one."""


class Disconnected(ProtocolError):  # noqa: N818  an outcome as much as an error
    """The other side has closed the socket."""


@dataclass(frozen=True)
class SizeLimits:
    """The most that is accepted [bytes]."""

    header: int
    arrays: int


FROM_SOLUTION = SizeLimits(header=1 << 16, arrays=1 << 22)
FROM_SERVER = SizeLimits(header=1 << 20, arrays=1 << 26)


@dataclass(frozen=True, eq=False)
class Message:
    """One message.

    Attributes:
        kind: what it is.
        number: of the call, which its answer repeats.
        fields: JSON-like values.
        arrays: of the types in `TYPES`.
    """

    kind: str
    number: int = 0
    fields: Mapping[str, Any] = field(default_factory=dict)
    arrays: Mapping[str, Array] = field(default_factory=dict)


class Channel:
    """One end of a connected stream socket.

    Args:
        connection: the socket.
        limits: of what the other side may send.
    """

    def __init__(self, connection: socket.socket, limits: SizeLimits) -> None:
        self._socket, self._limits = connection, limits

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()

    def send(self, message: Message, timeout_s: float | None = None) -> None:
        """Send a message.

        Raises:
            TimeoutError: where the other side does not read it in time.
            Disconnected: where it is gone.
            ValueError: where an array has a type that the protocol does not know.
        """
        self._socket.settimeout(timeout_s)
        try:
            self._socket.sendall(encode(message))
        except TimeoutError:
            raise
        except OSError as error:
            raise Disconnected(f"the connection is closed ({error.strerror})") from error

    def receive(self, timeout_s: float | None = None) -> Message:
        """Wait for a message, all of which must come in time.

        Raises:
            TimeoutError: where it does not.
            ProtocolError: where it is none, or too large; nothing more can be read then.
        """
        deadline = math.inf if timeout_s is None else time.monotonic() + timeout_s
        magic, header_size, arrays_size = PREFIX.unpack(self._read(PREFIX.size, deadline))
        if magic != MAGIC:
            raise ProtocolError(f"a message begins with {MAGIC.decode()!r}, not {magic!r}")
        for name, size, most in (
            ("header", header_size, self._limits.header),
            ("arrays", arrays_size, self._limits.arrays),
        ):
            if size > most:
                raise ProtocolError(f"{name} of {size} bytes; {most} are the most")
        return decode(self._read(header_size, deadline), self._read(arrays_size, deadline))

    def _read(self, size: int, deadline: float) -> bytearray:
        """Exactly so many bytes; memory grows with what comes, not with what was announced."""
        data = bytearray()
        while len(data) < size:
            left = deadline - time.monotonic()
            if left <= 0:
                raise TimeoutError
            self._socket.settimeout(None if left == math.inf else left)
            try:
                piece = self._socket.recv(min(size - len(data), 1 << 20))
            except TimeoutError:
                raise
            except OSError as error:
                raise Disconnected(f"the connection is closed ({error.strerror})") from error
            if not piece:
                raise Disconnected("the connection is closed")
            data += piece
        return data


def encode(message: Message) -> bytes:
    """A message as bytes; ValueError where a value or an array's type is none that the protocol knows."""
    arrays = message.arrays
    described = [[name, _type(name, array), list(array.shape)] for name, array in arrays.items()]
    fields = {"kind": message.kind, "number": message.number, "fields": dict(message.fields), "arrays": described}
    header = json.dumps(fields, allow_nan=False, separators=(",", ":")).encode()
    body = b"".join(array.tobytes() for array in arrays.values())
    return PREFIX.pack(MAGIC, len(header), len(body)) + header + body


def _type(name: str, array: Array) -> str:
    for word, dtype in TYPES.items():
        if array.dtype == dtype:
            return word
    raise ValueError(f"array {name!r} is of type {array.dtype}; valid are {', '.join(map(str, TYPES.values()))}")


def decode(header: bytes | bytearray, body: bytes | bytearray) -> Message:
    """The message of a header and the bytes of its arrays.

    Raises:
        ProtocolError: where they are none.
    """
    try:
        value = json.loads(header.decode("utf-8"), parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as error:
        raise ProtocolError(f"the header is no JSON: {error}") from None
    if not isinstance(value, dict) or set(value) != {"kind", "number", "fields", "arrays"}:
        raise ProtocolError("a header has kind, number, fields and arrays")
    kind, number, fields, described = (value[key] for key in ("kind", "number", "fields", "arrays"))
    if type(kind) is not str or type(number) is not int or type(fields) is not dict or type(described) is not list:
        raise ProtocolError("kind must be text, number an integer, fields an object and arrays a list")
    if len(described) > MOST_ARRAYS:
        raise ProtocolError(f"{len(described)} arrays; {MOST_ARRAYS} are the most")
    arrays: dict[str, Array] = {}
    used = 0
    for entry in described:
        name, dtype, shape = _description(entry)
        size = dtype.itemsize * math.prod(shape)
        if name in arrays or used + size > len(body):
            raise ProtocolError(f"array {name!r} comes twice, or is larger than what was sent")
        arrays[name] = np.frombuffer(body, dtype, math.prod(shape), used).reshape(shape)
        used += size
    if used != len(body):
        raise ProtocolError(f"{len(body) - used} bytes belong to no array")
    return Message(kind, number, fields, arrays)


def _description(entry: Any) -> tuple[str, np.dtype[Any], tuple[int, ...]]:
    match entry:
        case [str(name), str(word), list(shape)] if word in TYPES and len(shape) <= MOST_DIMENSIONS:
            # No more than NumPy takes, which minds the other sizes also where one of them is zero.
            if all(type(n) is int and 0 <= n <= MOST_IN_DIMENSION for n in shape):
                dtype: np.dtype[Any] = TYPES[word]
                return name, dtype, tuple(shape)
    raise ProtocolError(f"an array is described by its name, one of {', '.join(TYPES)}, and its shape")


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is no JSON")
