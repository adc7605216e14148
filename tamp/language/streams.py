"""A stream file as data: streams, functions, predicates and rules, and what each takes and promises."""

from __future__ import annotations

from dataclasses import dataclass

from tamp.language.domain import Signature
from tamp.language.formula import Atom, Variable


@dataclass(frozen=True, slots=True)
class Stream:
    """A conditional generator: for inputs that satisfy `domain` its sampler yields outputs that satisfy `certified`.

    Attributes:
        name: as in the file, in lower case.
        inputs: in the order in which the sampler takes them.
        domain: facts about the inputs that must hold before the sampler is called.
        outputs: in the order in which the sampler yields them; none for a test stream, whose sampler returns a bool.
        certified: facts about inputs and outputs that hold for what the sampler yields.
        fluents: predicates whose current facts the sampler is told.
        optimizer: the optimizer whose :variables or :constraint it is; empty for a stream of its own.
    """

    name: str
    inputs: tuple[Variable, ...]
    domain: tuple[Atom, ...]
    outputs: tuple[Variable, ...] = ()
    certified: tuple[Atom, ...] = ()
    fluents: tuple[str, ...] = ()
    optimizer: str = ""

    @property
    def is_test(self) -> bool:
        """Whether it only answers yes or no."""
        return not self.outputs


@dataclass(frozen=True, slots=True)
class FunctionStream:
    """A function whose sampler computes a number, such as a cost; 0 or more."""

    name: str
    inputs: tuple[Variable, ...]
    domain: tuple[Atom, ...]


@dataclass(frozen=True, slots=True)
class PredicateStream:
    """A predicate whose sampler computes whether it holds; unlike a test's, its negation may be planned for."""

    name: str
    inputs: tuple[Variable, ...]
    domain: tuple[Atom, ...]


@dataclass(frozen=True, slots=True)
class Rule:
    """An inference: wherever the facts of `domain` hold, those of `certified` do."""

    inputs: tuple[Variable, ...]
    domain: tuple[Atom, ...]
    certified: tuple[Atom, ...]


@dataclass(frozen=True, slots=True)
class Mention:
    """A place of the file that names a predicate which the domain does not declare.

    Attributes:
        predicate: its name.
        certified: whether it is certified there; otherwise it is asked for.
        text: file, line and column, and who names it; the beginning of a message.
    """

    predicate: str
    certified: bool
    text: str


@dataclass(frozen=True, slots=True)
class StreamFile:
    """All that a stream file declares, each in the order of the file.

    Attributes:
        signatures: predicates that the file names and the domain does not declare.
        mentions: where streams, functions, predicates and rules ask for them or certify them.
        wild: whether it has a `:wild-stream`, which may certify anything.
        objectives: optimizer -> the functions that it shall make small.
    """

    name: str
    streams: tuple[Stream, ...] = ()
    functions: tuple[FunctionStream, ...] = ()
    predicates: tuple[PredicateStream, ...] = ()
    rules: tuple[Rule, ...] = ()
    signatures: tuple[Signature, ...] = ()
    mentions: tuple[Mention, ...] = ()
    wild: bool = False
    objectives: tuple[tuple[str, tuple[str, ...]], ...] = ()
