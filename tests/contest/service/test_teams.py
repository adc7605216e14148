"""Teams: tokens, sessions, and names that could be another's."""

from __future__ import annotations

import pytest

pytest.importorskip("fastapi", reason="the web service needs the extra 'contest'")
pytest.importorskip("sqlalchemy", reason="the web service needs the extra 'contest'")


from tamp.contest.service.teams import add_team, renew_token, team_of
from tamp.errors import TampError
from tests.contest.service.served import CODE, Service


def test_log_in_keeps_the_token_where_scripts_cannot_read_it(service: Service) -> None:
    assert service.client.post("/api/session", json={"token": "wrong"}).status_code == 401
    answer = service.client.post("/api/session", json={"token": service.ours})
    cookie = answer.headers["set-cookie"].lower()
    assert "httponly" in cookie and "samesite=strict" in cookie
    page = service.get("/team")
    assert "Hand in" in page.text and "default-src 'self'" in page.headers["content-security-policy"]
    assert service.client.delete("/api/session").status_code == 200
    assert "Log in" in service.get("/team").text


def test_tokens_are_kept_as_hashes_and_can_be_renewed(service: Service) -> None:
    assert service.ours.encode() not in b"".join(p.read_bytes() for p in service.data.glob("contest.db*"))
    new = renew_token(service.store, "ours")
    assert team_of(service.store, service.ours) is None
    found = team_of(service.store, new)
    assert found is not None and found.name == "ours"
    for name in ("ours", "", "x" * 100, "a\nb", "a\u202eb"):
        with pytest.raises(TampError):
            add_team(service.store, name)
    with pytest.raises(TampError, match="no team called"):
        renew_token(service.store, "nobody")


def test_a_team_is_found_however_its_name_was_typed(service: Service) -> None:
    add_team(service.store, " e\u0301quipe ")
    found = team_of(service.store, renew_token(service.store, "\u00e9quipe"))
    assert found is not None and found == team_of(service.store, renew_token(service.store, "e\u0301quipe "))
    with pytest.raises(TampError, match="there is no team called '\u00c9quipe'; did you mean '\u00e9quipe'"):
        renew_token(service.store, "\u00c9quipe")


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({}, 201),
        ({"Sec-Fetch-Site": "same-origin", "Origin": "https://behind.a.proxy"}, 201),
        ({"Origin": "http://testserver"}, 201),
        ({"Sec-Fetch-Site": "same-site"}, 403),
        ({"Sec-Fetch-Site": "cross-site"}, 403),
        ({"Origin": "http://testserver:9999"}, 403),
        ({"Origin": "null"}, 403),
    ],
)
def test_pages_of_others_do_nothing_with_a_session(service: Service, headers: dict[str, str], status: int) -> None:
    service.client.cookies.set("tamp_contest_token", service.ours)
    answer = service.client.post("/api/submissions", params={"name": "a.py"}, headers=headers, content=CODE)
    assert answer.status_code == status


def test_names_that_look_like_a_teams_are_refused(service: Service) -> None:
    for name in ("Ours", "OURS", "\uff4f\uff55\uff52\uff53"):
        with pytest.raises(TampError, match="looks like the team 'ours'"):
            add_team(service.store, name)
    for name in ("ou\u034frs", "ours\ufe0f", "\u3164ours"):
        with pytest.raises(TampError, match="looks like the team 'ours'"):
            add_team(service.store, name)
    with pytest.raises(TampError, match="characters that can be seen"):
        add_team(service.store, "\u2800 \u3164")
    with pytest.raises(TampError, match="there is a team called"):
        add_team(service.store, "ours")


@pytest.mark.parametrize(
    ("name", "like"),
    [
        ("Nano B1", "\u039d\u0391\u039d\u039f \u0412l"),  # Greek and Cyrillic capitals
        ("copy 10", "\u0441\u043e\u0440\u0443 I0"),
        ("Lodz", "\u0141\u00f3d\u017a"),
        ("modern-1", "modem\u2013l"),
        ("oak's", "\u00d8\u0430\u043a\u2019\u0455"),
        ("\u529b\u58eb", "\u30ab\u58eb"),  # Han and Katakana
    ],
)
def test_letters_that_are_drawn_alike_tell_no_teams_apart(service: Service, name: str, like: str) -> None:
    add_team(service.store, name)
    with pytest.raises(TampError, match=rf"looks like the team {name!r}|mixes letters of Cyrillic and Latin"):
        add_team(service.store, like)


def test_a_word_of_a_teams_name_is_in_one_script(service: Service) -> None:
    for name in ("\u043eurs too", "te\u03b1m", "Team \u09ea", "\u13aaB"):
        with pytest.raises(TampError, match=r"is in one script|not in general use"):
            add_team(service.store, name)
    honest = (
        "\u041a\u043e\u043c\u0430\u043d\u0434\u0430 ML 2",
        "\u6a21\u578b\u30c1\u30fc\u30e0 A",
        "\u0939\u093f\u0928\u094d\u0926\u0940",
        "\ub85c\ubd07 Lab",
        "\u02bbOkina",
        "C3-PO & R2-D2",
        "\U0001f916 bots",
        "\u0e44\u0e17\u0e22 \u0e51",
    )
    for name in honest:
        add_team(service.store, name)


def test_what_is_no_upload_is_small(service: Service) -> None:
    answer = service.client.post("/api/session", json={"token": "x" * 10_000})
    assert answer.status_code == 413 and "content-security-policy" in answer.headers
    chunks = (b'{"token":' for _ in range(10))
    assert service.client.post("/api/session", content=chunks).status_code == 413
    for token in ('"\\ud800"', '"\\u0000"', '"\\u00e9"'):
        answer = service.client.post(
            "/api/session", content=f'{{"token": {token}}}', headers={"Content-Type": "application/json"}
        )
        assert answer.status_code == 401
