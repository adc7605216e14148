"""The order in which a skeleton's choices and checks are made."""

from __future__ import annotations

from itertools import count

import pytest

from tamp.planning import Problem, solve

DOMAIN = """(define (domain shelf)
  (:predicates (Item ?o) (Conf ?q) (Reach ?o ?p ?q) (Motion ?a ?t ?b) (Steady ?o ?p ?w)
               (AtConf ?q) (AtPose ?o ?p) (Placed ?o))
  (:action move :parameters (?a ?t ?b)
    :precondition (and (Motion ?a ?t ?b) (AtConf ?a))
    :effect (and (AtConf ?b) (not (AtConf ?a))))
  (:action put :parameters (?o ?p ?q ?w)
    :precondition (and (Reach ?o ?p ?q) (AtConf ?q) (Steady ?o ?p ?w))
    :effect (and (AtPose ?o ?p) (Placed ?o))))"""
STREAMS = """(define (stream shelf)
  (:stream sample-pose :inputs (?o) :domain (Item ?o)
    :outputs (?p ?q) :certified (and (Reach ?o ?p ?q) (Conf ?q)))
  (:stream plan-motion :inputs (?a ?b) :domain (and (Conf ?a) (Conf ?b)) %s
    :outputs (?t) :certified (Motion ?a ?t ?b))
  (:stream steady :inputs (?o ?p) :domain (Item ?o) %s
    :outputs (?w) :certified (Steady ?o ?p ?w)))"""
TOTAL = 9  # the poses of both objects are steady with this sum only


def problem(moves_see, steady_sees):
    asked = list[str]()

    def poses(context, item):
        for number in count():
            yield number, f"{item}@{number}"

    def motion(context, start, end):
        asked.append("motion")
        yield f"{start}->{end}"

    def steady(context, item, pose):
        asked.append("steady")
        stand = {fact[1]: fact[2] for fact in context.fluents if len(fact) == 3}
        full = {**stand, item: pose}
        if len(full) < 2 or sum(full.values()) == TOTAL:
            yield "yes"

    samplers = {"sample-pose": poses, "plan-motion": motion, "steady": steady}
    facts = [("Item", "a"), ("Item", "b"), ("Conf", "home"), ("AtConf", "home")]
    goal = ("and", ("Placed", "a"), ("Placed", "b"))
    told = tuple(f":fluents ({seen})" if seen else "" for seen in (moves_see, steady_sees))
    return Problem(DOMAIN, STREAMS % told, samplers, facts, goal), asked


@pytest.mark.parametrize("moves_see", ["", "AtPose"])
def test_what_is_told_of_the_state_is_asked_before_any_move_is_made(moves_see):
    asked_of, asked = problem(moves_see, "AtPose")
    solution = solve(asked_of, algorithm="adaptive", timeout=20.0, seed=0)
    assert [action.name for action in solution.plan] == ["move", "put"] * 2
    assert sum(action.args[1] for action in solution.plan if action.name == "put") == TOTAL
    assert asked.count("steady") > 3
    assert asked.count("motion") == 2


def test_what_is_told_of_where_moves_lead_waits_for_them():
    asked_of, asked = problem("AtPose", "AtPose AtConf")
    solution = solve(asked_of, algorithm="adaptive", timeout=20.0, seed=0)
    assert [action.name for action in solution.plan] == ["move", "put"] * 2
    assert asked.count("motion") > 2
