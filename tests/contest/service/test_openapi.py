"""The API answers as its own description says, whatever is asked: what a client made of that description relies on."""

from __future__ import annotations

import random
import re
from collections.abc import Iterator
from typing import Any

import pytest

pytest.importorskip("fastapi", reason="the web service needs the extra 'contest'")
pytest.importorskip("sqlalchemy", reason="the web service needs the extra 'contest'")

from tests.contest.service.served import CODE, Service

ODD = (
    "", "0", "contest", "trial", "a.py", "b.zip", "c.whl", ".py", "../x.py", "\u202e.py", "\0.py", "x" * 3000 + ".py",
    "NaN", "%00", "' OR 1=1 --.py", "\U0001f600.py", "9" * 40,
)  # fmt: skip
BODIES = (
    b"",
    CODE,
    b"PK\x03\x04",
    b"{}",
    b"null",
    b'{"token": 3}',
    b'{"token": "\\ud800"}',
    b"[" * 3000,
    b"\xff\xfe",
    b"1" * 5000,
)
VALID = {"name": "solution.py", "kind": "trial", "runs": "false"}
HEADERS = (
    {}, {"Content-Type": "application/json"}, {"Content-Type": "multipart/form-data"}, {"Sec-Fetch-Site": "cross-site"},
    {"Content-Type": "application/json; charset=nonsense"}, {"Range": "bytes=9-1"}, {"Accept": "text/html"},
    {"Cookie": "tamp_contest_token=%00"},
)  # fmt: skip


def _operations(description: dict[str, Any]) -> Iterator[tuple[str, str, dict[str, Any]]]:
    for path, methods in description["paths"].items():
        for method, operation in methods.items():
            yield method.upper(), path, operation


@pytest.mark.parametrize("seed", range(3))
def test_whatever_is_asked_the_answer_is_one_that_is_described(service: Service, seed: int) -> None:
    rng = random.Random(seed)
    description = service.get("/api/openapi.json").json()
    number = service.hand_in(service.ours).json()["id"]
    seen = set()
    for _ in range(40):
        for method, template, operation in _operations(description):
            path = re.sub(r"{.*?}", lambda _: rng.choice((number, "none", "9" * 40)), template)
            given = [p["name"] for p in operation.get("parameters", ()) if p["in"] == "query" and rng.random() < 0.9]
            token = rng.choice((service.ours, service.ours, service.theirs, "none", "Basic \u00e9"))
            authorization = {"Authorization": f"Bearer {token}".encode()} if rng.random() < 0.9 else {}
            body = rng.choice((CODE + b"#%d" % rng.randrange(99), rng.choice(BODIES)))
            answer = service.client.request(
                method,
                path,
                params={name: VALID[name] if rng.random() < 0.7 else rng.choice(ODD) for name in given},
                headers={**rng.choice(HEADERS), **authorization},
                content=body if method != "GET" else None,
            )
            known = operation["responses"]
            assert str(answer.status_code) in known, (method, answer.request.url, answer.status_code, answer.text[:200])
            kind = answer.headers["Content-Type"]
            assert kind in known[str(answer.status_code)]["content"], (method, path, kind)
            if answer.status_code >= 400:
                assert {name: type(value) for name, value in answer.json().items()} == {"detail": str}
            seen.add((method, template, answer.status_code))
    assert {("POST", "/api/submissions", status) for status in (201, 401, 403, 422)} <= seen


def test_the_description_says_where_a_token_goes(service: Service) -> None:
    description = service.get("/api/openapi.json").json()
    assert description["components"]["securitySchemes"]["token"]["scheme"] == "bearer"
    secured = {(m, p): operation.get("security") for m, p, operation in _operations(description)}
    assert secured["POST", "/api/submissions"] == secured["GET", "/api/export"] == [{"token": []}]
    assert secured["GET", "/api/submissions/{number}"] == [{"token": []}, {}]
    assert secured["GET", "/api/leaderboard"] is None


def test_a_parameter_that_is_none_is_told_in_a_sentence(service: Service) -> None:
    answer = service.get("/api/leaderboard?kind=finals")
    assert answer.status_code == 422
    assert answer.json() == {"detail": "query.kind: Input should be 'contest' or 'trial'"}


@pytest.mark.parametrize("path", ["/", "/api/leaderboard", "/static/style.css", "/nowhere"])
def test_head_is_answered_as_get(service: Service, path: str) -> None:
    got, asked = service.client.get(path), service.client.head(path)
    assert (asked.status_code, asked.headers["Content-Type"]) == (got.status_code, got.headers["Content-Type"])


def test_answers_are_described_field_by_field(service: Service) -> None:
    """Only uploads were: of all else the description said that it is some object."""
    description = service.get("/api/openapi.json").json()
    number = service.hand_in(service.ours).json()["id"]
    service.evaluate()
    for path in ("/api/leaderboard", "/api/tasks", "/api/submissions", f"/api/submissions/{number}", "/api/export"):
        template = path.replace(number, "{number}")
        described = description["paths"][template]["get"]["responses"]["200"]["content"]["application/json"]["schema"]
        _hold(service.get(path, service.ours).json(), described, description["components"]["schemas"])
    for method, path, operation in _operations(description):
        for status, answer in operation["responses"].items():
            schema = answer.get("content", {}).get("application/json", {}).get("schema", {"$ref": ""})
            assert "$ref" in schema or "$ref" in schema["items"], (method, path, status)


def _hold(value: Any, schema: dict[str, Any], known: dict[str, Any]) -> None:
    """Hold an answer against its description: each field is said, with its type, and what is said to be there is."""
    if "$ref" in schema:
        schema = known[schema["$ref"].rpartition("/")[2]]
    if "anyOf" in schema:
        assert len(schema["anyOf"]) == 2 and schema["anyOf"][1] == {"type": "null"}
        return None if value is None else _hold(value, schema["anyOf"][0], known)
    kinds = {"object": dict, "array": list, "string": str, "integer": int, "number": (int, float), "boolean": bool}
    if "type" in schema:
        assert isinstance(value, kinds[schema["type"]]), (value, schema)
    if isinstance(value, dict) and "properties" in schema:
        assert set(schema.get("required", ())) <= value.keys() <= schema["properties"].keys()
        for name, item in value.items():
            _hold(item, schema["properties"][name], known)
    elif isinstance(value, dict) and isinstance(schema.get("additionalProperties"), dict):
        for item in value.values():
            _hold(item, schema["additionalProperties"], known)
    elif isinstance(value, list) and "items" in schema:
        for item in value:
            _hold(item, schema["items"], known)
    return None
