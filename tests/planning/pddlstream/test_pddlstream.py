"""Samplers in PDDLStream's form: each wrapper, and a whole stream map."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from itertools import count

import pytest

from tamp.errors import DomainError, DomainWarning, SamplerError
from tamp.planning import (
    Certified,
    Context,
    Problem,
    StreamInfo,
    from_fn,
    from_gen_fn,
    from_list_fn,
    from_list_gen_fn,
    from_sampler,
    from_stream_map,
    from_test,
    solve,
)
from tamp.planning.pddlstream import And, Exists, Not, WildOutput, empty_gen, from_constant, negate_test
from tests.planning.problems import continuous, unsolvable
from tests.planning.test_problems import ALGORITHMS, check


@dataclass
class Wild:
    """What PDDLStream's wild streams yield."""

    values: list
    facts: list


def context(fluents=None):
    return Context(None, lambda: pytest.fail("PDDLStream's samplers know no generator"), 0.0, fluents)


def pairs(x):
    yield (x, 1)
    yield None
    yield [x, 2]


@pytest.mark.parametrize(
    ("sampler", "outputs"),
    [
        (from_gen_fn(pairs), [(7, 1), None, (7, 2)]),
        (from_gen_fn(lambda x: ((i,) for i in range(x - 5))), [0, 1]),
        (from_list_gen_fn(lambda x: iter([[(x,), ((1, 2),)], []])), [7, (1, 2), None]),
        (from_list_fn(lambda x: [(x,), (x + 1,)]), [7, 8]),
        (from_list_fn(lambda x: []), [None]),
        (from_fn(lambda x: (x, x)), [(7, 7)]),
        (from_fn(lambda x: None), [None]),
        (from_sampler(lambda x: (x,), max_attempts=3), [7, 7, 7]),
        (from_sampler(lambda x: None, max_attempts=2), [None, None]),
    ],
)
def test_generators_and_functions(sampler, outputs):
    assert list(sampler(context(), 7)) == outputs


def test_wild_outputs_certify_their_facts_with_each_output():
    wild = [Wild([(1,), (2,)], [["good", 1]]), Wild([], [("nice", 3)]), [(4,)]]
    expected = [Certified(1, (("good", 1),)), Certified(2, (("good", 1),)), Certified(None, (("nice", 3),)), 4]
    assert list(from_list_gen_fn(lambda: iter(wild))(context())) == expected


def test_a_bare_generator_function_yields_lists_and_a_bare_function_its_value():
    bare = from_stream_map({"lists": lambda x: iter([[(x,)], []]), "cost": lambda x: x + 0.5})
    assert list(bare["lists"](context(), 7)) == [7, None]
    assert bare["cost"](context(), 7) == 7.5


@pytest.mark.parametrize(("fluents", "seen"), [(None, "none declared"), ((), ()), ((("on", 1),), (("on", 1),))])
def test_fluents_are_passed_wherever_the_stream_has_them(fluents, seen):
    assert list(from_fn(lambda fluents="none declared": (fluents,))(context(fluents))) == [seen]


DOMAIN = """(define (domain d) (:predicates (Thing ?x) (Made ?x ?y) (Nice ?y) (Dirty ?x) (Done ?x))
  (:action wash :parameters (?x) :precondition (Dirty ?x) :effect (not (Dirty ?x)))
  (:action use :parameters (?x ?y) :precondition (and (Made ?x ?y) (Nice ?y)) :effect (Done ?x)))"""


@pytest.mark.parametrize("algorithm", ["adaptive", "focused", "incremental"])
def test_facts_of_a_wild_stream_make_a_plan_possible(algorithm):
    streams = (
        "(define (stream s) (:wild-stream make :inputs (?x) :domain (Thing ?x) :outputs (?y) :certified (Made ?x ?y)))"
    )
    wild = from_stream_map({"make": lambda x: iter([Wild([(x + "1",), (x + "2",)], [("Nice", x + "2")])])})
    problem = Problem(domain=DOMAIN, streams=streams, samplers=wild, init=[("Thing", "a")], goal=("Done", "a"))
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    assert [action.args for action in solution.plan] == [("a", "a2")], str(solution.report)


@pytest.mark.parametrize("algorithm", ["adaptive", "focused", "incremental"])
@pytest.mark.parametrize("priced", [False, True])
def test_a_stream_is_asked_where_none_of_its_fluents_holds(algorithm, priced):
    """What it gave in the state of the first plan was taken for granted where a cheaper one was looked for."""
    streams = """(define (stream s) (:stream make :inputs (?x) :domain (Thing ?x) :fluents (Dirty) :outputs (?y)
        :certified (and (Made ?x ?y) (Nice ?y))))"""
    clean = from_stream_map({"make": from_fn(lambda x, fluents: None if fluents else ("clean",))})
    init = [("Thing", "a"), ("Dirty", "a")]
    cost = "(and (not (Dirty ?x)) (increase (total-cost) 5))"
    domain = DOMAIN.replace(":effect (not (Dirty ?x))", f":effect {cost}") if priced else DOMAIN
    problem = Problem(domain=domain, streams=streams, samplers=clean, init=init, goal=("Done", "a"))
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    assert [action.name for action in solution.plan] == ["wash", "use"], str(solution.report)


