"""The command line in another language: every word that people read; what programs read doesn't."""

import gettext
import json
import os
import re

import click
import pytest
from pseudolocale import PseudoTranslations

from kogao_core import cli
from kogao_core.base import language
from kogao_core.cli import commands as commands_of_cli
from kogao_core.cli import words
from kogao_core.cli.integrate import HOSTS
from kogao_core.faces.landmarks import CHOICES
from kogao_core.recipe.recipe import SETTINGS

WORD = re.compile(r"[A-Za-z]{2,}")
# What is typed or shown as it is: options, what stands for a value, files, places, programs.
NAMES = re.compile(
    r"--?[a-z][\w-]*|\b[A-Z]+(?:x[A-Z]+)?\b|\S*[./_\\]\S+|'[^']*'|\{\w+\}|\[[\w|-]+\]|kogao-cli|px|json|png|Kogao"
)


def commands(command=commands_of_cli.program, way=()):
    yield way, command
    if isinstance(command, click.Group):
        for name, inner in command.every.items():
            yield from commands(inner, (*way, name))


COMMANDS = {" ".join(way): command for way, command in commands()}
# Of programs and of units, wherever they stand.
NAMED = {"satisfaction", "WebP", "ms", *HOSTS}
# What is typed, or is a key in a file.
TYPED = {*NAMED, *(word for way in COMMANDS for word in way.split())}
TYPED |= {one.name for setting in SETTINGS.values() for one in setting.alternatives}
TYPED |= {choice.name for choice in CHOICES} | {"all", "both", "control", "points", "lanczos"}
TYPED |= {"desktop", *language.languages(), "percent", "format", "faces", "fit"}
TYPED |= {"drop", "amount"}


def plain(text, names=TYPED):
    """Words that nobody translated."""
    return [word for word in WORD.findall(NAMES.sub(" ", text)) if word not in names]


def test_every_option_of_every_command_is_told_in_the_users_language():
    for command in COMMANDS.values():
        assert isinstance(command, words.Command)
        options = [one for one in command.params if isinstance(one, click.Option)]
        assert all(isinstance(one, words.Option) for one in options)


@pytest.mark.usefixtures("pseudolocale")
@pytest.mark.parametrize("way", COMMANDS, ids=lambda way: way or "kogao-cli")
def test_every_word_of_help_is_translated(way, capsys):
    with pytest.raises(SystemExit):
        commands_of_cli.program.main([*way.split(), "--help"], prog_name="kogao-cli")
    whole = re.sub(r"-\n +", "-", capsys.readouterr().out)  # a line may end within an option
    lines = [line for line in whole.splitlines() if not line.startswith("  kogao-cli")]
    assert [(line, plain(line)) for line in lines if plain(line)] == []


@pytest.mark.usefixtures("english")
def test_help_is_said_in_one_language_after_another(gathered, capsys):
    for catalogue in (gettext.NullTranslations(), PseudoTranslations(gathered)):
        language.use_catalogue("xx", catalogue)
        with pytest.raises(SystemExit):
            commands_of_cli.program.main(["warp", "--help"], prog_name="kogao-cli")
        assert catalogue.gettext("Show this message and exit.") in capsys.readouterr().out


