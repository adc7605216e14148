import pytest

from tamp.language import parse_streams
from tests.planning.oracles.validator import InvalidPlanError, validate

DOMAIN = """
(define (domain lamps)
  (:requirements :adl :derived-predicates :action-costs)
  (:types lamp switch - thing)
  (:constants main - switch)
  (:predicates (on ?l) (wired ?a ?b) (live ?a) (dark) (pressed ?s) (broken ?l))
  (:functions (effort ?s))
  (:action press
    :parameters (?s - switch)
    :precondition (and (not (pressed ?s)) (or (= ?s main) (live main)))
    :effect (and (pressed ?s)
                 (forall (?l - lamp) (when (and (wired ?s ?l) (not (broken ?l))) (on ?l)))
                 (forall (?l - lamp) (when (and (wired ?s ?l) (on ?l)) (not (on ?l))))
                 (increase (total-cost) (+ 1 (effort ?s)))))
  (:derived (live ?x) (or (pressed ?x) (exists (?y) (and (wired ?y ?x) (live ?y)))))
  (:derived (dark) (forall (?l - lamp) (not (on ?l)))))
"""
FACTS = [
    ("lamp", "red"), ("lamp", "green"), ("switch", "second"), ("wired", "main", "second"), ("wired", "second", "red"),
    ("wired", "main", "green"), ("=", ("effort", "main"), 2), ("=", ("effort", "second"), 0.5),
]  # fmt: skip
BOTH = [("press", ("main",)), ("press", ("second",))]


def test_conditional_effects_axioms_types_and_costs():
    goal = ("and", ("on", "red"), ("forall", ("?l - lamp",), ("on", "?l")), ("not", ("dark",)), ("live", "red"))
    assert validate(DOMAIN, FACTS, BOTH, goal) == 4.5


def test_conditions_are_read_before_the_action_and_adding_wins():
    # A lamp that is on is both added and deleted by its switch: it stays on.
    assert validate(DOMAIN, [*FACTS, ("on", "green")], BOTH[:1], ("on", "green")) == 3.0


@pytest.mark.parametrize(
    ("facts", "plan", "goal", "message"),
    [
        (FACTS, BOTH[1:], None, r"step 1, \(press second\): not met: \(or \(= second main\) \(live main\)\)"),
        (FACTS, BOTH[:1] * 2, None, r"step 2, \(press main\): not met: \(not \(pressed main\)\)"),
        (FACTS, BOTH[:1], ("on", "red"), r"the goal: not met: \(on red\)"),
        (FACTS, BOTH, ("dark",), r"the goal: not met: \(dark\)"),
        (FACTS, BOTH, ("exists", ("?l",), ("broken", "?l")), r"the goal: not met: \(exists \(\?l\) \(broken \?l\)\)"),
        (FACTS, [("press", ("red",))], None, "red is no switch"),
        (FACTS, [("press", ())], None, "takes 1 arguments"),
        (FACTS, [("smash", ())], None, "there is no such action"),
        (FACTS[:-2], BOTH, None, "has no value"),
        ([*FACTS, ("broken", "green")], BOTH, ("forall", ("?l - lamp",), ("on", "?l")), "the goal"),
    ],
)
def test_what_is_wrong_is_said(facts, plan, goal, message):
    with pytest.raises(InvalidPlanError, match=message):
        validate(DOMAIN, facts, plan, goal)


STREAMS = parse_streams("""
(define (stream lamps)
  (:predicate (broken ?l) (lamp ?l))
  (:function (effort ?s) (switch ?s))
  (:stream test-wired :inputs (?a ?b) :domain (and (switch ?a) (lamp ?b)) :certified (wired ?a ?b)))
""")


def test_predicates_and_functions_are_asked_again():
    samplers = {"broken": lambda context, lamp: lamp == "red", "effort": lambda context, switch: len(switch)}
    facts = [*FACTS[:-2], ("broken", "green"), ("switch", "main")]
    assert validate(DOMAIN, facts, BOTH, ("broken", "red"), STREAMS, samplers) == 2 + 4 + 6
    with pytest.raises(InvalidPlanError, match="the goal"):
        validate(DOMAIN, facts, BOTH, ("broken", "green"), STREAMS, samplers)


def test_facts_of_tests_are_asked_again():
    samplers = {"test-wired": lambda context, a, b: b == "green"}
    with pytest.raises(InvalidPlanError, match=r"\(wired second red\) is claimed, but test-wired says no"):
        validate(DOMAIN, FACTS, BOTH, None, STREAMS, samplers)


def test_states_can_be_observed():
    seen = []
    validate(
        DOMAIN, FACTS, BOTH, None, observe=lambda name, args, facts: seen.append((name, args, len(facts.get("on", ()))))
    )
    assert seen == [("press", ("main",), 0), ("press", ("second",), 1)]


def test_negation_waits_for_the_stratum_below():
    domain = """(define (domain d) (:predicates (edge ?a ?b) (reach ?a) (lonely ?a) (start ?a) (node ?a))
      (:derived (lonely ?a) (and (node ?a) (not (reach ?a))))
      (:derived (reach ?a) (or (start ?a) (exists (?b) (and (edge ?b ?a) (reach ?b))))))"""
    facts = [("node", n) for n in range(5)] + [("start", 0), ("edge", 0, 1), ("edge", 1, 2), ("edge", 4, 3)]
    goal = (
        "and",
        ("reach", 2),
        ("lonely", 3),
        ("lonely", 4),
        ("forall", ("?n",), ("imply", ("lonely", "?n"), ("node", "?n"))),
    )
    assert validate(domain, facts, [], goal) == 0
    with pytest.raises(InvalidPlanError):
        validate(domain, facts, [], ("lonely", 2))


def test_rules_derive_facts_and_nothing_else():
    domain = "(define (domain d) (:predicates (a ?x) (b ?x ?y) (c ?x) (done ?x)) (:action go :parameters (?x)"
    domain += " :precondition (c ?x) :effect (done ?x)))"
    streams = parse_streams(
        "(define (stream s) (:rule :inputs (?x ?y) :domain (and (a ?x) (b ?x ?y)) :certified (and (c ?y) (b ?y ?y))))"
    )
    facts = [("a", 1), ("b", 1, 2)]
    assert validate(domain, facts, [("go", (2,))], ("and", ("done", 2), ("b", 2, 2)), streams) == 1.0
    with pytest.raises(InvalidPlanError, match=r"step 1, \(go 1\): not met"):
        validate(domain, facts, [("go", (1,))], ("done", 1), streams)
