"""The package speaks the standard English of NumPy's reference and of a vibration textbook."""

from __future__ import annotations

import io
import re
import tokenize
from collections import defaultdict

import pytest

from tests.audits.source import FILES, expect_none, text

#: Standard term: (words of docstrings, comments and messages that it replaces, words between underscores in identifiers).
VOCABULARY = {
    "reported": (r"told|says", "told says"),
    "impulsive load, jump": (r"blows?|str(?:ikes?|uck|iking)|kick(?:s|ed|ing)?", "blow blows strike strikes struck kick kicks"),
    "restoring force": (r"pull(?:s|ed|ing)? back", ""),
    "constrained": (r"nothing holds?|held", "held"),
    "restarts, is delayed": (r"anew|begins? later", "anew"),
    "excitation, load": (r"push(?:es|ed|ing)?", "drive push"),
    "proportional (Rayleigh) damping": (r"in proportion", ""),
    "relative to, next to": (r"beside", "beside"),
    "(well) separated": (r"(?:driven|hardly|told|tells?|telling|comes?|came|well|far|taken|kept|set) apart", "apart"),
    "rounding error": (r"(?:a|the|one) rounding(?! errors?\b)", ""),
    "sparse topology (tree, ring, band)": (r"(?:few|by) couplings", "couplings"),
    "directly reducible": (r"(?:is|are|not) plain|plain (?:problems?|models?)", "plain"),
    "method": (r"", "way ways"),
    "scaling factors": (r"knobs?", "knob knobs"),
    "validation": (r"doors?", "door doors"),
    "jumps and impulses": (r"happenings?", "happening happenings"),
    "static correction": (r"", "carried"),
    "the noun": (r"that which", "found made asked seen taken"),
}

#: Occurrences that remain, by standard term. The numbers may only fall.
NOT_YET_REPLACED = {
    "the noun": 6,
    "sparse topology (tree, ring, band)": 8,
}

TEXTS = {term: re.compile(rf"\b(?:{words})\b", re.IGNORECASE) for term, (words, _) in VOCABULARY.items() if words}
NAMES = {part: term for term, (_, names) in VOCABULARY.items() for part in names.split()}
STRINGS = (tokenize.STRING, tokenize.COMMENT, getattr(tokenize, "FSTRING_MIDDLE", tokenize.STRING))


def occurrences(file):
    """(standard term, line, excerpt) of every word of a file that the vocabulary replaces."""
    for token in tokenize.generate_tokens(io.StringIO(text(file)).readline):
        if token.type in STRINGS:
            for term, pattern in TEXTS.items():
                for match in pattern.finditer(token.string):
                    line = token.start[0] + token.string[: match.start()].count("\n")
                    yield term, line, " ".join(token.string[max(match.start() - 30, 0) : match.end() + 30].split())
        elif token.type == tokenize.NAME:
            for part in {*token.string.lower().split("_")} & set(NAMES):
                yield NAMES[part], token.start[0], token.string


@pytest.mark.long
def test_texts_and_names_use_the_vocabulary():
    lines = defaultdict(list)
    for file in FILES:
        for term, line, excerpt in occurrences(file):
            lines[term].append(f"{file}:{line} {excerpt!r} -> {term}")
    counts = {term: len(entries) for term, entries in lines.items()}
    excess = [entry for term, entries in lines.items() if counts[term] > NOT_YET_REPLACED.get(term, 0) for entry in entries]
    expect_none(excess, f"use the standard term; now {counts}")
