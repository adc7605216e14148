"""The numbers that decide how a run behaves and that a user may want to change, with what each one means."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import TYPE_CHECKING, Any

from tamp.errors import TampError, meant

if TYPE_CHECKING:
    from tamp.domains.timing import Speeds
    from tamp.streams.workspace import HandMotion


def _number(default: float | tuple[float, ...], low: float, high: float, text: str) -> Any:
    return field(default=default, metadata={"low": low, "high": high, "help": text})


def _share(default: float, text: str) -> Any:
    return _number(default, 0.0, 1.0, text)


def _count(default: int, text: str) -> Any:
    return _number(default, 0, 1_000_000, text)


def _length(default: float | tuple[float, ...], high: float, text: str) -> Any:
    return _number(default, 0.0, high, f"{text} [m]")


@dataclass(frozen=True)
class Tuning:
    """Recorded with each run. Each field says in its metadata what it means and between what it lies.

    Shares of time refer to what is left when they are used. What is a tuple is one or more numbers.
    """

    first_plan_share: float = _share(0.7, "of the time for planning goes to the first plan at most")
    next_plan_share: float = _share(0.5, "of the time that is left goes to each further plan")
    last_plan_share: float = _share(0.75, "of it goes to a plan for what another has left for want of time")
    punctual_share: float = _share(0.95, "of the limit is given out: whoever is busy looks at the clock late")
    max_replans: int = _count(16, "plans after the first, where reality deviates")
    max_corrections: int = _count(2, "of those, to correct what stands a little off its goal")
    max_vain_plans: int = _count(12, "searches with other seeds after one that brings nothing, while time is left")
    astray_m: float = _number(
        0.01, 0.0, 1.0, "an object that ends farther from its settled goal (EDE) is corrected [m]"
    )
    failing_share: float = _share(
        0.1, "of all grasps and pushes go wrong: a plan that brings less than it risks by that is not carried out"
    )
    together_share: float = _share(0.06, "serialized: of the time goes to the try for all goals together")
    goals_share: float = _share(0.7, "serialized: of the rest goes to goals, what remains to bringing things near")
    one_goal_share: float = _share(0.4, "serialized: of that goes to one goal for which others may move")
    one_goal_least_s: float = _number(4.0, 0.0, 3600.0, "serialized: less would be of no use for such a goal [s]")
    together_iterations: int = _count(8, "serialized: of the stream planner, for all goals together")
    alone_iterations: int = _count(6, "serialized: after which an object counts as hopeless even alone")
    carrying_speed: float = _share(0.5, "of the joints' limits while holding an object")
    gentle_speed: float = _share(0.4, "of the joints' limits near an object")
    pushing_speed: float = _share(0.2, "of the joints' limits while pushing an object")
    approaches_m: tuple[float, ...] = _length(
        (0.08, 0.05, 0.12),
        0.5,
        "how far back along the tool's axis the hand starts; the first way that is free is taken",
    )
    withdrawals_m: tuple[float, ...] = _length(
        (0.05, 0.02), 0.5, "the same for how far it draws back from what has fallen out of it"
    )
    push_gap_m: float = _length(0.025, 0.5, "how far behind what it pushes the hand comes down and goes up")
    close_push_gap_m: float = _length(0.008, 0.5, "the same where others leave no more room")
    push_height_m: float = _length(0.12, 0.5, "how far above that it begins and ends")
    hand_margin_m: float = _length(0.002, 0.05, "between the open hand and what stands around where grasps are chosen")

    def __post_init__(self) -> None:
        for f in fields(self):
            value, low, high = getattr(self, f.name), f.metadata["low"], f.metadata["high"]
            whole, several = isinstance(f.default, int), isinstance(f.default, tuple)
            if several:
                value = tuple(value) if isinstance(value, list | tuple) else (value,)
                object.__setattr__(self, f.name, value)
            numbers = value if several else (value,)
            if not numbers or any(
                isinstance(n, bool) or not isinstance(n, int if whole else (int, float)) for n in numbers
            ):
                kind = "one or more numbers" if several else f"a {'whole ' if whole else ''}number"
                raise TampError(f"tuning: {f.name} must be {kind}, found {value!r}")
            positive = f.name.endswith("_speed") or several
            if any(not low <= n <= high or (n == 0 and positive) for n in numbers):
                raise TampError(f"tuning: {f.name} must lie between {low:g} and {high:g}, found {value!r}")

    @staticmethod
    def of(values: Mapping[str, Any]) -> Tuning:
        """The defaults with some values in their place.

        Raises:
            TampError: for an unknown name or a value out of range.
        """
        known = [f.name for f in fields(Tuning)]
        for name in values:
            if name not in known:
                raise TampError(f"tuning: unknown {name!r}; {meant(name, known)}there are {', '.join(known)}")
        return Tuning(**values)

    @property
    def speeds(self) -> Speeds:
        """How fast the arm moves."""
        from tamp.domains.timing import Speeds  # here, so that options can be read without what they are for

        return Speeds(self.carrying_speed, self.gentle_speed, self.pushing_speed)

    @property
    def hand(self) -> HandMotion:
        """How the hand comes and goes."""
        from tamp.streams.workspace import HandMotion

        return HandMotion(
            self.approaches_m, self.withdrawals_m, self.push_gap_m, self.close_push_gap_m, self.push_height_m,
            self.hand_margin_m,
        )  # fmt: skip

    def recorded(self) -> dict[str, Any]:
        """JSON-like values by name."""
        return {name: list(value) if isinstance(value, tuple) else value for name, value in asdict(self).items()}

    def changed(self) -> dict[str, Any]:
        """What differs from the defaults."""
        return {name: value for name, value in asdict(self).items() if value != getattr(Tuning, name)}


DEFAULT_TUNING = Tuning()
