"""Wild streams that bring more objects than there is time to call streams for: who is called first."""

from __future__ import annotations

import pytest

from benchmarks.pddlstream.roads import visits
from tamp.planning import Certified, Problem, solve
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.objects import Objects
from tamp.planning.model.schema import Schema
from tamp.planning.model.turns import Turns

DOMAIN = """
(define (domain net)
  (:predicates (place ?x) (road ?x ?t ?y) (at ?x))
  (:action go
    :parameters (?x ?t ?y) :precondition (and (road ?x ?t ?y) (at ?x)) :effect (and (at ?y) (not (at ?x)))))
"""
STREAMS = """
(define (stream net)
  (:stream sample :outputs (?x) :certified (place ?x))
  (:wild-stream connect
    :inputs (?x ?y) :domain (and (place ?x) (place ?y)) :outputs (?t) :certified (road ?x ?t ?y)))
"""


@pytest.mark.parametrize("algorithm", ["adaptive", "focused", "incremental"])
def test_values_are_connected_by_roadmaps_whose_vertices_need_not_be_connected(algorithm):
    """Thousands of pairs of vertices were called for, in the order in which these had appeared, until time was up."""
    solution = solve(visits(3, vertices=30), algorithm=algorithm, timeout=30.0)
    assert solution.status == "solved"
    assert next(s.calls for s in solution.report.streams if s.name == "connect") <= 60


def net(vertices: int) -> tuple[Knowledge, Turns]:
    """Two values of "sample", a roadmap between them, and an instance of "connect" for each pair of its vertices."""
    samplers = {"sample": lambda context: iter(()), "connect": lambda context, x, y: iter(())}
    schema = Schema(Problem(DOMAIN, STREAMS, samplers, [("place", "home")], ("at", "home")), objects := Objects())
    knowledge = Knowledge(schema, objects)
    sample, connect = schema.externals["sample"], schema.externals["connect"]
    values = [objects.intern(f"value {i}") for i in range(2)]
    source = knowledge.instance(sample, ())
    for value in values:
        knowledge.record(source, (value,))
    first = knowledge.instance(connect, (values[0], values[0]))
    points = [objects.intern(f"vertex {i}") for i in range(vertices)]
    knowledge.bringers |= dict.fromkeys(points, first)
    for a in points:
        for b in points:
            knowledge.instance(connect, (a, b))
    knowledge.instance(connect, (values[0], values[1]))
    return knowledge, Turns(knowledge)


def test_what_there_is_little_of_comes_before_what_there_is_plenty_of():
    knowledge, turns = net(vertices=20)
    order = turns.in_turn(knowledge.instances())
    assert sorted(map(id, order)) == sorted(map(id, knowledge.instances()))
    kinds = [(i.external.name, *(knowledge.objects.value(h)[:5] for h in i.inputs)) for i in order[:4]]
    assert kinds.index(("connect", "value", "value")) < 3
    assert kinds.count(("connect", "verte", "verte")) <= 1


def test_everything_has_its_turn():
    """However many calls there are of the few, each of which could be called again."""
    knowledge, turns = net(vertices=5)
    waiting = set(knowledge.instances())
    for _ in range(40):
        for instance in turns.in_turn(knowledge.instances())[:3]:
            instance.calls += 1
            waiting.discard(instance)
    assert not waiting


def test_facts_of_a_kind_wait_for_those_of_others():
    knowledge, turns = net(vertices=20)
    place = {knowledge.objects.value(h): ("place", h) for h in range(len(knowledge.objects))}
    vertices = [turns.of_fact(place[f"vertex {i}"]) for i in range(20)]
    assert vertices == sorted(set(vertices))
    assert turns.of_fact(place["value 0"]) < vertices[1]


def test_streams_that_rounds_come_to_are_not_all_called_at_once():
    """After four rounds everything was called that might bring more than it promises."""
    calls = []

    def connect(context, x, y):
        calls.append((x, y))
        yield Certified(None, tuple(("place", f"{x}, {y}, {i}") for i in range(20)))

    samplers = {"sample": lambda context: iter(range(1000)), "connect": connect}
    problem = Problem(DOMAIN, STREAMS, samplers, [("place", "home"), ("at", "home"), ("place", "away")], ("at", "away"))
    solve(problem, algorithm="incremental", max_iterations=7, timeout=20.0)
    assert len(calls) <= 200
