"""First plans are cheap: values are made anew, and a moment is searched below their cost, whatever the algorithm."""

import numpy as np
import pytest

from benchmarks.pddlstream.roads import logistics
from benchmarks.pddlstream.shapes import field, shelf
from benchmarks.pddlstream.shelf import carrying
from benchmarks.pddlstream.small import packing, roadmap
from benchmarks.pddlstream.trips import alley, survey
from tamp import clock
from tamp.planning import Problem, solve
from tamp.planning.algorithms.adaptive import _replace_optimistic
from tamp.planning.algorithms.session import Session
from tamp.planning.options import Options
from tamp.planning.pddlstream import from_gen_fn, from_stream_map
from tamp.planning.search.fast_downward import FastDownward
from tests.planning.test_cheapest import OFFER, OFFERS, offers
from tests.planning.test_problems import ALGORITHMS, check

LINE = {"floor": (-10.0, 10.0), "goal": (5.0, 10.0)}


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_of_what_streams_give_the_cheapest_is_taken(algorithm):
    problem = offers(1.0)
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    check(problem, solution)
    assert solution.cost == 4e5


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_things_are_put_where_the_way_is_short(algorithm):
    """The first values cost up to 33 where 24.5 will do."""
    problem = packing(2, (6.0, 1.0), costs=True)
    costs = []
    for seed in range(4):
        solution = solve(problem, algorithm=algorithm, timeout=20.0, seed=seed)
        costs.append(solution.cost)
    assert sum(costs) / len(costs) < 28.0, costs


PARKING = """
(define (domain parking)
  (:predicates (Car ?c) (Slot ?c ?s) (Free ?c ?s) (Card ?c ?k) (Ticket ?c ?t) (Parked ?c))
  (:functions (total-cost))
  (:action park
    :parameters (?c ?s)
    :precondition (and (Slot ?c ?s) (Free ?c ?s))
    :effect (and (Parked ?c) (increase (total-cost) 1)))
  (:action pay
    :parameters (?c ?t) :precondition (Ticket ?c ?t) :effect (and (Parked ?c) (increase (total-cost) 30))))
"""

PARKING_STREAMS = """
(define (stream parking)
  (:stream find-slot :inputs (?c) :domain (Car ?c) :outputs (?s) :certified (Slot ?c ?s))
  (:stream find-card :inputs (?c) :domain (Car ?c) :outputs (?k) :certified (Card ?c ?k))
  (:stream buy-ticket :inputs (?c ?k) :domain (Card ?c ?k) :outputs (?t) :certified (Ticket ?c ?t))
  (:stream test-free :inputs (?c ?s) :domain (Slot ?c ?s) :certified (Free ?c ?s)))
"""


def find_slot(context, car):
    while True:
        yield context.rng.random()


SLOTS = {
    "find-slot": find_slot,
    "find-card": lambda context, car: iter(["card"]),
    "buy-ticket": lambda context, car, card: iter(["ticket"]),
    "test-free": lambda context, car, slot: slot > 0.85,
}


def test_what_failed_for_want_of_luck_is_tried_again():
    """One time in seven there was no free slot among the dozen that were looked at, and the car park was paid for."""
    problem = Problem(PARKING, PARKING_STREAMS, SLOTS, [("Car", "car")], ("Parked", "car"))
    costs = [solve(problem, timeout=20.0, seed=seed).cost for seed in range(30)]
    assert max(costs) == 1.0, costs


@pytest.mark.parametrize("algorithm", ["adaptive", "binding", "focused"])
def test_nothing_is_moved_twice_for_want_of_luck(algorithm):
    """Skeletons with values that were all known by then, or that came after a hopeless one, were not tried again.

    What was to be put in place stood in the way at first, and was moved twice: 13 actions in two of four seeds.
    """
    for seed in range(4):
        rng = np.random.default_rng(seed)
        problem = shelf([0.0, 7.5, -9.0], {"A": "goal"}, LINE, rng=rng)
        solution = solve(problem, algorithm=algorithm, timeout=20.0, seed=seed)
        check(problem, solution)
        assert len(solution.plan) == 9, (seed, solution.cost)


