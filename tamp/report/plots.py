"""Plots as SVG text that stands in a page: no files, no network, the same bytes for the same data."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable, Mapping, Sequence
from textwrap import wrap
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from tamp.report.comparison import Comparison, Row

COLORS = ("#2f6f9f", "#d97b29", "#4f9f5f", "#b0524f", "#7f6fae", "#8c6d4f", "#5b5b5b", "#c7a93c", "#4fa3a5", "#a35b8c")
LINE, LINES = 30, 4
"""Letters in a line of a name, and lines of it."""


def svg(draw: Callable[[Figure], None], height: float) -> str:
    """An SVG element.

    Args:
        draw: puts the data on the figure.
        height: of the picture, 8 inches wide at 72 dots an inch.
    """
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    # A fixed salt keeps the ids within the picture the same from run to run; text stays text.
    style: dict[Any, Any] = {
        "svg.hashsalt": "tamp", "svg.fonttype": "none", "font.size": 9, "font.family": "sans-serif",
        "axes.facecolor": "none", "legend.frameon": False,
    }  # fmt: skip
    with rc_context(style):
        figure = Figure(figsize=(8.0, height), layout="constrained", facecolor="none")
        draw(figure)
        file = io.StringIO()
        figure.savefig(file, format="svg", metadata=dict.fromkeys(("Date", "Creator", "Format", "Type")))
    text = file.getvalue().replace("#000000", "currentColor")  # as the page has it, light or dark
    return text[text.index("<svg") :]


def plot(draw: Callable[[Axes], None], height: float = 3.0) -> str:
    """An SVG element with one pair of axes."""

    def on(figure: Figure) -> None:
        axes = figure.add_subplot()
        axes.spines[["top", "right"]].set_visible(False)
        draw(axes)

    return svg(on, height)


def _wrapped(names: Iterable[str]) -> list[str]:
    """Names that leave room for what they name: long ones on several lines, and in part if they are longer still."""
    return ["\n".join(wrap(name, LINE, max_lines=LINES, placeholder=" …", break_on_hyphens=False)) for name in names]


def survival(times: Mapping[str, Sequence[float]], total: Mapping[str, int]) -> str:
    """Share solved over planning time; one step line a series.

    Args:
        times: series -> planning times of what was solved [s].
        total: series -> how many were tried.
    """

    def draw(axes: Axes) -> None:
        end = 1.03 * max((value for values in times.values() for value in values), default=1.0)
        labels = _wrapped(times)
        for color, label, (name, values) in zip(COLORS * 9, labels, times.items(), strict=False):
            ordered = sorted(values)
            shares = [100.0 * (i + 1) / total[name] for i in range(len(ordered))]
            steps = [0.0, *shares, (shares or [0.0])[-1]]
            axes.step([0.0, *ordered, end], steps, where="post", label=label, color=color)
        axes.set(xlabel="planning time [s]", ylabel="solved [%]", ylim=(0, 103))
        axes.set_xlim(0, end)
        _legend(axes, len(times))

    return plot(draw, height=3.0 + 0.3 * max(0, len(times) - 1))


def _legend(axes: Axes, count: int) -> None:
    """Names below the picture, where they cover nothing."""
    if count > 1:
        axes.legend(frameon=False, loc="upper left", bbox_to_anchor=(0.0, -0.22), ncols=2)


def boxes(groups: Mapping[str, Sequence[float]], label: str) -> str:
    """One box a group, with every value as a point."""
    names = _wrapped(groups)

    def draw(axes: Axes) -> None:
        values = [list(group) for group in groups.values()]
        axes.boxplot(values, orientation="horizontal", showfliers=False, medianprops={"color": COLORS[1]})
        for row, group in enumerate(values, start=1):
            axes.plot(group, [row] * len(group), "o", color=COLORS[0], alpha=0.5, markersize=3)
        axes.set_yticks(range(1, len(groups) + 1), names)
        axes.set(xlabel=label)
        axes.set_xlim(left=0)

    return plot(draw, height=0.9 + _rows(names))


def bars(values: Mapping[str, float], label: str) -> str:
    """Horizontal bars, the first on top."""
    names = _wrapped(values)

    def draw(axes: Axes) -> None:
        rows = range(len(values))
        axes.barh(list(rows), list(values.values()), color=COLORS[0])
        axes.set_yticks(list(rows), names)
        axes.invert_yaxis()
        axes.set(xlabel=label)

    return plot(draw, height=0.9 + _rows(names))


def stacked(rows: Mapping[str, Mapping[str, float]], label: str) -> str:
    """A horizontal bar a row, of its parts one after the other."""
    parts = list(dict.fromkeys(part for row in rows.values() for part in row))
    names = _wrapped(rows)

    def draw(axes: Axes) -> None:
        ends = [0.0] * len(rows)
        for color, part in zip(COLORS * 9, parts, strict=False):
            lengths = [row.get(part, 0.0) for row in rows.values()]
            axes.barh(range(len(rows)), lengths, left=ends, color=color, label=part)
            ends = [end + length for end, length in zip(ends, lengths, strict=True)]
        axes.set_yticks(range(len(rows)), names)
        axes.invert_yaxis()
        axes.set(xlabel=label)
        axes.legend(frameon=False, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3)

    return plot(draw, height=1.1 + 0.2 * (len(parts) // 3 + 1) + _rows(names))


def _rows(names: Sequence[str]) -> float:
    """Height of rows with these names [inch]."""
    return len(names) * (0.12 + 0.14 * (1 + max((name.count("\n") for name in names), default=0)))


def differences(comparisons: Sequence[Comparison]) -> str:
    """Each measure's difference from the first one with its interval, beside a line at no difference."""
    measures = list(dict.fromkeys(row.measure.name for c in comparisons for row in c.rows if row.difference.count))

    def draw(figure: Figure) -> None:
        for place, name in enumerate(measures, start=1):
            axes = figure.add_subplot(len(measures), 1, place)
            axes.spines[["top", "right", "left"]].set_visible(False)
            _draw_differences(axes, {c.other: row for c in comparisons for row in c.rows if row.measure.name == name})
            axes.set_title(name, loc="left", fontsize=9)

    return svg(draw, height=len(measures) * (0.75 + _rows(_wrapped(c.other for c in comparisons))))


def _draw_differences(axes: Axes, rows: Mapping[str, Row]) -> None:
    for place, row in enumerate(rows.values()):
        color = {"better": COLORS[2], "worse": COLORS[3]}.get(row.verdict, COLORS[6])
        axes.plot([row.difference.lower, row.difference.upper], [place, place], color=color, linewidth=2)
        axes.plot([row.difference.mean], [place], "o", color=color)
    axes.axvline(0.0, color="black", linewidth=0.8)
    axes.set_yticks(range(len(rows)), _wrapped(rows))
    axes.set_ylim(len(rows) - 0.5, -0.5)
