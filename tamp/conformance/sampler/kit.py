"""The checks, in the order in which a mistake would make the later ones meaningless."""

from __future__ import annotations

import inspect
import logging
import statistics
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from tamp.conformance.findings import Finding, Judgement
from tamp.conformance.form import malformed, shown
from tamp.conformance.sameness import same
from tamp.conformance.sampler.bench import Bench, set_up
from tamp.conformance.sampler.calls import Call, call
from tamp.conformance.sampler.downstream import shares
from tamp.conformance.sampler.plausible import implausible
from tamp.domains.catalog import Contract, contract, load_domain, type_name
from tamp.domains.learned import LOAD, load_models
from tamp.domains.samplers import load_sampler
from tamp.errors import SamplerError
from tamp.language import Stream
from tamp.planning import Problem
from tamp.planning.problem import check_sampler as check_signature
from tamp.task import Task

log = logging.getLogger("tamp")

CALLS = 6
OUTPUTS = 12
ROUNDS = 3  # of measuring times
SLOW_S = 5.0  # a single draw that takes longer is worth a note [s]


def check_sampler(
    sampler: str | Callable[..., Any],
    stream: str,
    *,
    domain: str = "tabletop",
    tasks: Iterable[Task] | None = None,
    seed: int = 0,
) -> Judgement:
    """Hold a sampler against its stream: signature, outputs, plausibility, determinism, end, time, use downstream.

    Args:
        sampler: a function, or "package.module:function".
        stream: the stream's name.
        domain: the domain that has it.
        tasks: where to try it, the first that gives it inputs; built-in scenarios where it is None.
        seed: decides every random choice.

    Raises:
        SamplerError: where stream, sampler or its model cannot be had, or no task gives the stream inputs.
        DomainError, TaskError: where domain or task cannot be used.
    """
    entry = load_domain(domain)
    declared = entry.stream(stream)
    function = load_sampler(sampler, stream) if isinstance(sampler, str) else sampler
    name = sampler if isinstance(sampler, str) else getattr(sampler, "__qualname__", repr(sampler))
    load_models([function])
    try:
        check_signature(declared, function)
    except SamplerError as error:
        told = f"{error}{_of_its_model(declared, function)}"
        return Judgement(name, declared.name, (Finding("signature", "wrong", told),))
    bench = set_up(entry, declared, tasks, seed, CALLS)
    trial = _Trial(declared, contract(entry, declared), function, bench, seed)
    findings = [Finding("signature", "ok", f"takes (context, {', '.join(v.name[1:] for v in declared.inputs)})")]
    for check in (
        trial.errors, trial.outputs, trial.plausibility, trial.determinism, trial.answers, trial.end, trial.time,
        trial.use,
    ):  # fmt: skip
        log.info("%s of %s", check.__name__, name)
        findings += check()
        if findings[-1].outcome == "wrong":
            break
    details = [f"call {number}: {made}" for number, made in enumerate(trial.calls)]
    details += [made.trace.rstrip() for made in trial.calls if made.trace][:1]
    return Judgement(name, declared.name, tuple(findings), {"task": bench.task, **trial.numbers}, tuple(details))