UNPRICED = """
(define (domain unpriced)
  (:predicates (Car ?c) (Slot ?c ?s) (Free ?c ?s) (Card ?c ?k) (Ticket ?c ?t) (Ready ?c) (Parked ?c))
  (:action park :parameters (?c ?s) :precondition (and (Slot ?c ?s) (Free ?c ?s)) :effect (Parked ?c))
  (:action queue :parameters (?c) :precondition (Car ?c) :effect (Ready ?c))
  (:action pay :parameters (?c ?t) :precondition (and (Ready ?c) (Ticket ?c ?t)) :effect (Parked ?c)))
"""


def test_fewer_actions_are_worth_a_moment_where_none_has_a_cost():
    """Ten of thirty cars queued for a ticket, as there was no free slot among the dozen that were looked at."""
    problem = Problem(UNPRICED, PARKING_STREAMS, SLOTS, [("Car", "car")], ("Parked", "car"))
    costs = [solve(problem, timeout=20.0, seed=seed).cost for seed in range(30)]
    assert max(costs) == 1.0, costs


def test_what_a_shorter_plan_wants_may_come_in_the_next_round():
    """The only free slot is the third one, and by the second round a ticket could be paid for."""
    samplers = {**SLOTS, "find-slot": lambda context, car: iter([0.1, 0.2, 0.9])}
    problem = Problem(UNPRICED, PARKING_STREAMS, samplers, [("Car", "car")], ("Parked", "car"))
    assert solve(problem, algorithm="incremental", timeout=20.0).cost == 1.0


@pytest.mark.parametrize("seed", [0, 7])
def test_moves_count_in_what_a_shorter_plan_may_take(seed):
    """A plan's moves, which the search leaves out, counted nothing in its bound: no plan was below it but of 16."""
    problem = packing(2, (4.0, 1.0), {"left": (-1.0, 5.5), "right": (2.5, 30.0)})
    solution = solve(problem, algorithm="incremental", timeout=20.0, seed=seed)
    check(problem, solution)
    assert len(solution.plan) == 12


def test_known_values_are_left_open_where_a_plan_is_tried_again():
    """Plans of values that were all known took the turns of those that had something to choose: 13 actions."""
    rng = np.random.default_rng(5)
    problem = shelf([0.0, 7.5, -9.0, -6.0, -3.0], {"A": "goal"}, LINE, rng=rng)
    solution = solve(problem, algorithm="focused", timeout=20.0, seed=5)
    check(problem, solution)
    assert len(solution.plan) == 9, solution.cost


def test_what_is_sampled_after_a_search_that_took_too_long_is_tried_in_the_best_plan():
    """More and more was sampled, and nothing of it was tried: for seconds a plan stayed as it was."""
    problem = shelf([0.0, -3.0], {"A": "goal", "B": "goal"}, LINE)
    session = Session(problem, Options(), FastDownward(), eager=False, started=clock.now())
    session.begin()
    tried: list[Session] = []
    session.on_better = tried.append
    _replace_optimistic(session)
    assert not tried
    session.found.best = ()
    _replace_optimistic(session)
    assert tried == [session]


@pytest.mark.parametrize("algorithm", ["adaptive", "binding"])
def test_another_robot_is_sent_only_where_that_is_cheaper(algorithm):
    """One that was found to be dear was kept, as its one rival was given up after three values: 113 for 91."""
    costs = []
    for seed in range(5, 8):
        rng = np.random.default_rng(seed)
        problem = shelf([0.0, -3.0, -6.0], {"A": "goal", "B": "goal"}, LINE, arms=2, rng=rng)
        solution = solve(problem, algorithm=algorithm, timeout=20.0, seed=seed)
        check(problem, solution)
        costs.append(solution.cost)
    assert max(costs) < 106.0, costs


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_a_way_that_is_known_to_be_closed_is_not_priced(algorithm):
    """A function of an edge was asked for its value after the edge had turned out not to be one."""
    problem = roadmap(60)
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    check(problem, solution)
    assert solution.status == "solved"


