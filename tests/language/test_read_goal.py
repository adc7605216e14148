import contextlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tamp.errors import DomainError
from tamp.language import (
    TRUE,
    And,
    Atom,
    Constant,
    Equal,
    Exists,
    Forall,
    FunctionTerm,
    Not,
    Or,
    Parameter,
    Variable,
    atoms,
    parse_domain,
    parse_goal,
    parse_init,
    parse_streams,
)
from tests.language.texts import DOMAIN

P = Variable("?p")


@pytest.fixture(scope="module")
def domain():
    return parse_domain(DOMAIN)


def test_operators_nest_in_lists_and_tuples(domain):
    goal = ["AND", ("HandEmpty",), ("or", ["on", "a", "b"], ("NOT", ("Holding", "a"))), ("=", "a", 1)]
    a, b = Constant("a"), Constant("b")
    assert parse_goal(goal, domain) == And(
        (Atom("handempty", ()), Or((Atom("on", (a, b)), Not(Atom("holding", (a,))))), Equal(a, Constant(1)))
    )


def test_quantifiers_and_types(domain):
    exists = parse_goal(("exists", ("?p",), ("AtPose", "a", "?p")), domain)
    assert exists == Exists((Parameter(P),), Atom("atpose", (Constant("a"), P)))
    forall = parse_goal(("forall", ["?p - pose", "?x", "-", "block"], ("AtPose", "?x", "?P")), domain)
    assert [parameter.types for parameter in forall.parameters] == [("pose",), ("block",)]
    assert isinstance(forall, Forall) and forall.body.args[1] == P


def test_imply(domain):
    assert parse_goal(("imply", ("HandEmpty",), ("Holding", 1)), domain) == Or(
        (Not(Atom("handempty", ())), Atom("holding", (Constant(1),)))
    )


def test_nothing_to_do(domain):
    assert parse_goal(None, domain) == parse_goal((), domain) == parse_goal(("and",), domain) == TRUE


def test_arguments_are_any_values(domain):
    pose = (0.5, ("and",))
    array = np.zeros(3)
    goal = parse_goal(("and", ("AtPose", "a", pose), ("AtPose", "a", array)), domain)
    assert goal.parts[0].args[1].value is pose
    assert goal.parts[1].args[1].value is array


def test_a_text_that_spells_a_constant_is_it(domain):
    assert parse_goal(("On", "OVEN", "Tray"), domain).args == (domain.constants["oven"], domain.constants["tray"])


@pytest.mark.parametrize(
    ("goal", "message"),
    [
        ("HandEmpty", r"a fact without arguments is \('HandEmpty',\)"),
        (("Handempy",), "undeclared predicate 'handempy'; did you mean 'handempty'"),
        (("Holding", "a", "b"), "'holding' takes 1 argument, found 2"),
        (("Holding", "?x"), r"unbound variable '\?x'"),
        (("exists", ("?x"), ("Holding", "?x")), r"expected variables such as \('\?x', '\?y'\)"),
        (("exists", ("x",), ("Holding", "?x")), r"expected a variable such as \?x, found 'x'"),
        (("exists", ("?x - blok",), ("Holding", "?x")), "undeclared type 'blok'"),
        (("exists", ("?x",)), r"expected \(exists \(\?variable ...\) FORMULA\), found 1 operands"),
        (("not", ("HandEmpty",), ("HandEmpty",)), r"expected \(not FORMULA\)"),
        (("and", "HandEmpty"), r"a fact without arguments is \('HandEmpty',\)"),
        ((("HandEmpty",),), "a tuple begins with the name of a predicate or operator"),
        (5, "expected a tuple such as"),
        (("when", 1, 2), "expected a fact"),
    ],
)
def test_mistakes(domain, goal, message):
    with pytest.raises(DomainError, match="^goal: .*" + message):
        parse_goal(goal, domain)


def test_predicates_that_only_the_stream_file_names(domain):
    streams = parse_streams(
        "(define (stream s) (:predicate (Near ?a ?b)) (:stream confs :outputs (?q) :certified (BConf ?q)))", domain
    )
    assert [s.name for s in streams.signatures] == ["near", "bconf"]
    goal = ("exists", ("?q",), ("and", ("BConf", "?q"), ("Near", "?q", 1)))
    assert [atom.predicate for atom in atoms(parse_goal(goal, domain, streams))] == ["bconf", "near"]
    assert parse_init([("BConf", 1)], domain, streams).facts[0].predicate == "bconf"
    with pytest.raises(DomainError, match=r"^goal: .*undeclared predicate 'bconf'"):
        parse_goal(goal, domain)
    for parse in (
        lambda: parse_goal(("BConf", 1, 2), domain, streams),
        lambda: parse_init([("Near", 1)], domain, streams),
    ):
        with pytest.raises(DomainError, match=r"takes [12] arguments?, found [12]"):
            parse()


def test_depth_is_limited(domain):
    goal = ("HandEmpty",)
    for _ in range(100_000):
        goal = ("not", goal)
    with pytest.raises(DomainError, match="nested deeper than"):
        parse_goal(goal, domain)
    while len(goal) == 2:  # Taken apart by hand: freeing it in one go would overflow the interpreter's stack.
        goal = goal[1]


NOISE = st.recursive(
    st.none()
    | st.integers()
    | st.sampled_from(["And", "not", "=", "exists", "?x", "Holding", "On", "a", "-", "", "("]),
    lambda inner: st.lists(inner, max_size=4).map(tuple) | st.lists(inner, max_size=4),
    max_leaves=12,
)


@given(NOISE)
def test_noise_gives_domain_errors_only(goal):
    domain = parse_domain(DOMAIN)
    for parse in (lambda: parse_goal(goal, domain), lambda: parse_init([goal], domain)):
        with contextlib.suppress(DomainError):
            parse()


def test_facts_and_values(domain):
    state = parse_init(
        [("AtPose", "a", 1), ["HANDEMPTY"], ("Stable", "a"), ("AtPose", "a", 1), ("=", ("Distance", 1, 2), 3)], domain
    )
    assert state.facts == (
        Atom("atpose", (Constant("a"), Constant(1))),
        Atom("handempty", ()),
        Atom("stable", (Constant("a"),)),
    )
    assert state.values == {FunctionTerm("distance", (Constant(1), Constant(2))): 3.0}


def test_negated_facts_are_kept_apart(domain):
    state = parse_init([("not", ("CFree", 1, 2, 3, 4))], domain)
    assert (state.facts, len(state.negated)) == ((), 1)


@pytest.mark.parametrize(
    ("fact", "message"),
    [
        ("HandEmpty", r"a fact without arguments is \('HandEmpty',\)"),
        (("AtPose", "a"), "'atpose' takes 2 arguments, found 1"),
        (("=", ("Distance", 1), 2), "'distance' takes 2 arguments, found 1"),
        (("=", ("Distance", 1, 2), -1), "expected a value of 0 or more, found -1"),
        (("=", ("Distance", 1, 2), "far"), "expected a value of 0 or more, found 'far'"),
        (("and", ("HandEmpty",)), "expected a fact"),
        (("Holding", "?x"), r"unbound variable '\?x'"),
        ((), "expected a fact"),
        (7, "expected a tuple"),
    ],
)
def test_mistakes_in_facts(domain, fact, message):
    with pytest.raises(DomainError, match="^init: .*" + message):
        parse_init([fact], domain)


def test_init_is_a_list(domain):
    with pytest.raises(DomainError, match="expected a list of facts"):
        parse_init("HandEmpty", domain)
