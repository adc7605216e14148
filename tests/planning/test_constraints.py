"""Skeletons with variables and with objects that only streams give; the matching by itself; what cannot be followed."""

import pytest

from tamp.planning import Constraints, Problem, solve
from tamp.planning.constraints import Course, Forbidden, Progress
from tamp.planning.model.objects import Objects
from tests.planning.problems import continuous
from tests.planning.test_problems import ALGORITHMS, check

ANY = ...

DOMAIN = """
(define (domain boxes)
  (:predicates (item ?x) (box ?b) (fits ?x ?b) (in ?x ?b) (shut ?b))
  (:action put :parameters (?x ?b) :precondition (and (item ?x) (fits ?x ?b) (not (shut ?b))) :effect (in ?x ?b))
  (:action shut :parameters (?b) :precondition (box ?b) :effect (shut ?b)))
"""

STREAMS = """
(define (stream boxes)
  (:stream find-box :inputs (?x) :domain (item ?x) :outputs (?b) :certified (and (box ?b) (fits ?x ?b))))
"""


def boxes(goal):
    """Every item fits into its own box and into two that all share, which a stream finds."""
    return Problem(
        domain=DOMAIN,
        streams=STREAMS,
        samplers={"find-box": lambda context, item: iter([f"box-{item}", "blue", "green"])},
        init=[("item", "a"), ("item", "b")],
        goal=goal,
    )


def names(solution):
    return [(action.name, *action.args) for action in solution.plan]


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize(
    "skeleton",
    [
        (("put", "a", "?b"), ("put", "b", "?b"), ("shut", "?b")),
        (("put", "a", "green"), ("put", "b", ANY), ("shut", "green")),
        (("put", "?x", "?b"), ANY, ("shut", "?b")),
        (ANY, ("put", "b", "blue"), ANY, ("shut", "?b"), ("shut", "?b")),
    ],
)
def test_skeletons_are_followed(skeleton, algorithm):
    problem = boxes(("and", ("exists", ("?b",), ("in", "a", "?b")), ("exists", ("?b",), ("in", "b", "?b"))))
    solution = solve(problem, algorithm=algorithm, timeout=20.0, constraints=Constraints(skeleton=skeleton))
    assert solution.status == "solved", str(solution.report)
    check(problem, solution)
    assert follows(names(solution), skeleton, {})


def follows(plan, skeleton, env):
    """By trying all ways, for plans without moves that are filled in."""
    if not skeleton:
        return not plan
    first, *rest = skeleton
    if first is ANY:
        return follows(plan, rest, env) or (bool(plan) and follows(plan[1:], skeleton, env))
    if not plan or plan[0][0] != first[0]:
        return False
    env = dict(env)
    for wanted, arg in zip(first[1:], plan[0][1:], strict=True):
        if wanted is not ANY and (env.setdefault(wanted, arg) if wanted.startswith("?") else wanted) != arg:
            return False
    return follows(plan[1:], rest, env)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_what_no_stream_gives_is_named(algorithm):
    constraints = Constraints(skeleton=(ANY, ("put", "a", "violet")))
    solution = solve(boxes(("exists", ("?b",), ("in", "a", "?b"))), algorithm=algorithm, constraints=constraints)
    assert solution.status == "infeasible"
    assert "The constraints name 'violet', which no fact names and no stream has given." in solution.report.message


def test_a_goal_that_nothing_can_give_is_named():
    solution = solve(boxes(("in", "a", "violet")))
    assert solution.status == "infeasible"
    assert "The goal names 'violet', which no fact names and no stream has given." in solution.report.message


def test_variables_in_forbidden_patterns_are_of_one_pattern():
    objects = Objects()
    a, b = objects.intern("a"), objects.intern("b")
    forbidden = Forbidden((("on", "?x", "?x"),), objects)
    assert forbidden("on", (a, a)) and not forbidden("on", (a, b))


def test_placeholders_may_be_anything():
    objects = Objects()
    a, hash_1 = objects.intern("a"), objects.placeholder("#1", object())
    course = Course(Constraints(skeleton=(("on", "?x", "b"),)), objects, frozenset())
    assert list(course.after(Progress(), "on", (a, hash_1), hopeful=True)) == [Progress(1, (("?x", a),))]
    assert list(course.after(Progress(), "on", (a, hash_1), hopeful=False)) == []


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_a_skeleton_without_moves_on_the_line(algorithm):
    problem = continuous.line(1)
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    skeleton = tuple((a.name, *(f"?{i}-{k}" for k in range(len(a.args)))) for i, a in enumerate(solution.plan))
    again = solve(problem, algorithm=algorithm, timeout=20.0, constraints=Constraints(skeleton=skeleton))
    assert [a.name for a in again.plan] == [a.name for a in solution.plan]
