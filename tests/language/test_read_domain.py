import pytest

from tamp.errors import DomainError, DomainWarning
from tamp.language import (
    And,
    Atom,
    Constant,
    Effect,
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
    type_conditions,
)
from tests.language.texts import DOMAIN

B, P, B2, P2 = map(Variable, ("?b", "?p", "?b2", "?p2"))


@pytest.fixture(scope="module")
def kitchen():
    return parse_domain(DOMAIN)


def test_names_are_lower_case(kitchen):
    assert kitchen.name == "kitchen"
    assert list(kitchen.actions) == ["place", "wait"]
    assert kitchen.requirements == (":adl", ":typing", ":derived-predicates", ":action-costs")


def test_types_form_a_hierarchy_below_object(kitchen):
    assert kitchen.types["stove"] == ("region",)
    assert kitchen.types["pose"] == ("object",)
    assert kitchen.supertypes("stove") == ("region", "physical", "object")
    assert kitchen.supertypes("object") == ()
    assert kitchen.predicates["stove"].arity == 1


def test_constants_have_types_and_values(kitchen):
    assert kitchen.constant_types == {"oven": ("stove",), "tray": ("object",)}
    assert kitchen.constants["oven"] == Constant("oven")
    assert kitchen.constant("OVEN") == Constant("oven")
    assert kitchen.constant("Mug") == Constant("Mug")


def test_constants_can_be_given_values():
    stove = object()
    domain = parse_domain(DOMAIN, constants={"Oven": stove})
    when = domain.actions["place"].effects[3].condition
    assert when == Atom("on", (B, Constant(stove)))


def test_a_value_for_an_unknown_constant_is_refused():
    with pytest.raises(DomainError, match="undeclared constant 'ovem'; did you mean 'oven'"):
        parse_domain(DOMAIN, constants={"ovem": 1})


def test_declarations(kitchen):
    assert kitchen.predicates["atpose"].parameters == (Parameter(B, ("block",)), Parameter(P, ("pose",)))
    assert kitchen.functions["distance"].arity == 2
    assert "total-cost" not in kitchen.functions
    assert kitchen.uses_costs
    assert kitchen.derived == {"above", "unsafe"}
    assert kitchen.fluents == {"atpose", "handempty", "holding", "cooked", "on"}


def test_precondition(kitchen):
    condition = kitchen.actions["place"].precondition
    assert condition == And(
        (
            Atom("holding", (B,)),
            Not(Atom("unsafe", (B, P))),
            Forall(
                (Parameter(B2, ("block",)), Parameter(P2, ("pose",))),
                Or((Not(Atom("atpose", (B2, P2))), Or((Equal(B, B2), Atom("cfree", (B, P, B2, P2)))))),
            ),
        )
    )
    assert [atom.predicate for atom in atoms(condition)] == ["holding", "unsafe", "atpose", "cfree"]


def test_effects_are_conditional_literals(kitchen):
    other = Variable("?o")
    quantified = (Parameter(other, ("block",)),)
    on = Atom("on", (other, B))
    assert kitchen.actions["place"].effects == (
        Effect(Atom("atpose", (B, P))),
        Effect(Atom("handempty", ())),
        Effect(Atom("holding", (B,)), positive=False),
        Effect(Atom("cooked", (B,)), condition=Atom("on", (B, Constant("oven")))),
        Effect(Atom("cooked", (other,)), True, quantified, on),
        Effect(Atom("on", (other, Constant("tray"))), False, quantified, on),
    )


def test_cost_is_a_sum(kitchen):
    assert kitchen.actions["place"].cost == (2.0, FunctionTerm("distance", (P, P)))
    assert kitchen.actions["wait"].cost is None
    assert kitchen.actions["wait"].precondition == And(())


def test_axioms_may_be_recursive(kitchen):
    above = kitchen.axioms[0]
    assert above.predicate == "above"
    assert isinstance(above.condition, Or) and isinstance(above.condition.parts[1], Exists)


def test_types_as_conditions():
    either = Parameter(B, ("block", "region"))
    assert type_conditions((Parameter(P), Parameter(P, ("pose",)), either)) == (
        Atom("pose", (P,)),
        Or((Atom("block", (B,)), Atom("region", (B,)))),
    )


