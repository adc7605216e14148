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


SKELETONS = (
    (("put", "a", "green"), ("shut", "green")),
    (("put", "b", ANY), ANY, ("shut", "?b"), ("put", "a", "?c")),
)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_one_of_several_skeletons_is_followed_from_the_start(algorithm):
    """What begins as the first and goes on as the second would be shorter than the second."""
    problem = boxes(("and", ("exists", ("?b",), ("in", "a", "?b")), ("exists", ("?b",), ("in", "b", "?b"))))
    constraints = Constraints(skeletons=SKELETONS)
    solution = solve(problem, algorithm=algorithm, timeout=20.0, constraints=constraints)
    assert solution.status == "solved", str(solution.report)
    check(problem, solution)
    assert follows(names(solution), SKELETONS[1], {}) and not follows(names(solution), SKELETONS[0], {})


MIXED = ((("put", "a", ANY), ("shut", "?b")), (ANY, ("put", "b", ANY), ("shut", "?b"), ("shut", "?b")))


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_what_went_before_in_one_skeleton_is_no_part_of_another(algorithm):
    """With "a" put, one shut and no more in the first skeleton, "b" cannot be put; the second goes by any way."""
    problem = boxes(("and", ("exists", ("?b",), ("in", "a", "?b")), ("exists", ("?b",), ("in", "b", "?b"))))
    solution = solve(problem, algorithm=algorithm, timeout=20.0, constraints=Constraints(skeletons=MIXED))
    assert solution.status == "solved" and follows(names(solution), MIXED[1], {})
    short = Constraints(skeletons=(MIXED[0], (("put", "b", ANY),)))
    assert solve(problem, algorithm=algorithm, timeout=20.0, constraints=short).status == "infeasible"


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_the_empty_skeleton_is_not_begun_by_another(algorithm):
    constraints = Constraints(skeletons=((), (("put", "a", ANY), ("shut", "blue"))))
    solution = solve(boxes(("shut", "blue")), algorithm=algorithm, timeout=20.0, constraints=constraints)
    assert [action.name for action in solution.plan] == ["put", "shut"]
    assert solve(boxes(("and",)), algorithm=algorithm, constraints=constraints).plan == ()


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_one_of_a_group_of_objects_stands_for_its_name(algorithm):
    problem = boxes(("exists", ("?x", "?b"), ("in", "?x", "?b")))
    groups = {"?x": ("b",), "box": ("green", "violet")}
    constraints = Constraints(skeletons=((("put", "?x", "box"),),), groups=groups)
    solution = solve(problem, algorithm=algorithm, timeout=20.0, constraints=constraints)
    assert names(solution) == [("put", "b", "green")]


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
    forbidden = Forbidden(Constraints(forbidden=(("on", "?x", "?x"),)), objects)
    assert forbidden("on", (a, a)) and not forbidden("on", (a, b))


def test_placeholders_may_be_anything():
    objects = Objects()
    a, hash_1 = objects.intern("a"), objects.placeholder("#1", object())
    course = Course(Constraints(skeleton=(("on", "?x", "b"), ("off", "?x", ...))), objects, frozenset())
    assert list(course.after(Progress(), "on", (a, hash_1), optimistic=True)) == [Progress(1, (("?x", a),))]
    assert list(course.after(Progress(), "on", (a, hash_1), optimistic=False)) == []


def test_variables_that_come_no_more_are_forgotten():
    """Else a chain of walks would have a way of its own for each sequence of places."""
    objects = Objects()
    places = [objects.intern(name) for name in "abcdef"]
    chain = tuple(("walk", f"?{i}", f"?{i + 1}") for i in range(8))
    course = Course(Constraints(skeleton=chain), objects, frozenset())
    at = set(course.starts)
    for _ in chain[:-1]:
        at = {p for b in at for x in places for y in places for p in course.after(b, "walk", (x, y), optimistic=False)}
        assert len(at) == len(places)
    ends = [p for b in at for x in places for y in places for p in course.after(b, "walk", (x, y), optimistic=False)]
    assert set(ends) == {Progress(8)} and len(ends) == len(places) ** 2


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_a_skeleton_without_moves_on_the_line(algorithm):
    problem = continuous.line(1)
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    skeleton = tuple((a.name, *(f"?{i}-{k}" for k in range(len(a.args)))) for i, a in enumerate(solution.plan))
    again = solve(problem, algorithm=algorithm, timeout=20.0, constraints=Constraints(skeleton=skeleton))
    assert [a.name for a in again.plan] == [a.name for a in solution.plan]
