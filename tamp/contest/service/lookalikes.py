"""Names that could be taken for each other: what a name looks like, and in which scripts it is written.

After Unicode's security mechanisms (UTS 39): letters of one script in a word, of those in everyday use, and of each
letter what it is drawn like. Letters are known by the names that Unicode gives them.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping
from types import MappingProxyType

UNSEEN = re.compile("[\u034f\u115f\u1160\u17b4\u17b5\u180b-\u180f\u2800\u3164\ufe00-\ufe0f\uffa0\U000e0100-\U000e01ef]")
"""Letters, marks and symbols that are not drawn: what Unicode calls default ignorable, and the empty Braille one."""

ACCENTS = re.compile("[\u0300-\u036f\u1ab0-\u1aff\u1dc0-\u1dff\u20d0-\u20ff\ufe20-\ufe2f]")
"""Marks on letters of any script, which are easily overlooked; scripts whose vowels are marks have their own."""

EVERYDAY = frozenset(
    {
        "ARABIC", "ARMENIAN", "BENGALI", "BOPOMOFO", "CJK", "CYRILLIC", "DEVANAGARI", "ETHIOPIC", "GEORGIAN", "GREEK",
        "GUJARATI", "GURMUKHI", "HANGUL", "HEBREW", "HIRAGANA", "KANNADA", "KATAKANA", "KHMER", "LAO", "LATIN",
        "MALAYALAM", "MYANMAR", "ORIYA", "SINHALA", "TAMIL", "TELUGU", "THAANA", "THAI", "TIBETAN",
    }
)  # fmt: skip
"""Scripts in general use (UAX 31, table 5), as the names of their letters begin."""

TOGETHER = tuple(frozenset({"LATIN", "CJK", *more}) for more in ({"HIRAGANA", "KATAKANA"}, {"BOPOMOFO"}, {"HANGUL"}))
"""Scripts that are written together (UTS 39, "highly restrictive")."""

OF_NONE = frozenset({"COMBINING", "MODIFIER", "IDEOGRAPHIC", "DIGIT"})
"""How the names of marks, letters and digits begin that are used in several scripts."""

LATIN = re.compile(r"LATIN (SMALL|CAPITAL) LETTER (?:DOTLESS |SCRIPT )?([A-Z])(?: WITH .*)?")
SMALL_CAPITAL = re.compile(r"LATIN LETTER SMALL CAPITAL ([A-Z])")
VARIANT = re.compile(" WITH .*")


def _table(prefix: str, pairs: str) -> dict[str, str]:
    return {f"{prefix} LETTER {name.replace('_', ' ')}": like for name, like in (p.split(":") for p in pairs.split())}


DRAWN_LIKE: Mapping[str, str] = MappingProxyType(
    {
        **_table("LATIN SMALL", "ALPHA:a OPEN_E:e IOTA:i UPSILON:u GAMMA:y AE:ae"),
        **_table("LATIN CAPITAL", "ALPHA:a IOTA:l AE:AE"),
        **_table(
            "CYRILLIC SMALL",
            "A:a VE:b GHE:r IE:e IO:e KA:k EM:m EN:h O:o PE:n ER:p ES:c TE:t U:y HA:x BYELORUSSIAN-UKRAINIAN_I:i YI:i "
            "JE:j DZE:s SHHA:h KOMI_DE:d PALOCHKA:l QA:q WE:w IZHITSA:v STRAIGHT_U:y OMEGA:w SCHWA:e",
        ),
        **_table(
            "CYRILLIC CAPITAL",
            "A:A VE:B IE:E IO:E KA:K EM:M EN:H O:O ER:P ES:C TE:T U:Y HA:X BYELORUSSIAN-UKRAINIAN_I:l YI:l JE:J DZE:S "
            "SHHA:h KOMI_SJE:G QA:Q WE:W IZHITSA:V STRAIGHT_U:Y ZE:3 BE:6",
        ),
        **_table(
            "GREEK SMALL",
            "ALPHA:a GAMMA:y EPSILON:e ETA:n IOTA:i KAPPA:k NU:v OMICRON:o RHO:p SIGMA:o TAU:t UPSILON:u CHI:x OMEGA:w",
        ),
        **_table(
            "GREEK CAPITAL",
            "ALPHA:A BETA:B EPSILON:E ZETA:Z ETA:H IOTA:l KAPPA:K MU:M NU:N OMICRON:O RHO:P TAU:T UPSILON:Y CHI:X",
        ),
        "CYRILLIC LETTER PALOCHKA": "l",
        "GREEK LUNATE SIGMA SYMBOL": "c",
        "GREEK CAPITAL LUNATE SIGMA SYMBOL": "C",
        "GREEK LETTER YOT": "j",
        "GREEK CAPITAL LETTER YOT": "J",
        **_table("ARMENIAN SMALL", "OH:o HO:h SEH:u VO:n CO:g ZA:q GIM:q YIWN:l"),
        **_table("ARMENIAN CAPITAL", "OH:O SEH:U TIWN:S LIWN:L"),
        **_table(
            "KATAKANA", "NI:\u4e8c RO:\u53e3 E:\u5de5 KA:\u529b TA:\u5915 TO:\u535c HA:\u516b HE:\u3078 RI:\u308a"
        ),
        "KATAKANA-HIRAGANA PROLONGED SOUND MARK": "\u4e00",
    }
)
"""Letters -> what else they could be read as; capital I is a small l."""

_STROKES = str.maketrans(
    {**dict.fromkeys("I1|\u01c0\u2223", "l"), "0": "O", **dict.fromkeys("\u2018\u2019\u02bb\u02bc\u00b4\u2032`", "'")}
)


def alike(name: str) -> frozenset[str]:
    """What two names that could be taken for each other have in common: how they are read, and how they look."""
    return frozenset({_plain(name), _look(name)})


def _plain(name: str) -> str:
    """A name without what hardly tells it apart: capitals, widths, ligatures, how many spaces, what cannot be seen."""
    return " ".join(UNSEEN.sub("", unicodedata.normalize("NFKC", name)).casefold().split())


def _look(name: str) -> str:
    """How a name is drawn, in Latin letters where it could be some."""
    letters = unicodedata.normalize("NFC", UNSEEN.sub("", name)).translate(_STROKES)
    drawn = ACCENTS.sub("", "".join(_drawn(c) for c in letters)).translate(_STROKES).casefold()
    return " ".join(drawn.replace("rn", "m").replace("vv", "w").split())


def _drawn(letter: str) -> str:
    """What a letter could be read as; itself, without accents, where that is nothing else."""
    if letter.isascii():
        return letter
    if unicodedata.category(letter) == "Pd":
        return "-"
    called = VARIANT.sub("", unicodedata.name(letter, ""))
    if called in DRAWN_LIKE:
        return DRAWN_LIKE[called]
    if found := LATIN.fullmatch(called):
        return found[2] if found[1] == "CAPITAL" else found[2].lower()
    if found := SMALL_CAPITAL.fullmatch(called):
        return found[1].lower()
    parts = unicodedata.normalize("NFKD", letter)
    return letter if parts == letter else "".join(map(_drawn, parts))


def misleading(name: str) -> str:
    """Why a name may be read as another, whatever others there are; empty where each word is in a script of its own."""
    for word in re.split(r" +(?!\d)", UNSEEN.sub("", name)):  # a number is read with the word before it
        used = _scripts(word)
        if rare := sorted(used - EVERYDAY):
            return f"{word!r} has letters of {_listed(rare)}, which is not in general use today"
        if len(used) > 1 and not any(used <= some for some in TOGETHER):
            return f"{word!r} mixes letters of {_listed(sorted(used))}; a word of a team's name is in one script"
    return ""


def _scripts(word: str) -> frozenset[str]:
    """The scripts in which letters, vowel marks and digits are, as Unicode calls them."""
    letters = (c for c in unicodedata.normalize("NFKC", word) if unicodedata.category(c)[0] in "LM" or c.isdecimal())
    return frozenset(re.split("[ -]", unicodedata.name(c, "UNKNOWN"))[0] for c in letters) - OF_NONE


def _listed(names: list[str]) -> str:
    return " and ".join(name if name == "CJK" else name.capitalize() for name in names)