def test_sampling_goes_on_without_end():
    numbers = count()
    outputs = from_sampler(lambda: (next(numbers),))(context())
    assert [next(outputs) for _ in range(50)] == list(range(50))


def test_tests_answer_with_a_bool_and_may_see_fluents():
    empty = from_test(lambda x, fluents=(): [f for f in fluents if f[1] == x])
    assert empty(context(), 1) is False
    assert empty(context([("on", 1)]), 1) is True


@pytest.mark.parametrize(
    "wrapped", [from_fn(lambda x: x), from_gen_fn(lambda x: iter([x])), from_list_fn(lambda x: [x])]
)
def test_an_output_that_is_no_tuple_is_refused(wrapped):
    with pytest.raises(SamplerError, match=r"expected a tuple of outputs such as \(x,\).* found 7"):
        list(wrapped(context(), 7))


@pytest.mark.parametrize("given", [(3, 4), ()])
def test_outputs_that_are_not_one_are_no_value_of_a_stream_that_has_one(given):
    """The tuple itself was taken for the value."""
    samplers = from_stream_map({"sample": from_fn(lambda x: given), "test-good": from_test(lambda x, g: True)})
    with pytest.raises(SamplerError, match=r"'sample': expected .* 1 output \(g\), found"):
        solve(pick(samplers), timeout=5.0)


@pytest.mark.parametrize("algorithm", ["adaptive", "focused", "incremental"])
def test_a_stream_map_works_as_it_is(algorithm):
    line = continuous.line(2)
    lower, upper = line.scene["goal"]
    numbers = count()
    stream_map = {
        "sample-pose": from_gen_fn(lambda b, r: ((lower + 0.5 + 0.37 * i % (upper - lower - 1.0),) for i in numbers)),
        "inverse-kinematics": from_fn(lambda b, p: (p + 1.0,)),
        "plan-motion": from_sampler(lambda q1, q2: ([q1, q2],), max_attempts=1),
        "test-cfree": from_test(continuous.collision_free),
        "distance": lambda q1, q2: float(abs(q1 - q2).sum()),
    }
    domain = continuous.DOMAIN.replace(
        "(not (CanMove)))", "(not (CanMove)) (increase (total-cost) (Distance ?q1 ?q2)))"
    )
    domain = domain.replace("(:action move", "(:functions (Distance ?q1 ?q2)) (:action move")
    function = "(:function (Distance ?q1 ?q2) (and (Conf ?q1) (Conf ?q2)))"
    problem = Problem(
        domain=domain,
        streams=continuous.STREAMS.rstrip()[:-1] + function + ")",
        samplers=from_stream_map(stream_map),
        init=line.init,
        goal=line.goal,
    )
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    assert solution.status == "solved", str(solution.report)
    check(problem, solution)


PICK = """
(define (domain pick)
  (:predicates (thing ?x) (grasp ?x ?g) (good ?g) (held ?x) (bad ?x))
  (:action pick :parameters (?x ?g) :precondition (and (grasp ?x ?g) (good ?g) (not (bad ?x))) :effect (held ?x)))
"""

PICK_STREAMS = """
(define (stream pick)
  (:stream sample :inputs (?x) :domain (thing ?x) :outputs (?g) :certified (grasp ?x ?g))
  (:stream test-good :inputs (?x ?g) :domain (grasp ?x ?g) :certified (good ?g)))
"""

GOAL = Exists(["?x"], And(("held", "?x"), Not(("bad", "?x"))))


def pick(samplers):
    return Problem(domain=PICK, streams=PICK_STREAMS, samplers=samplers, init=[("thing", "cup")], goal=GOAL)


@pytest.mark.parametrize(
    "test",
    [
        from_test(lambda x, g: g == 2),
        from_fn(lambda x, g: () if g == 2 else None),
        from_gen_fn(lambda x, g: iter([()] if g == 2 else [])),
        from_gen_fn(lambda x, g: iter([None, ()] if g == 2 else [None])),
        from_list_fn(lambda x, g: [()] if g == 2 else []),
        from_list_gen_fn(lambda x, g: iter([[], [()]] if g == 2 else [[]])),
    ],
)
def test_a_test_may_be_wrapped_by_anything(test):
    grasps = from_list_fn(lambda x: [(1,), (2,), (3,)])
    solution = solve(pick(from_stream_map({"sample": grasps, "test-good": test})))
    assert [action.args for action in solution.plan] == [("cup", 2)]


