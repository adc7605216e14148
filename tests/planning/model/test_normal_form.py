"""Schemas in normal form: what need not be told apart is not."""

from __future__ import annotations

from tamp.language import parse_domain
from tamp.planning.model.normal_form import Condition, normalise
from tamp.planning.model.objects import Objects

TEXT = """(define (domain d) (:requirements :adl) (:predicates (p ?x) (q ?x) (s))
  (:action a :parameters (?a) :effect EFFECT))"""


def effects(text):
    domain = parse_domain(TEXT.replace("EFFECT", text))
    (action,) = normalise(domain, domain.actions["a"].precondition, Objects()).actions
    return action.effects


def test_an_effect_for_all_objects_that_names_none_is_one_effect():
    """It was grounded for each object, and two such variables for each pair."""
    (effect,) = effects("(forall (?x ?y) (when (q ?a) (s)))")
    assert effect.condition == Condition(positive=(("q", "?a"),))
    (effect,) = effects("(forall (?x ?y) (when (not (q ?x)) (p ?y)))")
    assert len([p for p in effect.condition.positive if p[0] == "object"]) == 2


def test_a_parameter_that_equals_something_stays_one_in_effects():
    """It was taken for a variable of the effect's own, which nothing bound: a KeyError."""
    text = TEXT.replace(":effect EFFECT", ":precondition (exists (?z) (= ?a ?z)) :effect EFFECT")
    domain = parse_domain(text.replace("EFFECT", "(forall (?x) (when (= ?a ?x) (p ?a)))"))
    (action,) = normalise(domain, domain.actions["a"].precondition, Objects()).actions
    bound = {term for pattern in action.condition.positive for term in pattern[1:]}
    (effect,) = action.effects
    bound |= {term for pattern in effect.condition.positive if pattern[0] != "=" for term in pattern[1:]}
    assert set(effect.atom[1:]) <= bound
