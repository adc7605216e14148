"""An argument parser that says what was probably meant."""

from __future__ import annotations

import argparse
import difflib
from collections.abc import Iterable, Sequence
from typing import Any, NoReturn


class Parser(argparse.ArgumentParser):
    """As argparse has it; an unknown command, choice or option is refused with the nearest one that there is."""

    def parse_known_args(self, args: Sequence[str] | None = None, namespace: Any = None) -> Any:  # type: ignore[override]
        """Refuse what is left over, and do it here: only the command's own parser knows its options."""
        found, extras = super().parse_known_args(args, namespace)
        if extras:
            options = [option for option in self._option_string_actions if option.startswith("--")]
            hints = (hint(word.partition("=")[0], options) for word in extras if word.startswith("-"))
            self.error(f"unrecognized arguments: {' '.join(extras)}{next(filter(None, hints), '')}")
        return found, extras

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is None or value in action.choices:
            return
        valid = list(map(str, action.choices))
        meant = hint(str(value), valid)
        if isinstance(action, argparse._SubParsersAction):
            self.error(f"there is no command {value!r}{meant}")
        raise argparse.ArgumentError(action, f"{value!r} is not valid{meant or '; valid are ' + ', '.join(valid)}")

    def error(self, message: str) -> NoReturn:
        """Say what is wrong in one sentence, with where help is; exit status 2."""
        self.exit(2, f"tamp: {message} (see {self.prog} --help)\n")


def hint(word: str, valid: Iterable[str]) -> str:
    """The nearest valid word as a question, or nothing."""
    close = difflib.get_close_matches(word, list(valid), n=1)
    return f"; did you mean {close[0]}?" if close else ""
