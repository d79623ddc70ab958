"""Messages between a process and its workers, through pipes."""

import pickle
from typing import IO


def send(stream: IO[bytes], value: object) -> None:
    """Write a value as a message."""
    send_pickled(stream, pickle.dumps(value))


def send_pickled(stream: IO[bytes], content: bytes) -> None:
    """Write a message after its length, so that the next one can be read even if this one cannot be unpickled."""
    stream.write(len(content).to_bytes(8))
    stream.write(content)
    stream.flush()


def received(stream: IO[bytes]) -> bytes:
    """The next message of `send`, still pickled; EOFError if the stream ends before."""
    content = stream.read(int.from_bytes(head := stream.read(8)))
    if len(head) < 8 or len(content) < int.from_bytes(head):
        raise EOFError
    return content
