import pytest

from tamp.planning import Problem, solve

DOMAIN = """
(define (domain corridor)
  (:predicates (Place ?x) (Box ?b) (Way ?a ?t ?b) (Track ?t) (At ?x) (In ?b ?x) (Reach ?x) (Seen ?t))
  (:action go :parameters (?a ?b) :precondition (and (At ?a) (Place ?b) (Reach ?b))
    :effect (and (At ?b) (not (At ?a))))
  (:action lift :parameters (?b ?x) :precondition (and (Box ?b) (In ?b ?x)) :effect (not (In ?b ?x)))
  {more}
  (:derived (Reach ?b) (or (At ?b) (exists (?a ?t) (and (Reach ?a) (Way ?a ?t ?b) (Track ?t))))))
"""
STREAMS = """
(define (stream corridor)
  (:stream way :inputs (?a ?b) :domain (and (Place ?a) (Place ?b)) :fluents (In)
    :outputs (?t) :certified (and (Way ?a ?t ?b) (Track ?t))))
"""
WALK = """(:action walk :parameters (?a ?t ?b) :precondition (and (At ?a) (Way ?a ?t ?b))
    :effect (and (At ?b) (not (At ?a))))"""
SEE = "(:action see :parameters (?a ?t ?b) :precondition (Way ?a ?t ?b) :effect (Seen ?t))"


def corridor(more="", far=3, init=(), lift=True):
    """Places in a row, with a box in one of them that ways are told of."""

    def way(context, a, b):
        if abs(a - b) == 1 and all(fact[2] != b for fact in context.fluents):
            yield f"{a}-{b}"

    domain = DOMAIN.format(more=more)
    places = [("Place", x) for x in range(far + 1)]
    boxes = [("Box", "box")] if lift else []
    facts = [*places, *boxes, ("At", 0), ("In", "box", 2), *init]
    return Problem(domain, STREAMS, {"way": way}, facts, ("At", far))


@pytest.mark.parametrize("algorithm", ["adaptive", "focused", "incremental", "binding"])
@pytest.mark.parametrize(
    ("options", "actions"),
    [
        ({}, ["lift", "go"]),
        ({"far": 1}, ["go"]),
        ({"more": WALK}, ["lift", "go"]),
        ({"init": [("Way", 1, "bridge", 3), ("Track", "bridge")]}, ["go"]),
        ({"init": [("Way", 1, "bridge", 3), ("Track", "bridge")], "more": WALK}, ["go"]),
    ],
)
def test_rules_ask_in_each_state_whether_a_stream_gives_anything(options, actions, algorithm):
    solution = solve(corridor(**options), algorithm=algorithm, timeout=20)
    assert [action.name for action in solution.plan or ()] == actions


@pytest.mark.parametrize("algorithm", ["adaptive", "focused", "incremental", "binding"])
def test_where_no_state_lets_a_stream_give_anything_there_is_no_plan(algorithm):
    solution = solve(corridor(lift=False), algorithm=algorithm, timeout=20)
    assert solution.status in ("infeasible", "failed") and solution.plan is None


@pytest.mark.parametrize("algorithm", ["adaptive", "focused", "incremental", "binding"])
def test_rules_may_ask_a_test_told_the_state_of_places_that_nothing_else_names(algorithm):
    domain = DOMAIN.format(more="").replace("(Way ?a ?t ?b) (Track ?t)", "(Way ?a ?b)").replace("?a ?t", "?a")
    streams = STREAMS.replace(":outputs (?t) :certified (and (Way ?a ?t ?b) (Track ?t))", ":certified (Way ?a ?b)")

    def way(context, a, b):
        return abs(a - b) == 1 and all(fact[2] != b for fact in context.fluents)

    given = corridor()
    solution = solve(Problem(domain, streams, {"way": way}, given.init, given.goal), algorithm=algorithm, timeout=20)
    assert [action.name for action in solution.plan or ()] == ["lift", "go"]
