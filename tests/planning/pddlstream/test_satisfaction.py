"""Values for variables such that facts hold of them, and what PDDLStream's scripts use around a call."""

import numpy as np
import pytest

from tamp.errors import DomainError
from tamp.planning import pddlstream
from tamp.planning.pddlstream import (
    Equal,
    Minimize,
    Not,
    Or,
    Profiler,
    constraint_satisfaction,
    create_parser,
    dump_assignment,
    find_unique,
    from_gen_fn,
    from_test,
    get_args,
    get_file_path,
    get_length,
    get_prefix,
    implies,
    inclusive_range,
    irange,
    is_plan,
    randomize,
    read,
    solve_pddlstream_satisfaction,
    str_from_plan,
)

STREAMS = """
(define (stream places)
  (:stream place :inputs (?b) :domain (Block ?b) :outputs (?p) :certified (Pose ?b ?p))
  (:stream test-apart
    :inputs (?b1 ?p1 ?b2 ?p2) :domain (and (Pose ?b1 ?p1) (Pose ?b2 ?p2)) :certified (Apart ?b1 ?p1 ?b2 ?p2))
  (:function (Far ?b ?p) (Pose ?b ?p)))
"""
STREAM_MAP = {
    "place": from_gen_fn(lambda block: ((float(x),) for x in range(6))),
    "test-apart": from_test(lambda b1, p1, b2, p2: abs(p1 - p2) >= 2.0),
    "far": lambda block, pose: pose + 1.0,
}
BLOCKS = {"a": np.zeros(2), "b": np.ones(2)}
INIT = [("Block", block) for block in BLOCKS.values()]


def terms(*more):
    a, b = BLOCKS.values()
    return [("Pose", a, "?p"), ("Pose", b, "?Q"), ("Apart", a, "?p", b, "?Q"), *more]


@pytest.mark.parametrize("incremental", [False, True])
def test_values_that_satisfy_everything(incremental):
    found = solve_pddlstream_satisfaction(STREAMS, STREAM_MAP, INIT, terms(), incremental, timeout=20.0)
    assert abs(found.bindings["?p"] - found.bindings["?q"]) >= 2.0


def test_the_cheapest_values():
    a, b = BLOCKS.values()
    costs = Minimize(("Far", a, "?p")), Minimize(("Far", b, "?q"))
    bindings, cost, _ = constraint_satisfaction(
        STREAMS, STREAM_MAP, INIT, terms(*costs), success_cost=0.0, timeout=20.0
    )
    assert (sorted(bindings.values()), cost) == ([0.0, 2.0], 4.0)


def test_formulas_and_values_of_ones_own():
    more = Or(Equal("?p", 5.0), Equal("?q", 5.0)), Not(Equal("?p", 5.0))
    found = constraint_satisfaction(STREAMS, STREAM_MAP, INIT, terms(*more), timeout=20.0)
    assert found.bindings["?q"] == 5.0


def test_what_cannot_be_satisfied(capsys):
    a = BLOCKS["a"]
    found = constraint_satisfaction(STREAMS, STREAM_MAP, INIT, terms(("Apart", a, "?p", a, "?p")), timeout=20.0)
    dump_assignment(found)
    assert found.bindings is None and capsys.readouterr().out == "Solved: False\nCost: inf\n"
    dump_assignment(constraint_satisfaction(STREAMS, STREAM_MAP, INIT, terms()[:1], timeout=20.0))
    assert "?p = 0.0" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("term", "sentence"),
    [
        ("Pose", "expected a term such as"),
        (("Pose", "a", "?p) (x"), r"expected a variable such as '\?p', found '\?p\) \(x'"),
        (("minimize",), "expected Minimize"),
        (Minimize(Not(("Far", "a", "?p"))), "expected Minimize"),
        (Minimize(("Pose", "a", "?p")), "'pose' is a predicate in one term and minimised in another"),
    ],
)
def test_terms_that_cannot_be_read(term, sentence):
    with pytest.raises(DomainError, match=sentence):
        constraint_satisfaction(STREAMS, STREAM_MAP, INIT, terms(term))


def test_what_scripts_use_around_a_call(tmp_path, capsys):
    parser = create_parser()
    parser.add_argument("-u", "--upper")
    args = parser.parse_args(["-a", "abstract_focused", "-u", "3"])
    assert (args.algorithm, args.unit, args.upper) == ("abstract_focused", False, "3")
    (tmp_path / "domain.pddl").write_text("(define)", encoding="utf-8")
    assert read(get_file_path(tmp_path / "run.py", "domain.pddl")) == "(define)"
    with Profiler(num=3):
        sum(range(10))
    assert "tottime" in capsys.readouterr().out
    plan = [("pick", ("a", 1))]
    assert (str_from_plan(plan), str_from_plan(None)) == ("[pick(a, 1)]", "None")
    assert (is_plan(plan), is_plan(None), get_length(plan), get_length(None)) == (True, False, 1, float("inf"))
    assert (list(irange(2)), inclusive_range(0, 1, 0.4), inclusive_range(1, 1)) == ([0, 1], [0, 0.4, 0.8, 1], [])
    assert find_unique(lambda number: number > 2, [1, 2, 3]) == 3
    with pytest.raises(RuntimeError, match="holds for 2 elements"):
        find_unique(lambda number: number > 1, [1, 2, 3])
    assert (implies(False, False), implies(True, False), sorted(randomize([2, 1]))) == (True, False, [1, 2])
    assert (get_prefix(("Pose", "a")), get_args(("Pose", "a"))) == ("pose", ("a",))


def test_what_scripts_use_around_files_and_times(tmp_path):
    folder = tmp_path / "pictures"
    pddlstream.ensure_dir(folder / "first.png")
    pddlstream.write(folder / "domain.pddl", "(define)")
    pddlstream.write(folder / "stream.pddl", "(define streams)")
    assert pddlstream.read_pddlstream_pair(folder / "run.py") == ["(define)", "(define streams)"]
    pddlstream.safe_rm_dir(folder)
    pddlstream.safe_rm_dir(folder)
    assert not folder.exists()
    plan = pddlstream.retime_plan([("pick", ("a", 1)), ("place", ("a",))], duration=2.0)
    assert [(*action,) for action in plan] == [("pick", ("a", 1), 0.0, 2.0), ("place", ("a",), 2.0, 2.0)]
    assert (pddlstream.get_end(plan[0]), pddlstream.compute_duration(plan)) == (2.0, 4.0)
    assert (pddlstream.retime_plan(None), pddlstream.compute_duration(None)) == (None, 0.0)
    assert pddlstream.get_mapping("ab", [1, 2]) == {"a": 1, "b": 2}
    with pytest.raises(ValueError, match="shorter"):
        pddlstream.get_mapping("ab", [1])
    assert (pddlstream.find(lambda x: x > 1, [1, 2, 3]), pddlstream.find(bool, [])) == (2, None)
    assert (pddlstream.str_eq("Pose", "pose"), pddlstream.str_eq("Pose", "pose", ignore_case=False)) == (True, False)
    assert pddlstream.sorted_str_from_list([2, 1]) == "[1, 2]"
    pddlstream.set_cost_scale(10.0)
    assert pddlstream.MAX_FD_COST / pddlstream.get_cost_scale() == 1e5


def test_a_problem_of_values_may_be_given_as_one():
    problem = pddlstream.SatisfactionProblem(STREAMS, STREAM_MAP, INIT, terms())
    assert constraint_satisfaction(problem, costs=False)[0] is not None
    assert solve_pddlstream_satisfaction(problem, incremental=True)[0] is not None