def fails(x):
    return 1 / 0


def fails_later(x):
    yield None
    yield (1 / 0,)


def gives(x):
    return 3.0


@pytest.mark.parametrize(
    ("sampler", "message"),
    [
        (
            from_fn(fails),
            rf"ZeroDivisionError: division by zero for \(cup\): {__name__}:fails at .*test_pddlstream.py:",
        ),
        (from_sampler(fails, max_attempts=2), rf"ZeroDivisionError.*: {__name__}:fails at .*test_pddlstream.py:"),
        (from_gen_fn(fails_later), rf"ZeroDivisionError.*: {__name__}:fails_later at .*test_pddlstream.py:"),
        (from_list_fn(partial(fails)), rf"ZeroDivisionError.*: {__name__}:fails at .*test_pddlstream.py:"),
        (from_fn(gives), rf"stream 'sample': expected a tuple .* found 3.0: {__name__}:gives at .*test_pddlstream.py:"),
        (
            from_gen_fn(gives),
            rf"stream 'sample': expected a generator .* 3.0: {__name__}:gives at .*test_pddlstream.py:",
        ),
        (
            from_list_fn(gives),
            rf"stream 'sample': expected a list of .* 3.0: {__name__}:gives at .*test_pddlstream.py:",
        ),
    ],
)
def test_messages_name_the_function_that_was_wrapped(sampler, message):
    with pytest.raises(SamplerError, match=message):
        solve(pick({"sample": sampler, "test-good": from_test(lambda x, g: True)}))


@pytest.mark.parametrize("test", [from_test(lambda x, g: 1 / 0), from_test(negate_test(lambda x, g: 1 / 0))])
def test_messages_name_the_test_that_was_wrapped(test):
    with pytest.raises(
        SamplerError, match=r"stream 'test-good' raised ZeroDivisionError.*<lambda> at .*pddlstream.py:"
    ):
        solve(pick(from_stream_map({"sample": from_constant((1,)), "test-good": test})))


def test_messages_name_the_function_of_a_cost():
    domain = """(define (domain d) (:predicates (on) (p ?x)) (:functions (total-cost) (f ?x))
      (:action a :parameters (?x) :precondition (p ?x) :effect (and (on) (increase (total-cost) (f ?x)))))"""
    streams = "(define (stream s) (:function (f ?x) (p ?x)))"
    problem = Problem(domain, streams, from_stream_map({"f": lambda x: None}), [("p", 1)], ("on",))
    with pytest.raises(SamplerError, match=r"function 'f': .*, found None: .*<lambda> at .*test_pddlstream.py:\d+"):
        solve(problem, max_cost=5.0)


def test_names_that_are_no_streams_are_ignored_with_a_warning():
    grasps = {"sample": from_constant((1,)), "test-good": from_test(lambda x, g: True)}
    with pytest.warns(DomainWarning, match="'sampel', which is no stream and is ignored.*'sample'"):
        assert solve(pick(from_stream_map(grasps | {"sampel": empty_gen()}))).solved
    with pytest.raises(SamplerError, match="unknown stream 'sampel'"):
        pick(grasps | {"sampel": lambda context, x: iter(())})


@pytest.mark.parametrize("name", ["debug", "shared-debug"])
@pytest.mark.parametrize("given", [str, from_stream_map])
def test_a_domain_can_be_tried_without_samplers(name, given):
    solution = solve(pick(given(name)))
    assert [(a.name, a.args[0], str(a.args[1])) for a in solution.plan] == [("pick", "cup", "g0")]
    assert solution.plan[0].args[1].inputs == (() if "shared" in name else ("cup",))
    with pytest.raises(SamplerError, match="expected a mapping, 'debug' or 'shared-debug', found 'debgu'"):
        pick("debgu")


def test_no_outputs_and_the_same_outputs():
    assert list(empty_gen()(context(), 1)) == []
    assert list(from_constant((1, 2))(context(), "any")) == [(1, 2)]


def test_wild_outputs_of_our_own():
    wild = from_list_gen_fn(lambda: iter([WildOutput([(1,)], [("good", 1)])]))
    assert list(wild(context())) == [Certified(1, (("good", 1),))]


def test_attempts_that_are_counted_prove_nothing():
    grasps = from_sampler(lambda thing: (1,), max_attempts=3)
    samplers = {"sample-grasp": grasps, "inverse-kinematics": empty_gen()}
    problem = unsolvable._reach(*samplers.values(), ("Held", "cup"))
    assert solve(problem).status == "failed"
    assert "it was asked 3 times" in str(solve(problem).report)