def test_what_is_hoped_for_costs_what_its_own_stream_has_given():
    """The mean of all offers was taken, however dear those of other things are: cheaper plans were not searched for."""
    stream_map = {"ask": from_gen_fn(lambda thing: ((price,) for price in (2.0, 3.0, 4.0))), "Amount": float}
    init = [("Thing", "ball"), ("Thing", "car"), ("Price", 900.0), ("Offer", "car", 900.0)]
    goal = ("and", ("Bought", "ball"), ("Bought", "car"))
    problem = Problem(OFFER, OFFERS, from_stream_map(stream_map), init, goal)
    session = Session(problem, Options(), FastDownward(), eager=False, started=clock.now())
    session.begin()
    hoped = [op for op in session.grounder.operators if not all(map(session.objects.is_real, op.args))]
    ball = next(op for op in hoped if session.objects.value(op.args[0]) == "ball")
    assert session.costs.of_operator(next(op for op in session.grounder.operators if op not in hoped)) == 9000
    session.costs.prefer_cheap(1000.0, exact=True)
    session.costs.guess(True)
    assert session.costs.of_operator(ball) == 900 * session.costs.scale
    for _ in range(3):
        session.sampling.draw(ball.needs[0])
    assert session.costs.of_operator(ball) == 3 * session.costs.scale


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_what_the_goal_names_stays_what_it_is(algorithm):
    problem = shelf([-2.0, -5.0], {"A": 2.0, "B": "goal"}, LINE)
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    check(problem, solution)
    assert solution.cost < 105.0


@pytest.mark.parametrize("algorithm", ["adaptive", "incremental"])
def test_a_moment_is_searched_below_the_cost_of_the_first_plan(algorithm):
    """The first plan costs 69 or 70 where 56 will do, as tasks of so many operators are searched with a weight."""
    solution = solve(logistics(20, 4, 2), algorithm=algorithm, timeout=20.0)
    assert solution.cost <= 61.0


def test_where_a_plan_must_be_cheap_there_is_one_at_all():
    """Moves were in the search from the start, where each is told the state: there was no plan until time was up."""
    problem = carrying([-4.0, 0.0], {"A": "goal"}, LINE)
    solution = solve(problem, success_cost=0.0, timeout=3.0)
    check(problem, solution)
    assert solution.status == "solved" and solution.cost < 80.0


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_no_needless_ways_are_gone(algorithm):
    """Ways of which nothing is known seemed to cost nothing: each picture was sent on a trip of its own."""
    problem = survey(2, 3, 2)
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    check(problem, solution)
    assert len(solution.plan) <= 23 and solution.cost < 57.0


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_what_is_in_the_way_is_put_aside_nearby(algorithm):
    problem = alley({"a": 0.0, "b": 6.5}, {"a": "bay"}, bays={"bay": (5.5, 7.5)})
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    check(problem, solution)
    assert solution.cost < 90.0


TWICE_MOVED = [("focused", 0), ("focused", 6), ("incremental", 3), ("incremental", 9)]
"""Algorithms, and seeds with which they moved too much."""


@pytest.mark.parametrize(("algorithm", "seed"), TWICE_MOVED)
def test_one_of_two_in_the_way_is_left_where_it_is(algorithm, seed):
    """Both were put aside, or one twice, for 118 and more: what was drawn for one alone had not fitted."""
    problem = shelf([0.0, 6.5, 8.5], {"A": "goal"}, LINE, rng=np.random.default_rng(seed))
    solution = solve(problem, algorithm=algorithm, seed=seed, timeout=20.0)
    check(problem, solution)
    assert len(solution.plan) == 9 and solution.cost < 110.0


DEARER = """
(define (domain dearer)
  (:predicates (Item ?i) (Path ?w) (Way ?i ?w) (Dry ?i ?w) (Done ?i))
  (:functions (total-cost) (Price ?w))
  (:action go
    :parameters (?i ?w)
    :precondition (and (Way ?i ?w) (Dry ?i ?w)) :effect (and (Done ?i) (increase (total-cost) (Price ?w)))))
"""

