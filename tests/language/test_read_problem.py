"""Problem files that cannot be read: what is wrong, and where."""

import pytest

from tamp.errors import DomainError, DomainWarning
from tamp.language import parse_domain, parse_problem

DOMAIN = parse_domain("""
(define (domain lamps)
  (:requirements :strips :typing)
  (:types lamp)
  (:constants porch - lamp)
  (:predicates (on ?x - lamp) (off ?x - lamp))
  (:functions (bill ?x - lamp))
  (:action turn :parameters (?x - lamp) :precondition (off ?x) :effect (and (on ?x) (not (off ?x)))))
""")
PROBLEM = """
(define (problem night)
  (:domain lamps)
  (:objects A 5 - lamp)
  (:init (off A) (off porch) (not (on 5)) (= (bill A) 1.5))
  (:goal (and (on A) (forall (?x - lamp) (or (on ?x) (off ?x)))))
  (:metric minimize (total-cost)))
"""


def test_what_a_file_says():
    found = parse_problem(PROBLEM, DOMAIN)
    types = (("lamp", "a"), ("lamp", "5"))
    assert found.init == (*types, ("off", "a"), ("off", "porch"), ("not", ("on", "5")), ("=", ("bill", "a"), 1.5))
    assert found.goal[:2] == ("and", ("on", "a"))


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("(:goal (and", "(:gaol (and", "6:4: unknown section ':gaol'; did you mean ':goal'"),
        ("(:metric minimize (total-cost))", "(:goal (on A))", "7:4: section ':goal' is there twice"),
        (
            "(:metric minimize (total-cost))",
            "(:metric maximize (total-cost))",
            "expected (:metric minimize (total-cost))",
        ),
        ("(:metric minimize (total-cost))", "(:constraints (always (on A)))", "unknown section ':constraints'"),
        ("(and (on A)", "(and (on B)", "6:19: undeclared constant 'b'"),
        ("(:goal (and", "(:goal (on A) (and", "expected (:goal FORMULA), found 2 operands"),
        ("5 - lamp", "5 - lump", "4:19: undeclared type 'lump'; did you mean 'lamp'"),
        ("A 5 - lamp", "A A - lamp", "object 'a' is named twice"),
        ("5 - lamp", "5 - (either lamp object)", "object 'a' has several types"),
        ("(off A)", "(of A)", "5:11: undeclared predicate 'of'"),
        ("(off A)", "(off A A)", "'off' takes 1 argument, found 2"),
        ("(bill A) 1.5", "(bill A) much", "5:55: expected a number, found 'much'"),
        ("(bill A) 1.5", "(bill A A) 1.5", "'bill' takes 1 argument, found 2"),
        ("(bill A) 1.5", "(bill A)", "expected (= (FUNCTION a ...) NUMBER)"),
    ],
)
def test_what_cannot_be_read_gets_a_sentence(old, new, told):
    assert old in PROBLEM
    with pytest.raises(DomainError, match="problem") as error:
        parse_problem(PROBLEM.replace(old, new), DOMAIN)
    assert told in str(error.value)


def test_a_goal_is_asked_for():
    with pytest.raises(DomainError, match="expected a"):
        parse_problem("(define (problem none) (:domain lamps) (:init (off porch)))", DOMAIN)


def test_a_problem_of_another_domain_is_warned_of():
    with pytest.warns(DomainWarning, match="the domain is 'lamps', not 'doors'"):
        parse_problem(PROBLEM.replace(":domain lamps", ":domain doors"), DOMAIN)
