import pytest

from tamp.errors import DomainError, DomainWarning
from tamp.language import (
    Atom,
    Constant,
    FunctionStream,
    PredicateStream,
    Rule,
    Stream,
    StreamFile,
    Variable,
    parse_domain,
    parse_streams,
)
from tests.language.texts import DOMAIN, STREAMS

B, R, P, P1, P2, T = map(Variable, ("?b", "?r", "?p", "?p1", "?p2", "?t"))


@pytest.fixture(scope="module")
def kitchen():
    return parse_streams(STREAMS, parse_domain(DOMAIN))


def test_functions_predicates_and_rules(kitchen):
    pose1, pose2 = Atom("pose", (P1,)), Atom("pose", (P2,))
    assert kitchen.functions == (FunctionStream("distance", (P1, P2), (pose1, pose2)),)
    assert kitchen.predicates == (PredicateStream("collision", (B, P), (Atom("free", (B, P)),)),)
    assert kitchen.rules == (Rule((B, P), (Atom("kin", (B, P)),), (Atom("free", (B, P)), Atom("reachable", (B,)))),)


def test_types_become_facts_and_conjunctions_are_flat(kitchen):
    assert kitchen.streams[0] == Stream(
        name="sample-pose",
        inputs=(B, R),
        domain=(Atom("block", (B,)), Atom("placeable", (B, R))),
        outputs=(P,),
        certified=(Atom("pose", (P,)), Atom("contained", (B, P, R)), Atom("free", (B, P))),
    )
    assert not kitchen.streams[0].is_test


def test_test_streams_wild_streams_and_missing_parts(kitchen):
    _, test, motion, spawn = kitchen.streams
    assert test.is_test
    assert motion == Stream("motion", (P1, P2), (), (T,), (Atom("motion", (P1, T, P2)),), ("atpose", "on"))
    assert (spawn.inputs, spawn.domain, spawn.outputs) == ((), (), (B,))


def test_a_file_of_its_own_needs_no_domain():
    alone = parse_streams("(define (stream s) (:stream t :inputs (?a) :domain (P ?a @sink) :certified (Q ?a)))")
    assert alone.streams[0].domain == (Atom("p", (Variable("?a"), Constant("@sink"))),)


def test_no_streams():
    assert parse_streams(None) == StreamFile("none")
    assert parse_streams("(define (stream empty) ; nothing\n )").streams == ()


def test_constants_of_the_domain_have_its_values():
    domain = parse_domain("(define (domain d) (:constants @sink))", constants={"@sink": 7})
    streams = parse_streams("(define (stream s) (:stream t :inputs (?a) :certified (Q ?a @Sink)))", domain)
    assert streams.streams[0].certified[0].args[1] == Constant(7)


BROKEN = [
    ("(Placeable ?b ?r)", "(Placeable ?b ?s)", r"unbound variable '\?s'"),
    ("(Placeable ?b ?r)", "(not (Placeable ?b ?r))", r"expected a fact such as \(predicate \?x\), found '\(not ...\)'"),
    ("(Placeable ?b ?r)", "(or (Placeable ?b ?r))", "expected a fact"),
    ("(Placeable ?b ?r)", "Placeable", r"expected \(and FACT ...\) or a fact"),
    ("(Placeable ?b ?r)", "(CFree ?b ?r ?r)", "'cfree' takes 4 arguments, found 3"),
    ("(Placeable ?b ?r)", "(Kin ?b ?r ?r)", "'kin' takes 2 arguments, found 3"),
    ("?b - block ?r", "?b - blck ?r", "undeclared type 'blck'; did you mean 'block'"),
    ("?b - block ?r", "?b ?b", r"variable '\?b' is named twice"),
    ("(?p - pose)", "(?b - pose)", r"'\?b' is both input and output of stream 'sample-pose'"),
    ("(?p - pose)", "(?p - (either pose block))", "either"),
    (
        ":certified (block ?b)",
        ":certified (block fridge)",
        "undeclared constant 'fridge'; the constants are: oven, tray",
    ),
    (":fluents", ":fluent", "unknown attribute ':fluent' of stream 'motion'; did you mean ':fluents'"),
    ("(:stream test-cfree", "(:stream sample-pose", "stream 'sample-pose' is defined twice"),
    ("(:stream test-cfree", "(:steam test-cfree", "unknown section ':steam'; did you mean ':stream'"),
    ("(:stream test-cfree", "(:optimizer test-cfree", r"expected \(:variables"),
    ("(:stream test-cfree", "(:stream", "expected the name of a stream, found ':inputs'"),
    ("(Distance ?p1 ?p2)", "(Distance ?p1)", "'distance' takes 2 arguments, found 1"),
    ("(:predicate (Collision ?b ?p) (Free ?b ?p))", "(:predicate Collision)", "expected"),
    ("(stream kitchen)", "(domain kitchen)", r"expected \(stream NAME\)"),
]


@pytest.mark.parametrize(("right", "wrong", "message"), BROKEN)
def test_mistakes_are_named_where_they_stand(right, wrong, message):
    assert right in STREAMS
    with pytest.raises(DomainError, match=r"^stream:\d+:\d+: .*" + message):
        parse_streams(STREAMS.replace(right, wrong, 1), parse_domain(DOMAIN))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (":outputs (?b) :certified (block ?b)", ":outputs (?b)", r"stream:\d+:\d+: stream 'spawn' certifies nothing"),
        (
            "(Contained ?b ?p ?r)",
            "(CFree ?b ?p ?r)",
            r"stream:\d+:\d+: stream 'sample-pose' certifies 'cfree' of 3 arguments, which nothing reads: .* takes 4",
        ),
        (":fluents (AtPose On)", ":fluents (AtPos On)", r"stream:\d+:\d+: undeclared predicate 'atpos'.*'atpose'"),
    ],
)
def test_slips_that_harm_nothing_are_warned_of(old, new, message):
    assert old in STREAMS
    with pytest.warns(DomainWarning, match=message):
        parse_streams(STREAMS.replace(old, new), parse_domain(DOMAIN))


def test_several_files_are_one():
    first = "(define (stream a) (:stream s :inputs (?x) :domain (p ?x) :outputs (?y) :certified (q ?y)))"
    second = "(define (stream b) (:stream t :inputs (?x) :domain (q ?x) :certified (r ?x)) (:function (f ?x) (q ?x)))"
    both = parse_streams([first, second])
    assert [s.name for s in both.streams] == ["s", "t"] and [f.name for f in both.functions] == ["f"]
    assert sorted(s.name for s in both.signatures) == ["p", "q", "r"]
    with pytest.raises(DomainError, match="'s' is defined twice"):
        parse_streams([first, first.replace("stream a", "stream b")])