def test_no_variable_is_bound_twice():
    domain = parse_domain(
        "(define (domain d) (:predicates (p ?x) (q)) (:derived (q) (exists (?x) (and (p ?x) (forall (?x) (p ?x))))))"
    )
    outer = domain.axioms[0].condition
    inner = outer.body.parts[1]
    assert outer.parameters[0].variable != inner.parameters[0].variable
    assert inner.body == Atom("p", (inner.parameters[0].variable,))


def test_sections_in_any_order_and_repeated():
    domain = parse_domain(
        "(define (domain d) (:action a :effect (p)) (:derived (q) (p)) (:predicates (p)) (:predicates (q) (p)))"
    )
    assert domain.derived == {"q"}


def test_undeclared_functions_declare_themselves():
    domain = parse_domain("(define (domain d) (:action a :parameters (?x) :effect (increase (total-cost) (f ?x))))")
    assert domain.functions["f"].arity == 1


def test_identical_is_equality():
    domain = parse_domain("(define (domain d) (:predicates (q)) (:derived (q) (exists (?x) (identical ?x ?x))))")
    assert domain.axioms[0].condition.body == Equal(Variable("?x"), Variable("?x"))


def test_an_unbound_variable_of_an_axiom_is_let_pass_with_a_warning():
    axiom = "(:derived (r) (exists (?item) (and (p ?item) (q ?itme))))"
    text = f"(define (domain d) (:predicates (p ?x) (q ?x) (r))\n{axiom})"
    with pytest.warns(DomainWarning, match=r"domain:2:49: unbound variable '\?itme'; did you mean '\?item'.*no fact"):
        domain = parse_domain(text)
    assert str(domain.axioms[0].condition.body.parts[1].args[0].value) == "?itme"


def test_axioms_as_in_pddl_1_2():
    text = "(define (domain d) (:types box) (:predicates (on ?x ?y) (clear ?x) (full ?x))"
    old = "(:axiom :vars (?y - box ?x) :context (on ?x ?y) :implies (full ?y))"
    old += "(:axiom :parameters (?x) :context (not (full ?x)) :implies (clear ?x)))"
    new = "(:derived (full ?y - box) (exists (?x) (on ?x ?y))) (:derived (clear ?x) (not (full ?x))))"
    assert parse_domain(text + old) == parse_domain(text + new)
    with pytest.raises(DomainError, match=r"unbound variable '\?z'"):
        parse_domain(text + "(:axiom :vars (?x) :context (on ?x ?x) :implies (full ?z)))")
    with pytest.raises(DomainError, match=r"expected \(:axiom"):
        parse_domain(text + "(:axiom :vars (?x) :context (on ?x ?x)))")


def test_files_are_read_by_path(tmp_path):
    path = tmp_path / "domain.pddl"
    path.write_text(DOMAIN, encoding="utf-8")
    assert parse_domain(path) == parse_domain(str(path)) == parse_domain(DOMAIN)


