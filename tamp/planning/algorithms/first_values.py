"""First values for what is hoped for, so that it can be priced: where an action would take place, and how far off."""

from __future__ import annotations

from tamp.planning.algorithms.session import Session

TRIES = 3
"""How often a stream is asked at most before nothing is known of it."""


def ask_for_first_values(session: Session, most: int) -> None:
    """Ask the streams behind the search's operators that have given nothing yet, with what others have given first.

    There are less than `most` calls in all.

    Raises:
        Ended: at a limit.
    """
    found: dict[int, int | None] = {}
    for operator in session.grounder.operators:
        for handle in operator.binding.values():
            session.limits.check()
            _value(session, handle, found, most)


def _value(session: Session, handle: int, found: dict[int, int | None], most: int) -> int | None:
    """The first value of a placeholder, None where there is none yet; what is no placeholder is its own."""
    origin = session.objects.origin(handle)
    if origin is None:
        return handle
    if handle not in found:
        found[handle] = None
        inputs = tuple(_value(session, h, found, most) for h in origin.inputs)
        real = tuple(h for h in inputs if h is not None)
        if len(real) == len(inputs) and not origin.external.fluents:
            instance = session.knowledge.instance(origin.external, real)
            calls = session.sampling.calls
            while not instance.results and not instance.exhausted and session.sampling.calls < min(calls + TRIES, most):
                if not all(map(session.evaluator.given, instance.domain)):
                    break
                session.sampling.draw(instance, brief=True)
            if instance.results:
                found[handle] = instance.results[0][origin.placeholders.index(handle)]
    return found[handle]