@pytest.fixture
def said(pseudolocale, monkeypatch, capsys):  # noqa: ARG001
    """What the program prints in a language that nobody speaks, and how it ends."""
    monkeypatch.setattr(commands_of_cli, "use_language", lambda *_: None)

    def run(*arguments):
        with pytest.raises(SystemExit) as end:
            cli.main(list(map(str, arguments)))
        printed = capsys.readouterr()
        return end.value.code, printed.out + printed.err

    return run


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (["warp"], 2),
        (["warp", "--sample"], 2),
        (["nothing"], 2),
        (["warp", "--nothing"], 2),
        (["warp", "--amount", "many"], 2),
        (["warp", "--sample", "-o", "a.png", "--amount", "99"], 2),
        (["warp", "--sample", "-o", "a.png", "--protect", "here"], 2),
        (["warp", "--sample", "-o", "a.png", "--fit", "tight"], 2),
        (["warp", "--sample", "-o", "a.gif"], 2),
        (["warp", "--sample", "-o", "no.folder/a.png"], 3),
        (["warp", "none.jpg", "-o", "a.png"], 3),
        (["warp", "empty.jpg", "-o", "a.png"], 3),
        (["warp", "broken.jpg", "-o", "a.png"], 3),
        (["warp", "text.jpg", "-o", "a.png"], 3),
        (["warp", "--sample", "-o", "a.png", "--project", "broken.json"], 2),
        (["warp", "--sample", "-o", "a.png", "--recipe", "broken.json"], 2),
        (["warp", "--sample", "-o", "a.png", "--points", "points.json"], 3),
        (["batch", "no.folder", "-o", "out"], 2),
        (["experiment", "timing", "--sample", "--trials", "no.file"], 3),
        (["presets", "no.preset"], 2),
        (["restore", "none.jpg"], 2),
        (["experiment", "timing"], 2),
        (["experiment", "study", "report", "no.folder"], 3),
    ],
    ids=str,
)
def test_every_word_of_an_error_is_translated(arguments, code, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty.jpg").touch()
    (tmp_path / "text.jpg").write_text("a text, not a photo")
    (tmp_path / "broken.jpg").write_bytes(b"\xff\xd8\xff\xe0 and no more")
    (tmp_path / "broken.json").write_text('{"version": "x"}')
    (tmp_path / "points.json").write_text('{"faces": "x"}')
    ended, text = said(*arguments)
    text = text.replace(str(tmp_path), "")
    assert (ended, plain(text)) == (code, []), text


def test_what_programs_read_is_english(said, tmp_path):
    file = tmp_path / "small.json"
    code, text = said("warp", "--sample", "-o", tmp_path / "a.jpg", "--json", file)
    assert (code, plain(text.replace(str(tmp_path), ""), NAMED)) == (0, []), text
    notes = json.loads(file.read_text())["notes"]
    assert any("of the JPEG unchanged" in note for note in notes)


@pytest.mark.parametrize(
    "arguments",
    [
        ["domains"],
        pytest.param(["timing", "--warm-up", "0"], marks=pytest.mark.slow),
        pytest.param(["methods"], marks=pytest.mark.slow),
        pytest.param(["distortion"], marks=pytest.mark.slow),
    ],
    ids=str,
)
def test_every_word_of_a_report_is_translated(arguments, said, small_portrait, tmp_path):
    """On the terminal and in the page; names of other methods and of libraries are names."""
    repeats = [] if "distortion" in arguments else ["--repeats", "1"]
    code, text = said("experiment", *arguments, *repeats, small_portrait, "-o", tmp_path / "out")
    assert code == 0
    (page,) = (tmp_path / "out").glob("*.html")
    assert unknown(text, page, small_portrait) == []


def test_every_word_of_a_study_is_translated(said, small_portrait, tmp_path):
    folder, page = tmp_path / "faces", tmp_path / "faces.html"
    code, text = said("experiment", "study", "make", small_portrait, "-o", folder, "--seed", "8")
    assert (code, plain(text.replace(str(tmp_path), ""))) == (0, []), text
    code, text = said("experiment", "study", "report", folder, "--html", page)
    assert code == 0
    assert unknown(text, page, small_portrait) == []


def unknown(text, page, photo):
    """Lines of a report, on the terminal and in the page, with words that nobody translated."""
    html = re.sub(r"<style>.*?</style>|<pre>.*", "", page.read_text(encoding="utf-8"), flags=re.S)
    heard = re.findall(r'(?:alt|aria-label)="([^"]*)"', html)
    lines = [*text.splitlines(), *re.sub(r"<[^>]*>", "\n", html).splitlines(), *heard]
    names = {"scipy", "scikit", "image", "wdr"}
    names |= {"rigid", "mesh", "radial", "moving", "thin", "plate", "lt", *NAMED}
    digest = re.compile(r"\b[0-9a-f]{12,16}\b")
    lines = [digest.sub("", line.replace(str(photo), "")) for line in lines]
    return [(line, plain(line, names)) for line in lines if plain(line, names)]


@pytest.mark.usefixtures("english")
@pytest.mark.parametrize("way", [("--language", "ja"), ("--language=ja",)])
def test_the_language_is_chosen_by_an_option(way, catalogues, tmp_path, monkeypatch, capsys):
    (tmp_path / "ja.po").write_text(
        'msgid "Overwrite existing files"\nmsgstr "見本"\n', encoding="utf-8"
    )
    catalogues.compile_all(tmp_path)
    monkeypatch.setattr(language, "_folder", lambda: tmp_path)
    with pytest.raises(SystemExit):
        cli.main([*way, "presets", "--help"])
    assert "見本" in capsys.readouterr().out
    assert os.environ["LANGUAGE"] == "ja", "processes that it starts speak it, too"


def test_an_unknown_language_is_refused(capsys):
    with pytest.raises(SystemExit) as end:
        cli.main(["--language", "tlh", "doctor"])
    assert end.value.code == 2
    assert "'tlh' is none of en, " in capsys.readouterr().err