DEARER_STREAMS = """
(define (stream dearer)
  (:stream find-way :inputs (?i) :domain (Item ?i) :outputs (?w) :certified (and (Path ?w) (Way ?i ?w)))
  (:stream test-dry :inputs (?i ?w) :domain (Way ?i ?w) :certified (Dry ?i ?w))
  (:function (Price ?w) (Path ?w)))
"""


def test_nothing_is_checked_of_what_makes_a_plan_no_cheaper():
    """Eleven of twelve ways were looked at in vain; the one that is cheaper than the first must be."""
    asked = []

    def test_dry(context, item, way):
        asked.append(way)
        return True

    samplers = {
        "find-way": lambda context, item: iter([5.0, 9.0, 8.0, 7.0, 3.0, 9.5, 6.0, 4.0, 5.5, 8.5]),
        "test-dry": test_dry,
        "price": lambda context, way: way,
    }
    problem = Problem(DEARER, DEARER_STREAMS, samplers, [("Item", "a")], ("Done", "a"))
    solution = solve(problem, timeout=20.0)
    assert solution.cost == 3.0
    assert sorted(asked) == [3.0, 5.0]


TRIP = """
(define (domain trip)
  (:predicates (Sort ?s) (Place ?p) (Rest ?s ?p) (Route ?p ?t ?p2) (At ?p) (Seen ?p) (Rested ?s))
  (:functions (Length ?p ?p2))
  (:action go
    :parameters (?p ?t ?p2)
    :precondition (and (Route ?p ?t ?p2) (At ?p))
    :effect (and (At ?p2) (Seen ?p2) (not (At ?p)) (increase (total-cost) (Length ?p ?p2))))
  (:action rest :parameters (?s ?p) :precondition (and (Rest ?s ?p) (At ?p)) :effect (Rested ?s)))
"""
TRIP_STREAMS = """
(define (stream trip)
  (:stream find-rest :inputs (?s) :domain (Sort ?s) :outputs (?p) :certified (and (Place ?p) (Rest ?s ?p)))
  (:stream find-route
    :inputs (?p ?p2) :domain (and (Place ?p) (Place ?p2)) :outputs (?t) :certified (Route ?p ?t ?p2))
  (:function (Length ?p ?p2) (and (Place ?p) (Place ?p2))))
"""


def test_nothing_is_drawn_that_no_price_depends_on_until_the_price_is_known():
    """To know what a trip would cost each of twelve was planned first, there and back: 26 routes."""
    planned = []

    def find_route(context, start, end):
        planned.append((start, end))
        yield f"{start}-{end}"

    samplers = {
        "find-rest": lambda context, sort: iter([5.0, 9.0, 8.0, 7.0, 3.0, 9.5, 6.0, 4.0, 5.5, 8.5, 3.5, 6.5]),
        "find-route": find_route,
        "length": lambda context, start, end: abs(start - end),
    }
    problem = Problem(
        TRIP,
        TRIP_STREAMS,
        samplers,
        [("Sort", "nap"), ("Place", 0.0), ("At", 0.0)],
        ("and", ("Rested", "nap"), ("At", 0.0)),
    )
    solution = solve(problem, timeout=20.0)
    assert solution.cost == 6.0
    assert len(set(planned)) < 12, planned


@pytest.mark.parametrize("algorithm", ["adaptive", "incremental"])
def test_all_choices_of_a_long_plan_have_their_turn(algorithm):
    """Two dozen choices, of which hardly one in two was made anew, cost 146 in the mean."""
    problem = packing(6, (12.0, 3.0), costs=True)
    costs = [solve(problem, algorithm=algorithm, timeout=20.0, seed=seed).cost for seed in (1, 2, 3)]
    assert sum(costs) / len(costs) < 135.0, costs


def test_a_plan_that_was_found_among_real_values_is_improved_on_among_them_first():
    """Under hopes there are always shorter ways, none of which are possible."""
    solution = solve(field(0.25, area=False), algorithm="adaptive", timeout=40.0)
    assert solution.cost < 1.6, solution.cost
