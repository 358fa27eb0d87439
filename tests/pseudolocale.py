"""A language that nobody speaks: longer words in letters with marks, every {field} kept.

What was not translated shows by its plain letters, and what is cut by its length.
"""

import gettext
import re

_MARKED = str.maketrans(
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz",
    "ÀßÇÐÈƑĜĤÌĴĶĹṀÑÒÞǪŔŠŢÛṼŴẊÝŽàƀçđèƒĝĥìĵķĺṁñòþǫŕšţûṽŵẋýž",
)
# Fields, mnemonics, what argparse and terminals read otherwise.
_KEPT = re.compile(r"(\{[^{}]*\}|&\w|%%|%\(\w+\)[sr]|%[sr]|<[^<>]*>)")
LONGER = 1.4


def pseudo(text: str) -> str:
    parts = _KEPT.split(text)
    said = "".join(p if _KEPT.fullmatch(p) else p.translate(_MARKED) for p in parts)
    letters = sum(map(str.isalpha, text))
    more = round((LONGER - 1.0) * letters)
    return said + "ōū"[: more % 2 + 1] * (more // 2) if letters > 2 else said


class PseudoTranslations(gettext.NullTranslations):
    """A catalogue that has every text that was gathered, and no other."""

    def __init__(self, gathered):
        super().__init__()
        self._gathered = gathered

    def gettext(self, message):
        return pseudo(message) if message in self._gathered else message

    def ngettext(self, msgid1, msgid2, n):
        return self.gettext(msgid1 if n == 1 else msgid2)
