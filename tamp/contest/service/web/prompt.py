"""HTTP whose connections must ask in time: those that trickle a request in are closed, and bar nobody else."""

from __future__ import annotations

import asyncio
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

HEADER_S = 10.0
"""How long the head of a request may take; up to twice that where it begins between two looks [s]."""


class PromptProtocol(H11Protocol):
    """Uvicorn's protocol, which by itself waits for ever for the rest of a request's head."""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Look after the connection from its beginning."""
        super().connection_made(transport)
        self.loop.call_later(HEADER_S, self._look, self.cycle)

    def _look(self, before: Any) -> None:
        """Close it where it has asked nothing since the last look; those that rest uvicorn closes earlier."""
        if self.transport.is_closing():
            return
        if self.conn.their_state is h11.IDLE and self.cycle is before:
            self.transport.close()
        else:
            self.loop.call_later(HEADER_S, self._look, self.cycle)
