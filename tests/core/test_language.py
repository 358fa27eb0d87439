"""Both programs speak the user's language from one catalogue; what programs read stays English."""

import ast
import gettext
import json
import os
import pickle
import re
import string

import pytest
from modules import ROOT, modules, tree

from kogao_core.base import language
from kogao_core.base.language import Text, TextError, tr, tr_count, translated

CATALOGUES = sorted((ROOT / "resources" / "translations").glob("*.po"))


class German(gettext.NullTranslations):
    """A few words of a language with its own plural."""

    def gettext(self, message):
        words = {"{path} is {mib:.1f} MiB large": "{mib:.1f} MiB groß ist {path}", "empty": "leer"}
        return words.get(message, message)

    def ngettext(self, msgid1, msgid2, n):
        assert (msgid1, msgid2) == ("{n} face", "{n} faces")
        return "{n} Gesicht" if n == 1 else "{n} Gesichter"


@pytest.fixture
def german(english):  # noqa: ARG001
    language.use_catalogue("de", German())


@pytest.mark.usefixtures("german")
def test_a_text_is_its_english_and_is_said_in_the_language_at_work():
    text = Text("{path} is {mib:.1f} MiB large", path="a.jpg", mib=1.25)
    assert text == "a.jpg is 1.2 MiB large"
    assert json.dumps({"note": text}) == '{"note": "a.jpg is 1.2 MiB large"}'
    assert translated(text) == "1.2 MiB groß ist a.jpg"
    assert tr("empty") == "leer"


@pytest.mark.usefixtures("german")
def test_a_text_within_a_text_is_translated_with_it():
    outer = Text("{path}: {problem}", path="empty", problem=ValueError(Text("empty")))
    assert (outer, translated(outer)) == ("empty: empty", "empty: leer"), "a name stays a name"
    assert translated(Text.joined("; ", [Text("empty"), "", "a.jpg"])) == "leer; a.jpg"


@pytest.mark.usefixtures("german")
def test_a_text_that_counts_takes_the_languages_plural():
    texts = [Text.counted(n, "{n} face", "{n} faces") for n in (1, 3)]
    assert texts == ["1 face", "3 faces"]
    assert [translated(text) for text in texts] == ["1 Gesicht", "3 Gesichter"]
    assert tr_count(2, "{n} face", "{n} faces") == "2 Gesichter"


@pytest.mark.usefixtures("german")
def test_an_exception_keeps_its_text_in_another_process_too():
    problem = pickle.loads(
        pickle.dumps(TextError("{path} is {mib:.1f} MiB large", path=ROOT / "a", mib=2.5))
    )
    assert translated(problem) == f"2.5 MiB groß ist {ROOT / 'a'}"
    assert translated(OSError(2, "No such file")) == "[Errno 2] No such file", "not ours"


def test_braces_in_values_and_in_texts_without_fields_stay():
    assert translated(Text("a name such as {this}")) == "a name such as {this}"
    assert translated(Text("{name} is a name", name="{this}")) == "{this} is a name"


@pytest.mark.usefixtures("english", "spoken")
@pytest.mark.parametrize(
    ("environment", "found"),
    [
        ({"LANGUAGE": "xx:ja_JP", "LANG": "C"}, "ja"),
        ({"LC_ALL": "ja_JP.UTF-8", "LANG": "de_DE.UTF-8"}, "ja"),
        ({"LANG": "ja"}, "ja"),
        ({"LANGUAGE": "en_GB:ja"}, "en"),
        ({"LANG": "C.UTF-8"}, "en"),
        ({"LANG": "xx"}, "en"),
        ({}, "en"),
    ],
)
def test_the_system_says_which_language(environment, found, monkeypatch):
    for name in ("LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG"):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    assert language.use_language(*language.system_languages()) == found == language.language()
    # Other programs, and reasons of the system, keep a language that we lack.
    said = None if environment in ({"LANG": "xx"}, {}) else found
    assert os.environ.get("LANGUAGE") == said


def test_the_core_speaks_of_a_commands_options_by_the_commands_name(catalogues):
    """Editor and programs in Python say its sentences, too."""
    options = re.compile(r"(?<![\w-])--[a-z]")
    for one in catalogues.gathered():
        places = [place for place, _ in one.locations]
        if any(re.match("kogao_core/(?!cli/|lab/commands/)", place) for place in places):
            for text in one.id if one.pluralizable else [one.id]:
                assert re.search("kogao-cli|pip", text) or not options.search(text), text


@pytest.mark.parametrize("path", CATALOGUES, ids=lambda path: path.stem)
def test_every_catalogue_has_every_text_and_keeps_its_fields(path, catalogues):
    catalogue, words = catalogues.read(path), catalogues.gathered()
    missing = [one.id for one in words if one.id and catalogue.get(one.id, one.context) is None]
    assert missing == [], "python -m resources.catalogues brings the catalogues up to date"
    for one in catalogue:
        asked, said = map(forms, (one.id, one.string))
        known = {name for text in asked for name in fields(text)}
        for text in filter(None, said if asked[0] else ()):
            assert fields(text) <= known, one.id
            assert fields(text) | {"n"} >= fields(asked[-1]), "only a number may go without saying"


def forms(texts):
    """What is said of one and of many, or just what is said."""
    return (texts,) if isinstance(texts, str) else tuple(texts)


def fields(text):
    """The names of a text's fields, and those of the older kind."""
    named = {name for _, name, _, _ in string.Formatter().parse(text) if name}
    return named | set(re.findall(r"%(?:\(\w+\))?[sr]", text))


def test_words_of_every_exception_are_found(catalogues):
    classes = [
        (node.name, {base.id for base in node.bases if isinstance(base, ast.Name)})
        for folder in ("kogao_core", "app")
        for path in modules(folder, ROOT).values()
        for node in ast.walk(tree(path))
        if isinstance(node, ast.ClassDef)
    ]
    known = {"TextError", *catalogues.RAISED}
    assert {name for name, bases in classes if bases & known} == {
        name for name in catalogues.RAISED if name[0].isupper() and name != "Stop"
    }


def test_words_that_are_put_together_are_refused(catalogues):
    texts = ('tr(f"a {b}")', 'Text("a" + b)', 'option("--a", help=f"{a}")', 'BadFile(f"{a}")')
    for source in (*texts, "tr(a)"):
        with pytest.raises(catalogues.NotALiteral, match=r"a\.py:1"):
            list(catalogues.words(source, "a.py"))


def test_words_are_found_wherever_they_are_marked(catalogues):
    source = '''
# Translators: what follows
# is short.
tr("{a} b", a=
    Text("within"))
Text.counted(n, "{n} c", "{n} cs")
in_context("d", "e")
raise Stop("g", code) if a else BadFile(a)
@words.command("f")
def command():
    """Do f."""
'''
    found = {one.texts: (one.context, one.comment) for one in catalogues.words(source, "a.py")}
    assert found == {
        ("{a} b",): (None, "what follows is short."),
        ("within",): (None, ""),
        ("{n} c", "{n} cs"): (None, ""),
        ("e",): ("d", ""),
        ("g",): (None, ""),
        ("Do f.",): (None, ""),
    }
