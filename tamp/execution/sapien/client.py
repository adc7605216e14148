"""SAPIEN, imported without its warnings of graphics libraries that simulating does not need."""

from __future__ import annotations

import warnings

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import sapien
    from sapien import physx

__all__ = ["physx", "sapien"]
