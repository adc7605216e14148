import pytest
from hypothesis import given
from hypothesis import strategies as st

from tamp.errors import DomainError
from tamp.language import parse_domain, parse_streams
from tamp.language.sexpr import MAX_DEPTH, Group, Symbol, Text, load, read, show, suggest
from tests.language.texts import DOMAIN, STREAMS

TREES = st.recursive(
    st.text("abz?:-@_09", min_size=1, max_size=5), lambda inner: st.lists(inner, max_size=4), max_leaves=20
).filter(lambda tree: isinstance(tree, list))


def write(tree):
    return tree if isinstance(tree, str) else f"({' '.join(map(write, tree))})"


def strip(node):
    return node.text if isinstance(node, Symbol) else [strip(item) for item in node.items]


@given(TREES)
def test_what_is_written_is_read(tree):
    assert strip(read(Text("t", write(tree)))) == tree


@given(TREES, st.sampled_from([" ", "\n", "\t", " ; (comment\n", "\r\n"]))
def test_space_and_comments_do_not_matter(tree, space):
    assert strip(read(Text("t", write(tree).replace(" ", space)))) == tree


def test_positions():
    node = read(Text("t", " (A\n  (b))"))
    assert node == Group((Symbol("a", 2), Group((Symbol("b", 7),), 6)), 1)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("(a (b)", "t:1:1: this bracket is never closed"),
        ("(a))", "t:1:4: expected the end of the text, found '\\)'"),
        ("; only\n", "t:1:1: expected '\\(define ...\\)', found nothing"),
        ("a (b)", "t:1:1: expected '\\(define', found 'a'"),
        ("(" * 1_000_000, "t:1:101: brackets are nested deeper than 100 levels"),
    ],
)
def test_brackets(text, message):
    with pytest.raises(DomainError, match=f"^{message}"):
        read(Text("t", text))


def test_deepest_nesting_is_readable():
    read(Text("t", "(" * MAX_DEPTH + ")" * MAX_DEPTH))


def test_deep_formulas_are_read_without_recursion_errors():
    depth = MAX_DEPTH - 4
    formula = "(not " * depth + "(p)" + ")" * depth
    parse_domain(f"(define (domain d) (:predicates (p) (q)) (:derived (q) {formula}))")


def test_what_cannot_be_loaded(tmp_path):
    binary = tmp_path / "binary.pddl"
    binary.write_bytes(b"\xff\xfe(define")
    for path in (tmp_path, tmp_path / "absent.pddl", binary, "a\0b", "x" * 5000):
        with pytest.raises(DomainError, match="cannot read the domain file"):
            load(path, "domain")
    for empty in ("", "  "):
        with pytest.raises(DomainError, match="the domain text is empty: expected PDDL, or where a file of it lies"):
            load(empty, "domain")
    with pytest.raises(DomainError, match="must be PDDL text, a path, or a list of those, not int"):
        load(5, "domain")


def test_size_is_limited(monkeypatch):
    monkeypatch.setattr("tamp.language.sexpr.MAX_SIZE", 10)
    with pytest.raises(DomainError, match="at most 10"):
        load("(define ())" * 2, "domain")


def test_suggestions():
    assert suggest("atpos", ["atpose", "holding"], "predicates") == "; did you mean 'atpose'?"
    assert suggest("zzz", ["b", "a"], "predicates") == "; the predicates are: a, b"
    assert suggest("zzz", [], "predicates") == "; there are no predicates"


KITCHEN = parse_domain(DOMAIN)


def refuses_politely(parse, *args):
    """Parsing succeeds, or it raises the one error that users are meant to see."""
    try:
        parse(*args)
    except DomainError as error:
        assert "\n" not in str(error)


def parse_either(text):
    refuses_politely(parse_domain, text)
    refuses_politely(parse_streams, text)
    refuses_politely(parse_streams, text, KITCHEN)


@given(
    st.sampled_from([DOMAIN, STREAMS]),
    st.lists(st.tuples(st.floats(0, 1), st.integers(0, 12), st.text("() ?:-aps;\n0", max_size=6)), max_size=3),
)
def test_mutated_files_give_domain_errors_only(text, edits):
    for place, length, new in edits:
        start = int(place * len(text))
        text = text[:start] + new + text[start + length :]
    parse_either(text)


WORDS = sorted(set((DOMAIN + STREAMS).replace("(", " ( ").replace(")", " ) ").split()))


@given(
    st.sampled_from(["domain", "stream"]), st.lists(st.sampled_from([*WORDS, "(", ")", "(and", "(not"]), max_size=40)
)
def test_shuffled_words_give_domain_errors_only(kind, words):
    parse_either(f"(define ({kind} x) ({' '.join(words)}))")


@given(st.data())
def test_swapped_words_give_domain_errors_only(data):
    words = data.draw(st.sampled_from([DOMAIN, STREAMS])).replace("(", " ( ").replace(")", " ) ").split()
    for _ in range(data.draw(st.integers(1, 3))):
        i = data.draw(st.integers(0, len(words) - 1))
        words[i] = data.draw(st.sampled_from(WORDS))
    parse_either(" ".join(words))


@given(st.text())
def test_noise_gives_domain_errors_only(text):
    parse_either(text)
    parse_either(f"(define (domain d) {text})")


def test_several_files_are_read_as_one_and_errors_name_their_own(tmp_path):
    (tmp_path / "base.pddl").write_text("(define (domain base)\n  (:predicates (A ?x)))")
    (tmp_path / "more.pddl").write_text("; more\n(define (domain more)\n  (:predicates (B ?x))\n  (:nonsense))\n")
    source = load([tmp_path / "base.pddl", tmp_path / "more.pddl"], "domain")
    whole = read(source)
    heads = [show(item) for item in whole.items[1:]]
    assert heads == ["'(domain ...)'", "'(:predicates ...)'", "'(:predicates ...)'", "'(:nonsense)'"]
    said = str(source.error(whole.items[-1], "unknown"))
    assert said == f"{tmp_path / 'more.pddl'}:4:3: unknown"
    assert str(source.error(whole.items[2], "known")) == f"{tmp_path / 'base.pddl'}:2:3: known"


def test_what_is_read_as_one_is_of_one_kind():
    with pytest.raises(DomainError, match=r"domain:1:1: expected \(define \.\.\.\) of the same kind"):
        read(load(["(define (domain a))", "(define (stream b))"], "domain"))


def test_no_text_at_all_is_refused():
    with pytest.raises(DomainError, match="not nothing"):
        load((), "domain")