def test_options_of_streams_have_their_names_of_there():
    with pytest.warns(DomainWarning, match="opt_gen_fn"):
        info = StreamInfo(p_success=0, overhead=3.0, opt_gen_fn=empty_gen(), negate=True, verbose=False)
    assert (info.cost, info.p_success) == (3.0, 0)
    with pytest.raises(DomainError, match="cost must be 0 or more and finite, found -1"):
        StreamInfo(overhead=-1)


@pytest.mark.parametrize("wrap", [from_fn, lambda f: from_gen_fn(lambda x: iter([f(x)]))])
def test_wild_outputs_may_come_one_by_one(wrap):
    stream = "(define (stream s) (:wild-stream grow :inputs (?x) :domain (p ?x) :outputs (?y) :certified (p ?y)))"
    domain = "(define (domain d) (:predicates (p ?x) (good ?x) (done)) (:action go :parameters (?x) "
    domain += ":precondition (good ?x) :effect (done)))"
    grow = wrap(lambda x: WildOutput([(x + 1,)], [("good", x + 1)] if x == 3 else []))
    solution = solve(Problem(domain, stream, from_stream_map({"grow": grow}), [("p", 0)], ("done",)), timeout=20.0)
    assert [(action.name, *action.args) for action in solution.plan] == [("go", 4)]


ENDLESS = """
(define (stream endless)
  (:wild-stream go-on :inputs (?x) :domain (place ?x)))
"""
STEPS = """
(define (domain endless)
  (:predicates (place ?x) (step ?x ?y) (at ?x) (goal ?x) (there))
  (:action go :parameters (?x ?y) :precondition (and (step ?x ?y) (at ?x)) :effect (and (at ?y) (not (at ?x))))
  (:derived (there) (exists (?x) (and (goal ?x) (at ?x)))))
"""


@pytest.mark.filterwarnings("ignore:.*certifies nothing")
@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_wild_tests_bring_no_more_than_one_step_a_round(algorithm):
    """What each of them brings is asked as well, without end."""
    go_on = from_list_fn(lambda x: WildOutput(facts=[("place", x + 1), ("step", x, x + 1)] + [("goal", x)] * (x == 3)))
    problem = Problem(STEPS, ENDLESS, from_stream_map({"go-on": go_on}), [("place", 0), ("at", 0)], ("there",))
    solution = solve(problem, algorithm=algorithm, max_iterations=60, timeout=20.0)
    assert [action.args for action in solution.plan] == [(0, 1), (1, 2), (2, 3)]


CHAIN = """
(define (stream chain)
  (:stream follow
    :inputs (?x) :domain (place ?x) :outputs (?y) :certified (and (place ?y) (step ?x ?y))))
"""


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_a_goal_at_the_end_of_a_long_chain(algorithm):
    """Optimistic facts beyond the values so far are few: each is followed by a search."""
    samplers = {"follow": lambda context, x: iter([x + 1])}
    problem = Problem(STEPS, CHAIN, samplers, [("place", 0), ("at", 0)], ("at", 45))
    solution = solve(problem, algorithm=algorithm, max_iterations=200, timeout=20.0)
    assert len(solution.plan) == 45


TRAY = """
(define (domain tray)
  (:predicates (Cup ?c) (Load ?c ?t) (Level ?t) (Served ?c))
  (:action serve :parameters (?c ?t) :precondition (and (Load ?c ?t) (Level ?t)) :effect (Served ?c)))
"""

TRAY_STREAMS = """
(define (stream tray)
  (:stream load :inputs (?c) :domain (Cup ?c) :outputs (?t) :certified (Load ?c ?t))
  (:stream test-level :inputs (?c ?t) :domain (Load ?c ?t) :certified (Level ?t)))
"""


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("start", [{"at": 0}, [0], {0}, [[0]]])
def test_one_container_may_be_yielded_again_with_something_else_in_it(start, algorithm):
    """All of it was one value, which was whatever came last."""

    def load(cup):
        tray, number = type(start)(start), 0
        inner = tray[0] if isinstance(tray, list) and isinstance(tray[0], list) else None
        while True:
            number += 1
            if isinstance(tray, dict):
                tray["at"] = number
            elif isinstance(tray, set):
                tray.clear()
                tray.add(number)
            elif inner is not None:
                inner[0] = number
            else:
                tray[0] = number
            yield (tray,)

    def number_of(tray):
        inside = next(iter(tray.values() if isinstance(tray, dict) else tray))
        return inside[0] if isinstance(inside, list) else inside

    stream_map = {"load": from_gen_fn(load), "test-level": from_test(lambda cup, tray: number_of(tray) == 4)}
    problem = Problem(TRAY, TRAY_STREAMS, from_stream_map(stream_map), [("Cup", "c")], ("Served", "c"))
    solution = solve(problem, algorithm=algorithm, timeout=10.0)
    assert solution.status == "solved", str(solution.report)
    assert number_of(solution.plan[0].args[1]) == 4
