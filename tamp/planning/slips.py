"""Likely slips of the pen: predicates that are certified or given for nobody, or waited for in vain; unknown costs."""

from __future__ import annotations

import warnings
from collections.abc import Iterator

from tamp.errors import DomainWarning, nearest
from tamp.language import FunctionTerm, atoms
from tamp.language.sexpr import suggest
from tamp.planning.problem import Problem


def warn_of_slips(problem: Problem, priced: bool) -> None:
    """Warn of what is likely misspelt in a problem; of its costs where they count, being `priced`."""
    for message in (*slips(problem), *(unpriced(problem) if priced else ())):
        warnings.warn(message, DomainWarning, stacklevel=3)


def unpriced(problem: Problem) -> Iterator[str]:
    """A sentence for each function in an action's cost of which nothing gives a value."""
    given = {term.function for term in problem.initial_state.values}
    given |= {function.name for function in problem.parsed_streams.functions}
    for action in problem.parsed_domain.actions.values():
        named = [term.function for term in action.cost or () if isinstance(term, FunctionTerm)]
        for name in dict.fromkeys(name for name in named if name not in given):
            yield (
                f"action {action.name!r} is never possible: its cost names {name!r}, of which init gives no value, as "
                f"by ('=', ({name!r}, ...), 1), and which is no (:function ...) of the stream file"
            )


def slips(problem: Problem) -> Iterator[str]:
    """A sentence for each predicate that is certified and never read, or asked for and never given.

    What the domain declares is as its author means it: streams often certify more than one problem needs. Facts at the
    start may be of predicates that nothing reads; of those only one that is nearly another is told.
    """
    domain, streams = problem.parsed_domain, problem.parsed_streams
    conditions = (problem.goal_formula, *(action.precondition for action in domain.actions.values()))
    read = {m.predicate for m in streams.mentions if not m.certified} | domain.predicates.keys()
    read |= {atom.predicate for condition in conditions for atom in atoms(condition)}
    read |= {name for stream in streams.streams for name in stream.fluents}
    given = {m.predicate for m in streams.mentions if m.certified} | domain.predicates.keys()
    given |= {atom.predicate for atom in problem.initial_state.facts} | {p.name for p in streams.predicates}
    for predicate in dict.fromkeys(atom.predicate for atom in problem.initial_state.facts):
        if predicate not in read and (near := nearest(predicate, read)) is not None:
            yield f"init has {predicate!r}, which nothing reads; did you mean {near!r}?"
    first = {(m.predicate, m.certified): m for m in reversed(streams.mentions)}
    for mention in reversed(first.values()):
        if mention.certified and mention.predicate not in read:
            yield f"{mention.text}, which nothing reads{suggest(mention.predicate, read, 'predicates')}"
        elif not mention.certified and mention.predicate not in given and not streams.wild:
            yield f"{mention.text}, which no fact and no stream gives{suggest(mention.predicate, given, 'predicates')}"
