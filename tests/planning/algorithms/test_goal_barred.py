"""A goal that a move alone would reach, where things that other actions take away are in that move's way."""

import math

import pytest

from tamp.planning.pddlstream import And, PDDLProblem, from_fn, from_gen_fn, from_list_fn, from_test, solve

DOMAIN = """
(define (domain wall)
  (:predicates (Conf ?q) (Traj ?t) (Motion ?q1 ?t ?q2) (Side ?b ?g) (Beside ?b ?g ?q) (Free ?t ?b) (Barred ?t)
    (Thing ?b) (AtConf ?q) (There ?b))
  (:action move :parameters (?q1 ?t ?q2)
    :precondition (and (Motion ?q1 ?t ?q2) (AtConf ?q1) (not (Barred ?t)))
    :effect (and (AtConf ?q2) (not (AtConf ?q1))))
  (:action take :parameters (?b ?g ?q)
    :precondition (and (Beside ?b ?g ?q) (AtConf ?q) (There ?b))
    :effect (not (There ?b)))
  (:derived (Barred ?t) (exists (?b) (and (Traj ?t) (Thing ?b) (There ?b) (not (Free ?t ?b))))))
"""

STREAMS = """
(define (stream wall)
  (:stream sides :inputs (?b) :domain (Thing ?b) :outputs (?g) :certified (Side ?b ?g))
  (:stream beside :inputs (?b ?g) :domain (Side ?b ?g) :outputs (?q) :certified (and (Beside ?b ?g ?q) (Conf ?q)))
  (:stream motion :inputs (?q1 ?q2) :domain (and (Conf ?q1) (Conf ?q2)) :outputs (?t)
    :certified (and (Motion ?q1 ?t ?q2) (Traj ?t)))
  (:stream free :inputs (?t ?b) :domain (and (Traj ?t) (Thing ?b)) :certified (Free ?t ?b)))
"""


def walls(places):
    """From (0, 0) to (6, 0), past things so near each other that one must be taken, by a side that is not behind it."""

    def distance(path, thing):
        (ax, ay), (bx, by) = path
        return min(math.dist((ax + (bx - ax) * k / 20, ay + (by - ay) * k / 20), thing) for k in range(21))

    def beside(thing, side):
        for k in range(100):
            angle = side + 0.3 * math.sin(k)
            yield ((thing[0] + 0.8 * math.cos(angle), thing[1] + 0.8 * math.sin(angle)),)

    stream_map = {
        "sides": from_list_fn(lambda thing: [(k * math.pi / 4,) for k in range(8)]),
        "beside": from_gen_fn(beside),
        "motion": from_fn(lambda start, end: ((start, end),)),
        "free": from_test(lambda path, thing: distance(path, thing) > 0.55),
    }
    start, end = (0.0, 0.0), (6.0, 0.0)
    init = [("Conf", start), ("AtConf", start), ("Conf", end)]
    init += [fact for place in places for fact in (("Thing", place), ("There", place))]
    return PDDLProblem(DOMAIN, {}, STREAMS, stream_map, init, And(("AtConf", end)))


@pytest.mark.parametrize("algorithm", ["adaptive", "focused", "binding", "incremental"])
def test_what_is_in_the_way_of_the_last_move_is_taken_away(algorithm):
    problem = walls([(3.0, float(y)) for y in (-1, 0, 1)])
    solution = solve(problem, algorithm=algorithm, max_time=10, success_cost=math.inf, unit_costs=True)
    assert solution.status == "solved"
    assert [action.name for action in solution.plan][-2:] == ["take", "move"]
