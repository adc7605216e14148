"""Skeletons where the planner could fill in moves by itself: those named bind, others may come between."""

import pytest

from tamp.planning import Constraints, solve
from tamp.planning.pddlstream import WILD, And, PDDLProblem, PlanConstraints, from_fn
from tests.planning.problems import continuous
from tests.planning.test_problems import ALGORITHMS, check

ANY = ...

DOMAIN = """
(define (domain rail)
  (:predicates (Conf ?q) (Block ?b) (Motion ?q1 ?t ?q2) (AtConf ?q) (CanMove) (Kin ?b ?q) (On ?b) (Holding ?b))
  (:action move
    :parameters (?q1 ?t ?q2)
    :precondition (and (Motion ?q1 ?t ?q2) (AtConf ?q1) (CanMove))
    :effect (and (AtConf ?q2) (not (AtConf ?q1)) (not (CanMove))))
  (:action pick
    :parameters (?b ?q)
    :precondition (and (Kin ?b ?q) (AtConf ?q) (On ?b))
    :effect (and (Holding ?b) (CanMove) (not (On ?b))))
  (:action place
    :parameters (?b ?q)
    :precondition (and (Kin ?b ?q) (AtConf ?q) (Holding ?b))
    :effect (and (On ?b) (CanMove) (not (Holding ?b)))))
"""
STREAMS = """
(define (stream rail)
  (:stream ik :inputs (?b) :domain (Block ?b) :outputs (?q) :certified (and (Conf ?q) (Kin ?b ?q)))
  (:stream motion
    :inputs (?q1 ?q2) :domain (and (Conf ?q1) (Conf ?q2)) :outputs (?t) :certified (Motion ?q1 ?t ?q2)))
"""
STREAM_MAP = {"ik": from_fn(lambda block: (7,)), "motion": from_fn(lambda q1, q2: (f"{q1}-{q2}",))}
INIT = [("Conf", 0), ("Conf", 3), ("AtConf", 0), ("CanMove",), ("Block", "a"), ("On", "a")]

HELD, BACK = ("Holding", "a"), And(("AtConf", 0), ("On", "a"))
MOVE, PICK, PLACE = ("move", [WILD, WILD, WILD]), ("pick", ["a", WILD]), ("place", ["a", WILD])
TO_BLOCK, TO_START, NOWHERE = ("move", 0, "0-7", 7), ("move", 7, "7-0", 0), ("move", 7, "7-7", 7)
PICKED, PLACED = ("pick", "a", 7), ("place", "a", 7)


def rail(goal, domain=DOMAIN):
    """A hand at 0 on a rail, and a block that is reached from 7; one move after each thing that the hand did."""
    return PDDLProblem(domain, {}, STREAMS, STREAM_MAP, INIT, goal)


def planned(goal, constraints, algorithm):
    solution = solve(rail(goal), algorithm=algorithm, constraints=constraints, timeout=20.0)
    return None if solution.plan is None else [(action.name, *action.args) for action in solution.plan]


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize(
    ("goal", "skeleton", "plan"),
    [
        (BACK, [MOVE, PICK, MOVE, PLACE, MOVE], [TO_BLOCK, PICKED, NOWHERE, PLACED, TO_START]),
        (BACK, [MOVE, PICK, PLACE, MOVE], [TO_BLOCK, PICKED, PLACED, TO_START]),
        (BACK, [PICK, PLACE], None),
        (HELD, [PICK], None),
        (HELD, [("move", [WILD, WILD, 3]), PICK], None),
        (HELD, [MOVE, PICK, ("move", ["?q", WILD, "?q"])], [TO_BLOCK, PICKED, NOWHERE]),
        (HELD, [MOVE, PICK, ("move", [WILD, WILD, "places"])], [TO_BLOCK, PICKED, ("move", 7, "7-3", 3)]),
    ],
)
def test_an_exact_skeleton_is_the_plan(goal, skeleton, plan, algorithm):
    constraints = PlanConstraints(skeletons=[skeleton], groups={"places": [3]}, exact=True)
    assert planned(goal, constraints, algorithm) == plan


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_other_actions_may_come_between_those_of_a_skeleton_that_is_not_exact(algorithm):
    assert planned(HELD, PlanConstraints([[PICK]], exact=False), algorithm) == [TO_BLOCK, PICKED]
    away = planned(HELD, PlanConstraints([[("move", [WILD, WILD, 3])]], exact=False), algorithm)
    assert PICKED in away and ("move", 3) in [(name, args[-1]) for name, *args in away]


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_moves_are_filled_in_where_a_skeleton_names_none(algorithm):
    without = (("pick", "a", ANY), ("place", "a", ANY))
    assert planned(BACK, Constraints(skeleton=without), algorithm) == [TO_BLOCK, PICKED, PLACED, TO_START]
    assert planned(BACK, Constraints(skeleton=without, exact=True), algorithm) is None
    assert planned(BACK, Constraints(skeleton=(("move",), *without)), algorithm) is None


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_each_of_several_skeletons_says_by_itself_whether_moves_are_filled_in(algorithm):
    picked = (("pick", "a", ANY),)
    named = Constraints(skeletons=((*picked, ("move",)), (("move",), *picked, ("move", ANY, ANY, 3))))
    assert planned(HELD, named, algorithm) == [TO_BLOCK, PICKED, ("move", 7, "7-3", 3)]
    assert planned(HELD, Constraints(skeletons=(named.skeletons[0], picked)), algorithm) == [TO_BLOCK, PICKED]


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_moves_are_filled_in_also_where_the_search_must_see_what_they_cost(algorithm):
    domain = DOMAIN.replace("(not (CanMove)))", "(not (CanMove)) (increase (total-cost) (Far ?q1 ?q2)))")
    domain = domain.replace("(:action move", "(:functions (Far ?q1 ?q2)) (:action move")
    problem = rail(HELD, domain)
    streams = STREAMS.rstrip()[:-1] + "(:function (Far ?q1 ?q2) (and (Conf ?q1) (Conf ?q2))))"
    problem = problem._replace(stream_pddl=streams, stream_map={**STREAM_MAP, "Far": lambda q1, q2: 2.0})
    constraints = Constraints(skeleton=(("pick", "a", ANY),))
    solution = solve(problem, algorithm=algorithm, constraints=constraints, max_cost=5.0, timeout=20.0)
    assert solution.plan is not None and [action.name for action in solution.plan] == ["move", "pick"]


def test_constraints_that_say_nothing_of_moves_bar_none():
    assert planned(HELD, Constraints(exact=True), "adaptive") == [TO_BLOCK, PICKED]


@pytest.mark.parametrize("algorithm", ["adaptive", "focused"])
def test_a_plan_with_its_moves_is_a_skeleton(algorithm):
    problem = continuous.line(2)
    names = [action.name for action in solve(problem, timeout=20.0).plan]
    skeleton = tuple((name,) for name in names)
    solution = solve(problem, algorithm=algorithm, timeout=20.0, constraints=Constraints(skeleton=skeleton))
    assert solution.status == "solved", str(solution.report)
    check(problem, solution)
    assert [action.name for action in solution.plan] == names
