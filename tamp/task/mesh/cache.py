"""Results that are expensive to compute and depend on content alone, kept as .npz files in the user's cache folder."""

from __future__ import annotations

import hashlib
import os
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Arrays = Mapping[str, "NDArray[np.generic[Any]]"]


def content_key(*pieces: bytes | str) -> str:
    """A name for content: the SHA-256 of the pieces, each delimited."""
    digest = hashlib.sha256()
    for piece in pieces:
        raw = piece.encode() if isinstance(piece, str) else piece
        digest.update(len(raw).to_bytes(8, "little"))
        digest.update(raw)
    return digest.hexdigest()[:32]


def cached(kind: str, key: str, compute: Callable[[], Arrays], worth_s: float = 0.0) -> Arrays:
    """The arrays stored under `kind` and `key`, computed and stored where they are absent or unreadable.

    Files are written aside and moved into place, so that processes sharing the folder never read half a file. A folder
    that cannot be written to costs the speed, not the result.

    Args:
        kind: the folder's name.
        key: what the content is filed under, from `content_key`.
        compute: works it out.
        worth_s: what takes less processor time than this is not stored, so that many cheap results fill no disk [s].
    """
    import zipfile
    import zlib

    import numpy as np

    path = _folder() / kind / f"{key}.npz"
    try:
        with np.load(path, allow_pickle=False) as stored:
            return {name: stored[name] for name in stored.files}
    except (OSError, ValueError, EOFError, zipfile.BadZipFile, zlib.error):
        pass
    began = time.process_time()
    arrays = compute()
    if time.process_time() - began < worth_s:
        return arrays
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        new = path.with_suffix(f".{os.getpid()}.tmp")
        with new.open("wb") as file:
            np.savez_compressed(file, allow_pickle=False, **dict(arrays))
        new.replace(path)
    except OSError:
        pass
    return arrays


def _folder() -> Path:
    """`$TAMP_CACHE`, else `$XDG_CACHE_HOME/tamp`, else `~/.cache/tamp`."""
    if own := os.environ.get("TAMP_CACHE"):
        return Path(own)
    shared = os.environ.get("XDG_CACHE_HOME")
    return (Path(shared) if shared else Path.home() / ".cache") / "tamp"
