"""Likely slips of the pen: predicates that a stream certifies for nobody, or waits for in vain."""

from __future__ import annotations

import warnings
from collections.abc import Iterator

from tamp.errors import DomainWarning
from tamp.language import atoms
from tamp.language.sexpr import suggest
from tamp.planning.problem import Problem


def warn_of_slips(problem: Problem) -> None:
    """Warn of what is likely misspelt in the stream file of a problem."""
    for message in slips(problem):
        warnings.warn(message, DomainWarning, stacklevel=3)


def slips(problem: Problem) -> Iterator[str]:
    """A sentence for each predicate that is certified and never read, or asked for and never given.

    What the domain declares is as its author means it: streams often certify more than one problem needs.
    """
    domain, streams = problem.parsed_domain, problem.parsed_streams
    if not streams.mentions:
        return
    conditions = (problem.goal_formula, *(action.precondition for action in domain.actions.values()))
    read = {m.predicate for m in streams.mentions if not m.certified} | domain.predicates.keys()
    read |= {atom.predicate for condition in conditions for atom in atoms(condition)}
    read |= {name for stream in streams.streams for name in stream.fluents}
    given = {m.predicate for m in streams.mentions if m.certified} | domain.predicates.keys()
    given |= {atom.predicate for atom in problem.initial_state.facts} | {p.name for p in streams.predicates}
    first = {(m.predicate, m.certified): m for m in reversed(streams.mentions)}
    for mention in reversed(first.values()):
        if mention.certified and mention.predicate not in read:
            yield f"{mention.text}, which nothing reads{suggest(mention.predicate, read, 'predicates')}"
        elif not mention.certified and mention.predicate not in given and not streams.wild:
            yield f"{mention.text}, which no fact and no stream gives{suggest(mention.predicate, given, 'predicates')}"
