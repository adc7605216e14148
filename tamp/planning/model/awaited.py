"""Streams whose domain names what actions change: what they certify holds in the states where their domain does.

PDDLStream calls such streams exogenous and compiles them in the same way: the stream is called for whatever actions may
bring, certifies a fact of its own about its inputs and outputs, and axioms derive from it and from the rest of its
domain what the file says that it certifies.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from tamp.errors import DomainError
from tamp.planning.model.external import External
from tamp.planning.model.normal_form import AxiomSchema, Condition

OWN_MARK = "@by-"
"""Prefix of the predicate that a stream certifies of its inputs and outputs together."""


def await_domains(
    externals: dict[str, External], changing: frozenset[str], fluents: frozenset[str], types: Collection[str]
) -> tuple[dict[str, External], tuple[AxiomSchema, ...]]:
    """Streams that wait for nothing but what no action changes, and the axioms that say the rest.

    Args:
        externals: the streams as the file has them.
        changing: predicates whose truth actions may change.
        fluents: those among them that actions change themselves.
        types: of the domain; that an object is of a type does not change.

    Raises:
        DomainError: where a stream that waits for a changing fact certifies what actions change.
    """
    guarded: set[str] = set()
    while True:
        now = changing | guarded
        waiting = [e for e in externals.values() if any(p[0] in now for p in e.domain)]
        more = {str(p[0]) for e in waiting for p in e.certified if p[0] not in types}
        if more <= guarded:
            break
        guarded |= more
    clash = sorted(guarded & fluents)
    if clash:
        names = ", ".join(e.name for e in waiting if any(p[0] in clash for p in e.certified))
        raise DomainError(
            f"stream {names}: its :domain depends on what actions change, so it cannot certify {clash[0]!r}, which "
            "actions change as well"
        )
    changed: dict[str, External] = {}
    axioms: list[AxiomSchema] = []
    for external in externals.values():
        mine = tuple(p for p in external.certified if p[0] in guarded)
        if not mine:
            changed[external.name] = external
            continue
        own = (OWN_MARK + external.name, *external.inputs, *external.outputs)
        awaited = tuple(p for p in external.domain if p[0] in now)
        axioms += [AxiomSchema(p, Condition(positive=(own, *awaited))) for p in mine]
        changed[external.name] = replace(
            external,
            domain=tuple(p for p in external.domain if p[0] not in now),
            certified=(*(p for p in external.certified if p[0] not in guarded), own),
            awaited=awaited,
            guarded=mine,
        )
    return changed, tuple(axioms)
