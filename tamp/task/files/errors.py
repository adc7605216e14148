"""What is wrong with a task file in one sentence: pydantic's errors as file, line, field and what would be valid."""

from __future__ import annotations

import difflib
from collections.abc import Iterator
from typing import Any, get_args

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from tamp.errors import nearest
from tamp.task.files import schema
from tamp.task.files.yaml_document import Document, FieldPath

_EXPECTED = {
    "finite_number": "must be a finite number",
    "float_type": "must be a number",
    "string_type": "must be text",
    "missing": "is missing",
    "tuple_type": "must be a list",
    "dict_type": "must be a mapping",
    "model_type": "must be a mapping",
    "greater_than": "must be greater than 0",
    "greater_than_equal": "must be from -1000 to 1000",
}


def sentence(error: ValidationError, document: Document, model: type[BaseModel] = schema.TaskModel) -> str:
    """The first error of a file, in the file's order, as one sentence; `model` is what the file was held against."""
    errors = error.errors(include_url=False)
    # An error inside a list makes pydantic count its entries anew: what is said about the list itself is then noise.
    found = [(_field(e, document), e) for e in errors]
    ancestors = {field[:depth] for field, _ in found for depth in range(len(field))}
    inner = [(field, e) for field, e in found if field not in ancestors]
    field, first = min(inner, key=lambda pair: document.line(pair[0]))
    if first["type"] == "missing":  # where a field that is unknown beside it is nearly called so, that is the mistake
        strange = [pair for pair in inner if pair[1]["type"] == "extra_forbidden" and pair[0][:-1] == field[:-1]]
        unknown = {str(pair[0][-1]): pair for pair in strange}
        near = difflib.get_close_matches(str(field[-1]), unknown, n=1)
        field, first = unknown[near[0]] if near else (field, first)
    where = document.where(field)
    if first["type"] == "extra_forbidden":
        valid = field_names(field[:-1], model)
        meant = nearest(field[-1], valid)
        hint = "" if meant is None else f"did you mean {meant}? "
        return f"{where}: unknown field; {hint}valid here are {', '.join(valid)}"
    return f"{where}: {_complaint(first, field, model)}"


def _field(error: ErrorDetails, document: Document) -> FieldPath:
    """Where it is in the file; what a schema adds to that is in brackets: `[key]`, and names of alternatives."""
    field: FieldPath = ()
    for key in error["loc"]:
        if not str(key).startswith("[") or (*field, key) in document.lines:
            field = (*field, key)
    return field


def _complaint(error: ErrorDetails, field: FieldPath, model: type[BaseModel]) -> str:
    kind, context = error["type"], error.get("ctx", {})
    if kind == "value_error":
        return str(context["error"])
    if kind == "string_pattern_mismatch":
        function = context.get("pattern") == r"^[A-Za-z_][\w.]*:[A-Za-z_]\w*$"
        valid = "package.module:function" if function else "letters, digits, '_', '-' and '.'"
        return f"{_shown(error['input'])} is not valid; it must be {valid}"
    if kind in ("too_short", "too_long"):
        bound = f"at least {context['min_length']}" if kind == "too_short" else f"at most {context['max_length']}"
        return f"needs {bound} entries; it has {context['actual_length']}"
    if kind in ("string_too_short", "string_too_long"):
        bound = f"at least {context['min_length']}" if "min_length" in context else f"at most {context['max_length']}"
        return f"{_shown(error['input'])} has {len(error['input'])} characters; {bound} are valid"
    if kind == "missing":
        names = field_names(field[:-1], model)
        return "is missing" + (f"; the fields here are {', '.join(names)}" if names else "")
    if kind == "less_than_equal":
        return f"{_shown(error['input'])} is too large; at most {context['le']:g} is valid"
    expected = f"must be {context['expected']}" if kind == "literal_error" else _EXPECTED.get(kind, error["msg"])
    if kind in ("dict_type", "model_type") and (names := field_names(field, model)):
        expected += f" with the fields {', '.join(names)}"
    return f"{_shown(error['input'])} is not valid; it {expected}"


def _shown(value: Any) -> str:
    text = repr(list(value)) if isinstance(value, tuple) else repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def field_names(field: FieldPath, root: type[BaseModel] = schema.TaskModel) -> tuple[str, ...]:
    """Names of the fields that a schema has at `field`; none where there is no mapping."""
    model: type[BaseModel] | None = root
    for key in field:
        if isinstance(key, int):
            continue
        found = None if model is None else _field_named(model, key)
        model = None if found is None else next(_models(found), None)
    if model is None:
        return ()
    return tuple(info.alias or name for name, info in model.model_fields.items())


def _field_named(model: type[BaseModel], key: str) -> Any:
    for name, info in model.model_fields.items():
        if key == (info.alias or name):
            return info.annotation
    return None


def _models(annotation: Any) -> Iterator[type[BaseModel]]:
    """The models inside an annotation such as `tuple[ObjectModel, ...]` or `PoseModel | None`."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for argument in get_args(annotation):
        yield from _models(argument)