BROKEN = [
    ("(not (Unsafe ?b ?p))", "(not (Unsave ?b ?p))", "undeclared predicate 'unsave'; did you mean 'unsafe'"),
    ("(not (Unsafe ?b ?p))", "(not (Unsafe ?b))", "'unsafe' takes 2 arguments, found 1"),
    ("(not (Unsafe ?b ?p))", "(not (Unsafe ?b ?q))", r"unbound variable '\?q'"),
    ("(not (Unsafe ?b ?p))", "(not (Unsafe ?b ?p) (HandEmpty))", r"expected \(not FORMULA\), found 2 operands"),
    ("(not (Unsafe ?b ?p))", "Unsafe", "expected a formula such as"),
    ("?b - block ?p - pose ?r", "?b - blok ?p - pose ?r", "undeclared type 'blok'; did you mean 'block'"),
    ("?b - block ?p - pose ?r", "?b - block ?b - pose ?r", r"variable '\?b' is named twice"),
    ("?b - block ?p - pose ?r", "?b - block p - pose ?r", r"expected a variable such as \?x, found 'p'"),
    ("?b - block ?p - pose ?r", "- block ?p - pose ?r", "expected names before '-'"),
    ("(On ?b oven)", "(On ?b ovn)", "undeclared constant 'ovn'; did you mean 'oven'"),
    (":effect (and", ":efect (and", "unknown attribute ':efect' of action 'place'; did you mean ':effect'"),
    (":effect ())", ":effect () :effect ())", "action 'wait' has ':effect' twice"),
    (":effect ())", ":effect)", "expected a value behind ':effect'"),
    ("(:action wait", "(:action place", "action 'place' is defined twice"),
    ("(:action wait", "(:durative-action wait", "durative actions are not supported"),
    ("(:action wait", "(:actoin wait", "unknown section ':actoin'; did you mean ':action'"),
    ("(not (Holding ?b))", "(not (Unsafe ?b ?p))", "'unsafe' is derived; an action cannot change it"),
    ("(not (Holding ?b))", "(not (block ?b))", "'block' is a type; an action cannot change it"),
    ("(increase (total-cost) (+ 2", "(increase (fuel) (+ 2", r"only \(total-cost\) can be increased"),
    ("(+ 2", "(+ -2", "expected a cost of 0 or more, found '-2'"),
    ("(+ 2", "(+ nan", "expected a cost of 0 or more, found 'nan'"),
    ("(+ 2", "(* 2", "a cost is a number"),
    ("(+ 2 (Distance ?p ?p))", "(Distance ?p)", "'distance' takes 2 arguments, found 1"),
    ("(Cooked ?b))\n", "(increase (total-cost) 1))\n", "cannot depend on 'when'"),
    (":adl :typing", ":adl :tipyng", "unsupported requirement ':tipyng'; did you mean ':typing'"),
    ("(Distance ?p1 ?p2 - pose) - number", "(Distance ?p1 ?p2 - pose) - object", "or '- number', found 'object'"),
    ("(Distance ?p1 ?p2 - pose) - number", "(Distance ?p1 ?p2 - pose) number", "or '- number', found 'number'"),
    ("- physical  stove - region", "- stove  stove - region", "is its own supertype"),
    ("Oven - stove  tray", "Oven - stove  oven", "constant 'oven' is declared twice"),
    ("(HandEmpty) (Cooked ?b)", "(HandEmpty) (HandEmpty ?b)", "declared twice, with 0 and 1 arguments"),
    ("(HandEmpty) (Cooked ?b)", "(block ?x) (Cooked ?b)", "'block' is a type"),
    ("(:derived (Above ?a ?b)", "(:derived (Abov ?a ?b)", "undeclared predicate 'abov'; did you mean 'above'"),
    ("(exists (?c) (and (On ?a ?c) (Above ?c ?b)))", "(not (Above ?a ?b))", "'above' depends on its own negation"),
    ("(exists (?c) (and (On ?a ?c)", "(forall (?c) (and (On ?a ?c)", "'above' depends on its own negation"),
    ("(domain Kitchen)", "(problem Kitchen)", r"expected \(domain NAME\)"),
    ("(define", "(defin", r"expected \(define \(domain NAME\) ...\)"),
]


@pytest.mark.parametrize(("right", "wrong", "message"), BROKEN)
def test_mistakes_are_named_where_they_stand(right, wrong, message):
    assert right in DOMAIN
    text = DOMAIN.replace(right, wrong, 1)
    with pytest.raises(DomainError, match=r"^domain:\d+:\d+: .*" + message):
        parse_domain(text)


def test_line_and_column_point_at_the_word():
    text = "(define (domain d)\n  (:predicates (p ?x))\n  (:derived (p ?x)\n    (and (q ?x))))"
    with pytest.raises(DomainError, match=r"^domain:4:11: undeclared predicate 'q'; the predicates are: p$"):
        parse_domain(text)


def test_errors_name_the_file(tmp_path):
    path = tmp_path / "broken.pddl"
    path.write_text("(define (domain d)\n (:predicates (p ?x)", encoding="utf-8")
    with pytest.raises(DomainError, match=r"broken\.pddl:2:2: this bracket is never closed"):
        parse_domain(path)


def test_a_domain_is_put_together_from_several_texts():
    base = "(define (domain base) (:predicates (At ?x) (Base ?x)) (:action go :parameters (?x) :effect (At ?x)))"
    wash = "(:action wash :parameters (?x) :precondition (At ?x) :effect (Wet ?x))"
    more = f"(define (domain more) (:predicates (Wet ?x)) {wash})"
    domain = parse_domain([base, more])
    assert domain.name == "base"
    assert set(domain.actions) == {"go", "wash"}
    assert {"at", "base", "wet"} <= domain.predicates.keys()