@dataclass
class _Trial:
    """One sampler at work; each method is one check."""

    stream: Stream
    contract: Contract
    function: Callable[..., Any]
    bench: Bench
    seed: int
    numbers: dict[str, Any] = field(default_factory=dict)
    calls: list[Call] = field(default_factory=list)

    def errors(self) -> Iterator[Finding]:
        """No call raises."""
        for _, made in self._run(self.bench.problem):
            self.calls.append(made)
            if made.error:
                yield Finding("calls", "wrong", made.failure)
                return
        left = dict.fromkeys(text for made in self.calls for text in made.left_behind)
        yield from (Finding("calls", "note" if text.startswith("printed") else "wrong", text) for text in left)
        self.numbers |= {"calls": len(self.calls), "outputs": sum(len(c.raw) for c in self.calls)}
        yield Finding("calls", "ok", f"{len(self.calls)} calls on {self.bench.task}")

    def outputs(self) -> Iterator[Finding]:
        """Everything that comes has the stream's form and types."""
        wrong = dict.fromkeys(
            text for made in self.calls for value in made.raw for text in malformed(value, self.stream, self.contract)
        )
        if wrong:
            yield from (Finding("outputs", "wrong", text) for text in wrong)
            return
        promised = ", ".join(map(type_name, self.contract.outputs.values())) or "bool"
        if not any(made.raw for made in self.calls):
            reasons = sorted({reason for made in self.calls for reason in made.reasons})
            told = f"; it said: {', '.join(reasons[:3])}" if reasons else ", and context.fail was never told why"
            text = f"nothing came from any of {len(self.calls)} calls{told}"
            if any(made.raw for _, made in self._run(self.bench.problem, own=True)):
                yield Finding("outputs", "wrong", text)
            else:
                theirs = "the domain's own gives nothing there either: give another task with --task"
                yield Finding("outputs", "note", f"{text}; {theirs}")
            return
        yield Finding("outputs", "ok", f"{self.numbers['outputs']} of {promised}")
        again = sum(any(same(value, old) for old in c.raw[:n]) for c in self.calls for n, value in enumerate(c.raw))
        if again:
            yield Finding("outputs", "note", f"{again} of them repeat earlier ones of the same call")

    def plausibility(self) -> Iterator[Finding]:
        """Frames and units are as they are meant."""
        scene = self.bench.problem.scene
        found = dict.fromkeys(
            text
            for made in self.calls
            for output in made.outputs
            for value in output
            for text in implausible(value, scene, made.inputs, made.fluents)
        )
        yield from (Finding("plausibility", "wrong", text) for text in list(found)[:5])
        if not found and not self.stream.is_test:
            yield Finding("plausibility", "ok", "frames, units and scenes look right")

    def determinism(self) -> Iterator[Finding]:
        """The same seed gives the same, in whatever order inputs come."""
        for number, second in self._run(self.bench.with_fresh_scene(), backwards=True):
            if second.error:
                yield Finding("determinism", "wrong", f"at the second call with the same seed {second.failure}")
                return
            if not same(self.calls[number].raw, second.raw):
                yield Finding(
                    "determinism", "wrong",
                    f"other outputs for {shown(second.inputs)} at the second call with the same seed: draw from "
                    "context.rng only, and keep nothing between calls that depends on their order",
                )  # fmt: skip
                return
        yield Finding("determinism", "ok", "the same seed repeats, calls in reverse order")

    def answers(self) -> Iterator[Finding]:
        """A test says what the domain's own says."""
        if not self.stream.is_test:
            return
        own = (bool(made.outputs) for _, made in self._run(self.bench.problem, own=True))
        said = Counter(zip((bool(made.outputs) for made in self.calls), own, strict=True))
        yes, no = said[True, True] + said[False, True], said[True, False] + said[False, False]
        if yes and not said[True, True]:
            text = f"never True for the {yes} inputs for which the domain's own says True: no plan comes of that"
            yield Finding("answers", "wrong", text)
        elif said[True, False] or said[False, True]:
            text = f"True for {said[True, False]} of {no} inputs for which the domain's own says False"
            text += f", False for {said[False, True]} of {yes} for which it says True"
            yield Finding("answers", "note", text)
        else:
            yield Finding("answers", "ok", f"the domain's own: True for {yes} inputs, False for {no}")

    def end(self) -> Iterator[Finding]:
        """Whether it ends; not ending is allowed, but nothing can be proven impossible with it."""
        if self.stream.is_test:
            return
        ended = sum(made.ended for made in self.calls)
        self.numbers["ended"] = ended / len(self.calls)
        if ended == len(self.calls):
            yield Finding("end", "ok", f"every call ends within {OUTPUTS} outputs")
        else:
            text = f"{len(self.calls) - ended} of {len(self.calls)} calls had not ended after {OUTPUTS} outputs"
            yield Finding("end", "note", f"{text}; while a sampler goes on, no task is proven infeasible")

    def time(self) -> Iterator[Finding]:
        """How long it takes, beside the domain's own."""
        # By turns, each in a scene that remembers nothing: whoever came second would find what the first one has left.
        rounds = [
            [_seconds_an_output(self._made(self.bench.with_fresh_scene(), own=own)) for own in (False, True)]
            for _ in range(ROUNDS)
        ]
        mine, theirs = (1000 * statistics.median(seconds) for seconds in zip(*rounds, strict=True))
        self.numbers |= {"ms_an_output": mine, "ms_an_output_default": theirs}
        longest = max(s for made in self.calls for s in made.seconds)
        text = f"{mine:.3g} ms an output, the domain's own {theirs:.3g} ms; longest draw {longest:.2g} s"
        yield Finding("time", "ok" if longest < SLOW_S else "note", text)

    def use(self) -> Iterator[Finding]:
        """How many of its outputs pass the streams that use them, beside the domain's own."""
        mine = shares(self.bench, self.stream, self.calls, self.seed)
        theirs = shares(self.bench, self.stream, self._made(self.bench.problem, own=True), self.seed)
        default = {name: passed.share for name, passed in theirs.items()}
        self.numbers["downstream"] = {
            name: {"share": passed.share, "default": default.get(name), "reasons": list(passed.reasons)}
            for name, passed in mine.items()
        }
        for name, passed in mine.items():
            useless = passed.share == 0.0 and default.get(name, 0.0) > 0.0
            beside = f", the domain's own {default[name]:.0%}" if name in default else ""
            why = f"; it said: {', '.join(passed.reasons[:3])}" if passed.share < 0.5 and passed.reasons else ""
            yield Finding("downstream", "wrong" if useless else "ok", f"{passed.share:.0%} pass {name}{beside}{why}")

    def _made(self, problem: Problem, *, own: bool) -> list[Call]:
        return [made for _, made in self._run(problem, own=own)]

    def _run(self, problem: Problem, *, backwards: bool = False, own: bool = False) -> Iterator[tuple[int, Call]]:
        """Each call with its number, as it is made: who has heard enough asks for no more."""
        numbered = list(enumerate(self.bench.inputs))
        for number, values in reversed(numbered) if backwards else numbered:
            who = "the domain's own" if own else "the sampler"
            log.info("call %d of %d of %s: %s", number + 1, len(numbered), who, shown(values))
            function = None if own else self.function
            yield (
                number,
                call(problem, self.stream, values, key=str(number), seed=self.seed, outputs=OUTPUTS, sampler=function),
            )


def _of_its_model(stream: Stream, function: Callable[..., Any]) -> str:
    """Where the model is among the arguments, for who has left it out."""
    if not hasattr(function, LOAD):
        return ""
    taken = ", ".join(("context", "model", *(str(variable)[1:] for variable in stream.inputs)))
    own = ", ".join(inspect.signature(inspect.unwrap(function)).parameters)
    return f"; what @with_model decorates is called with ({taken}), the model second; this one takes ({own})"


def _seconds_an_output(calls: Sequence[Call]) -> float:
    return statistics.fmean(s for made in calls for s in made.seconds) if any(c.seconds for c in calls) else 0.0
