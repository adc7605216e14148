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
from tamp.language.read_domain import parse_domain
from tamp.language.read_goal import InitialState, parse_goal, parse_init
from tamp.language.read_problem import ProblemFile, parse_problem
from tamp.language.read_streams import parse_streams
from tamp.language.sexpr import PDDL
from tamp.language.streams import FunctionStream, PredicateStream, Rule, Stream, StreamFile

__all__ = [
    "OBJECT", "PDDL", "TRUE", "Action", "And", "Atom", "Axiom", "Constant", "Domain", "Effect", "Equal", "Exists",
    "Forall", "Formula", "FunctionStream", "FunctionTerm", "InitialState", "Not", "Or", "Parameter", "PredicateStream",
    "ProblemFile", "Rule", "Signature", "Stream", "StreamFile", "Term", "Variable", "atoms", "parse_domain",
    "parse_goal", "parse_init", "parse_problem", "parse_streams", "type_conditions",
]  # fmt: skip
