"""A stream file in PDDLStream's form -> StreamFile (Garrett et al., PDDLStream, ICAPS 2020)."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache

from tamp.errors import DomainWarning
from tamp.language.domain import Domain, Signature
from tamp.language.formula import OBJECT, Atom, Parameter, Variable
from tamp.language.read_action import read_attributes
from tamp.language.read_domain import read_define
from tamp.language.read_formula import FormulaReader, Scope
from tamp.language.sexpr import PDDL, Group, Node, Symbol, Text, load, read, show, suggest
from tamp.language.streams import FunctionStream, Mention, PredicateStream, Rule, Stream, StreamFile

SECTIONS = (":stream", ":wild-stream", ":function", ":predicate", ":rule", ":optimizer")


def parse_streams(text_or_path: PDDL | None, domain: Domain | None = None) -> StreamFile:
    """Read a stream file. Predicates that the domain does not declare are allowed, as streams may pass facts on.

    Args:
        text_or_path: stream PDDL text, the file it lies in, several of either, or None for a problem without streams.
        domain: what predicates, types and constants are checked against; without it only against each other.

    Raises:
        DomainError: with file, line and column of what cannot be read.
    """
    return StreamFile("none") if text_or_path is None else _parsed(load(text_or_path, "stream"), domain)


@lru_cache(maxsize=16)
def _parsed(source: Text, domain: Domain | None) -> StreamFile:
    """The streams of a text that is read once, as it stays what it is."""
    name, sections = read_define(source, read(source), "stream")
    known = domain or Domain(name)
    constants = None if domain is None else known.constants
    reader = _StreamReader(
        FormulaReader(source, known.types, constants, dict(known.predicates), open_world=True), known
    )
    for head, group in sections:
        reader.section(head, group)
    signatures = tuple(s for key, s in reader.formulas.predicates.items() if key not in known.predicates)
    return StreamFile(
        name,
        tuple(reader.streams),
        tuple(reader.functions),
        tuple(reader.predicates),
        tuple(reader.rules),
        signatures,
        tuple(reader.mentions),
        wild=any(head.text == ":wild-stream" for head, _ in sections),
        objectives=tuple(reader.objectives.items()),
    )


@dataclass
class _StreamReader:
    """What has been read so far."""

    formulas: FormulaReader
    domain: Domain
    streams: list[Stream] = field(default_factory=list)
    functions: list[FunctionStream] = field(default_factory=list)
    predicates: list[PredicateStream] = field(default_factory=list)
    rules: list[Rule] = field(default_factory=list)
    mentions: list[Mention] = field(default_factory=list)
    objectives: dict[str, tuple[str, ...]] = field(default_factory=dict)
    names: set[str] = field(default_factory=set)

    def section(self, head: Symbol, group: Group) -> None:
        """One bracket of the file."""
        if head.text in (":stream", ":wild-stream"):
            self.streams.append(self._stream(group))
        elif head.text == ":function":
            name, inputs, domain = self._external(group, "function")
            self.functions.append(FunctionStream(name, inputs, domain))
        elif head.text == ":predicate":
            name, inputs, domain = self._external(group, "predicate")
            self.predicates.append(PredicateStream(name, inputs, domain))
        elif head.text == ":rule":
            self.rules.append(self._rule(group))
        elif head.text == ":optimizer":
            self._optimizer(group)
        else:
            hint = suggest(head.text, SECTIONS, "sections")
            raise self.formulas.source.error(head, f"unknown section {head.text!r}{hint}")

    def _stream(self, group: Group) -> Stream:
        reader = self.formulas
        if len(group.items) < 2:
            raise reader.source.error(group, "expected (:stream NAME ...)")
        symbol = reader.symbol(group.items[1], "the name of a stream")
        if symbol.text.startswith((":", "?")):
            raise reader.source.error(symbol, f"expected the name of a stream, found {symbol.text!r}")
        self._claim(symbol, "stream")
        what = f"stream {symbol.text!r}"
        valid = (":inputs", ":domain", ":fluents", ":outputs", ":certified")
        given = read_attributes(reader, group, 2, valid, what)
        return self._made(symbol, what, given)

    def _made(self, symbol: Symbol, what: str, given: Mapping[str, Node], optimizer: str = "") -> Stream:
        """A stream of its attributes; `symbol` is its name, and where that stands."""
        inputs, input_facts, scope = self._variables(given.get(":inputs"))
        outputs, output_facts, output_scope = self._variables(given.get(":outputs"))
        for name in sorted(scope.keys() & output_scope.keys()):
            raise self.formulas.source.error(given[":outputs"], f"{name!r} is both input and output of {what}")
        domain = input_facts + self._facts(given.get(":domain"), scope)
        certified = output_facts + self._certified(given.get(":certified"), {**scope, **output_scope}, what)
        self._mention(given, what)
        if not certified:
            self._warn(symbol, f"{what} certifies nothing: only what its sampler certifies besides can be of use")
        self._check_awaited(symbol.text, domain, certified, given)
        fluents = self._fluents(given[":fluents"]) if ":fluents" in given else ()
        return Stream(symbol.text, inputs, domain, outputs, certified, fluents, optimizer)

    def _optimizer(self, group: Group) -> None:
        """(:optimizer NAME (:variables ...) (:constraint ...) (:objective ...)): a stream for each of the first two."""
        reader = self.formulas
        if len(group.items) < 2:
            raise reader.source.error(group, "expected (:optimizer NAME (:variables ...) ...)")
        name = reader.symbol(group.items[1], "the name of an optimizer")
        self._claim(name, "optimizer")
        self.objectives[name.text] = ()
        for item in group.items[2:]:
            part = reader.group(item, "(:variables (?x ...) ...), (:constraint FACT ...) or (:objective NAME)")
            head = reader.symbol(part.items[0] if part.items else part, ":variables, :constraint or :objective")
            if head.text == ":objective":
                self.objectives[name.text] += tuple(reader.symbol(i, "a function").text for i in part.items[1:])
            elif head.text in (":variables", ":constraint"):
                self.streams.append(self._component(name.text, head, part))
            else:
                hint = suggest(head.text, (":variables", ":constraint", ":objective"), "parts")
                raise reader.source.error(head, f"unknown part {head.text!r} of optimizer {name.text!r}{hint}")

    def _component(self, optimizer: str, head: Symbol, part: Group) -> Stream:
        """One part of an optimizer as a stream, or as a test."""
        made = head.text == ":variables"
        what = f"the {head.text} of optimizer {optimizer!r}"
        valid = (":variables", ":inputs", ":domain", ":graph") if made else (":constraint", ":necessary")
        given = read_attributes(self.formulas, part, 0, valid, what)
        if made:
            group = self.formulas.group(given.pop(":variables"), "(?x ...)")
            named = [self.formulas.symbol(item, "a variable").text[1:] for item in group.items]
            stream = {":outputs": group, ":certified": given.pop(":graph", Group((), part.position)), **given}
        else:
            symbol, args = self.formulas.application(given[":constraint"], "(PREDICATE ?x ...)")
            variables = dict.fromkeys(a for a in args if isinstance(a, Symbol) and a.text.startswith("?"))
            once = {a.text: a for a in reversed(variables)}
            named = [symbol.text]
            stream = {
                ":inputs": Group(tuple(reversed(once.values())), part.position),
                ":domain": given.get(":necessary", Group((), part.position)),
                ":certified": given[":constraint"],
            }
        name = "-".join((optimizer, *named))
        while name in self.names:
            name += "-again"
        symbol = Symbol(name, head.position)
        self._claim(symbol, "stream")
        return self._made(symbol, what, stream, optimizer)

    def _check_awaited(
        self, name: str, domain: tuple[Atom, ...], certified: tuple[Atom, ...], given: Mapping[str, Node]
    ) -> None:
        """Refuse a stream that waits for what actions change and certifies such facts itself."""
        changing = self.domain.fluents
        awaited = [atom.predicate for atom in domain if atom.predicate in changing]
        clash = [atom.predicate for atom in certified if atom.predicate in changing]
        if awaited and clash:
            raise self.formulas.source.error(
                given[":certified"],
                f"stream {name!r} cannot certify {clash[0]!r}, which actions change, while its :domain waits for "
                f"{awaited[0]!r}, which actions change as well",
            )

    def _external(self, group: Group, what: str) -> tuple[str, tuple[Variable, ...], tuple[Atom, ...]]:
        """(:function (NAME ?x ...) DOMAIN) or the same of a predicate."""
        reader = self.formulas
        form = f"(:{what} (NAME ?x ...) DOMAIN)"
        if len(group.items) not in (2, 3):
            raise reader.source.error(group, f"expected {form}, found {len(group.items) - 1} operands")
        symbol, args = reader.application(group.items[1], form)
        self._claim(symbol, what)
        inputs, facts, scope = self._variables(Group(args, group.items[1].position))
        table = self.domain.functions if what == "function" else reader.predicates
        if symbol.text in table:
            reader.arity(symbol, len(inputs), table[symbol.text])
        elif what == "predicate":
            reader.predicates[symbol.text] = Signature(symbol.text, tuple(map(Parameter, inputs)))
        if len(group.items) == 3:
            facts += self._facts(group.items[2], scope)
            self._mention({":domain": group.items[2]}, f"{what} {symbol.text!r}")
        return symbol.text, inputs, facts

    def _rule(self, group: Group) -> Rule:
        """(:rule :inputs (...) :domain ... :certified ...)."""
        given = read_attributes(self.formulas, group, 1, (":inputs", ":domain", ":certified"), "a rule")
        inputs, facts, scope = self._variables(given.get(":inputs"))
        certified = self._facts(given.get(":certified"), scope)
        if not certified:
            raise self.formulas.source.error(group, "the rule certifies nothing; expected :certified with a fact")
        domain = facts + self._facts(given.get(":domain"), scope)
        self._mention(given, "the rule")
        return Rule(inputs, domain, certified)

    def _mention(self, given: Mapping[str, Node], what: str) -> None:
        """Note the predicates of a :domain and a :certified, both read by now, that the domain does not declare."""
        for attribute, text in ((":domain", f"the :domain of {what} names"), (":certified", f"{what} certifies")):
            for fact in self._conjuncts(given.get(attribute)):
                symbol, _ = self.formulas.application(fact, "a fact such as (predicate ?x)")
                if symbol.text not in self.domain.predicates:
                    said = str(self.formulas.source.error(symbol, f"{text} {symbol.text!r}"))
                    self.mentions.append(Mention(symbol.text, attribute == ":certified", said))

    def _warn(self, node: Node, message: str) -> None:
        """Say what is likely a slip, as PDDLStream lets it pass."""
        warnings.warn(str(self.formulas.source.error(node, message)), DomainWarning, stacklevel=2)

    def _claim(self, symbol: Symbol, what: str) -> None:
        if symbol.text in self.names:
            raise self.formulas.source.error(symbol, f"{what} {symbol.text!r} is defined twice")
        self.names.add(symbol.text)

    def _variables(self, node: Node | None) -> tuple[tuple[Variable, ...], tuple[Atom, ...], Scope]:
        """Variables, what their types say about them, and the scope that they make."""
        if node is None:
            return (), (), {}
        parameters, scope = self.formulas.parameters(node)
        for parameter in parameters:
            if len(parameter.types) > 1:
                message = "a stream's variable has one type; (either ...) is not supported"
                raise self.formulas.source.error(node, message)
        facts = tuple(Atom(p.types[0], (p.variable,)) for p in parameters if p.types != (OBJECT,))
        return tuple(p.variable for p in parameters), facts, scope

    def _facts(self, node: Node | None, scope: Scope) -> tuple[Atom, ...]:
        """A conjunction of facts, flattened."""
        return tuple(self.formulas.atom(fact, scope) for fact in self._conjuncts(node))

    def _conjuncts(self, node: Node | None) -> Iterator[Node]:
        """The facts of a conjunction, as they stand in the file; one fact is one of itself, none are none."""
        if node is None:
            return
        group = self.formulas.group(node, "(and FACT ...) or a fact")
        match group.items:
            case ():
                return
            case (Symbol("and"), *parts):
                for part in parts:
                    yield from self._conjuncts(part)
            case (Symbol(), *_):
                yield group
            case _:
                raise self.formulas.source.error(node, f"expected (and FACT ...) or a fact, found {show(node)}")

    def _certified(self, node: Node | None, scope: Scope, what: str) -> tuple[Atom, ...]:
        """What a stream certifies, but for facts of another arity than their predicate's, which nothing can read."""
        reader, readable = self.formulas, list[Atom]()
        for fact in self._conjuncts(node):
            head, args = reader.application(fact, "a fact such as (predicate ?x)")
            declared = reader.predicates.get(head.text)
            if declared is None or declared.arity == len(args):
                readable.append(reader.atom(fact, scope))
                continue
            found = f"{what} certifies {head.text!r} of {len(args)} arguments, which nothing reads"
            self._warn(head, f"{found}: the predicate takes {declared.arity}")
        return tuple(readable)

    def _fluents(self, node: Node) -> tuple[str, ...]:
        """Names of predicates, in a list or alone."""
        reader = self.formulas
        items = node.items if isinstance(node, Group) else (node,)
        names: list[str] = []
        for item in items:
            symbol = reader.symbol(item, "a predicate")
            if self.domain.predicates and symbol.text not in reader.predicates:
                hint = suggest(symbol.text, self.domain.predicates.keys() - self.domain.types.keys(), "predicates")
                self._warn(symbol, f"undeclared predicate {symbol.text!r}: no fact of it will ever be passed{hint}")
            names.append(symbol.text)
        return tuple(names)
