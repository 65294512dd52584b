"""Lines of JSON that carry a digest of themselves and of every line before them: no byte changes unnoticed.

    chain_n = SHA-256(chain_(n-1) + body_n)         chain_0 = SHA-256("fsm-calib")

body_n is the line without its closing brace; the chain (64 hexadecimal digits) stands at the line's end. A seal tells
damage, of a disk or of an editor, not forgery: whoever writes new lines can seal them, too.
"""

from __future__ import annotations

import hashlib
import json
from typing import Any

START = hashlib.sha256(b"fsm-calib").hexdigest()
"""The chain before the first line."""
KEY = "chain"


def sealed(line: bytes, before: str = START) -> tuple[bytes, str]:
    """Return a line of JSON (an object that is not empty, with its line feed) with its seal, and the chain."""
    body = line[: line.rindex(b"}")]
    chain = _chain(before, body)
    return body + _tail(chain), chain


def unsealed(line: bytes, before: str = START) -> tuple[dict[str, Any], str] | None:
    """Return the object of a sealed line and its chain; None where any byte, or a line before, is not as written."""
    body = line[: -len(_tail(START))]
    chain = _chain(before, body)
    if line != body + _tail(chain):
        return None
    content: dict[str, Any] = json.loads(line)
    del content[KEY]
    return content, chain


def _chain(before: str, body: bytes) -> str:
    return hashlib.sha256(before.encode() + body).hexdigest()


def _tail(chain: str) -> bytes:
    return f',"{KEY}":"{chain}"}}\n'.encode()
