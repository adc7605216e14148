"""Which sandbox is used: the first one that this machine allows."""

from __future__ import annotations

from tamp.contest.sandbox.bubblewrap import Bubblewrap
from tamp.contest.sandbox.isolation import Sandbox
from tamp.contest.sandbox.namespaces import Namespaces
from tamp.contest.sandbox.plain import Plain
from tamp.errors import TampError

KINDS: tuple[type[Bubblewrap] | type[Namespaces], ...] = (Bubblewrap, Namespaces)
"""The ways to isolate, the best one first."""


def choose(*, name: str | None = None, insecure: bool = False) -> Sandbox:
    """A sandbox that works here.

    Args:
        name: "bubblewrap" or "namespaces"; None is the first of them that works.
        insecure: run without isolation, as the user insists.

    Raises:
        TampError: where none works; says why not, and what to do.
    """
    if insecure:
        return Plain()
    kinds = [kind() for kind in KINDS if name in (None, kind.name)]
    if not kinds:
        raise TampError(f"unknown sandbox {name!r}; valid are {', '.join(kind.name for kind in KINDS)}")
    reasons = []
    for sandbox in kinds:
        reason = sandbox.missing()
        if not reason:
            return sandbox
        reasons.append(f"{sandbox.name}: {reason}")
    raise TampError(
        f"solutions cannot be isolated on this machine ({'; '.join(reasons)}); install bubblewrap and allow "
        "unprivileged user namespaces, or insist with --no-isolation on running solutions that you trust"
    )
