"""PDDL and stream PDDL: text -> typed, immutable structures; errors with file, line and column."""

from tamp.language.domain import Action, Axiom, Domain, Effect, FunctionTerm, Signature
from tamp.language.formula import (
    OBJECT,
    TRUE,
    And,
    Atom,
    Constant,
    Equal,
    Exists,
    Forall,
    Formula,
    Not,
    Or,
    Parameter,
    Term,
    Variable,
    atoms,
    type_conditions,
)
from tamp.language.streams import FunctionStream, PredicateStream, Rule, Stream, StreamFile

__all__ = [
    "OBJECT", "TRUE", "Action", "And", "Atom", "Axiom", "Constant", "Domain", "Effect", "Equal", "Exists", "Forall",
    "Formula", "FunctionStream", "FunctionTerm", "Not", "Or", "Parameter", "PredicateStream", "Rule", "Signature",
    "Stream", "StreamFile", "Term", "Variable", "atoms", "type_conditions",
]  # fmt: skip
