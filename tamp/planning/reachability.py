"""What can be reached when nothing is ever deleted."""

from __future__ import annotations

from tamp.planning.knowledge import Knowledge
from tamp.planning.numbering import Body
from tamp.planning.objects import Fact
from tamp.planning.operators import GroundAxiom, GroundOperator


def reachable(
    state: dict[Fact, None], operators: list[GroundOperator], axioms: list[GroundAxiom], knowledge: Knowledge
) -> tuple[set[Fact], list[GroundOperator], dict[Fact, list[Body]]]:
    """Atoms, operators and axiom bodies that can be reached when deletes are ignored."""
    waiting: dict[Fact, list[tuple[object, int]]] = {}
    missing: list[int] = []
    things: list[tuple[str, object]] = []
    queue: list[Fact] = list(state)
    reached = set(state)
    live: list[int] = []
    static_true = {f for a in axioms for f in a.positive if knowledge.usable(f)}
    static_true |= {f for op in operators for f in op.positive if knowledge.usable(f)}

    def reach(fact: Fact) -> None:
        if fact not in reached:
            reached.add(fact)
            queue.append(fact)

    def fire(index: int) -> None:
        kind, thing = things[index]
        if kind == "operator":
            live.append(index)
        elif kind == "axiom":
            live.append(index)
            reach(thing.head)  # type: ignore[attr-defined]
        else:
            reach(thing.atom)  # type: ignore[attr-defined]

    ready: list[int] = []

    def watch(kind: str, thing: object, needed: tuple[Fact, ...]) -> None:
        index = len(things)
        things.append((kind, thing))
        needed = tuple(dict.fromkeys(needed))
        missing.append(len(needed))
        for fact in needed:
            waiting.setdefault(fact, []).append((thing, index))
        if not needed:
            ready.append(index)

    for fact in static_true:
        reach(fact)
    for op in operators:
        watch("operator", op, op.positive)
        for effect in op.effects:
            if effect.adds:
                watch("effect", effect, op.positive + effect.positive)
    for axiom in axioms:
        watch("axiom", axiom, axiom.positive)
    for index in ready:
        fire(index)
    while queue:
        for _, index in waiting.get(queue.pop(), ()):
            missing[index] -= 1
            if missing[index] == 0:
                fire(index)
    live.sort()
    bodies: dict[Fact, list[Body]] = {}
    for index in live:
        thing = things[index][1]
        if isinstance(thing, GroundAxiom):
            bodies.setdefault(thing.head, []).append((thing.positive, thing.negative))
    return reached, [thing for i in live if isinstance(thing := things[i][1], GroundOperator)], bodies
