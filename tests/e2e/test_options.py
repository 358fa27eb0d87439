"""An option means the same in every command."""

import json
import re
from collections import defaultdict

import click
import pytest

from kogao_core.cli import common
from kogao_core.cli.commands import program
from kogao_core.cli.words import Option

# Many photos into a folder, where the sample would only be in the way.
TAKES_NO_SAMPLE = {("batch",), ("read",)}
FINDS_NO_FACES = {("restore",), ("originals",), ("forget",)}


def leaves(command, way=()):
    if isinstance(command, click.Group):
        for name, below in command.every.items():
            yield from leaves(below, (*way, name))
    else:
        yield way, command


COMMANDS = dict(leaves(program))


def options():
    for way, command in COMMANDS.items():
        for option in command.params:
            if isinstance(option, click.Option):
                for spelled in option.opts:
                    yield spelled, way, option


def test_it_takes_the_same_kind_of_value():
    kinds = defaultdict(set)
    for spelled, _, one in options():
        kinds[spelled].add((one.is_flag, one.multiple, one.nargs, one.type.name, one.metavar))
    # The photo of `warp`, and a folder of whatever makes several files.
    del kinds["-o"], kinds["--output"]
    assert {spelled: found for spelled, found in kinds.items() if len(found) > 1} == {}


def given(*options):
    for option in options:
        yield option.opts[0]
        if not option.is_flag:
            yield option.type.choices[0] if isinstance(option.type, click.Choice) else "1"


PARTNERS = [
    (way, command, option)
    for way, command in COMMANDS.items()
    for option in command.params
    if isinstance(option, Option) and (option.needs or option.excludes)
]


@pytest.mark.parametrize(
    ("way", "command", "option"),
    PARTNERS,
    ids=[f"{'-'.join(way)} {option.opts[0]}" for way, _, option in PARTNERS],
)
def test_an_option_that_would_say_nothing_is_refused(
    cli, tmp_path, monkeypatch, way, command, option
):
    monkeypatch.chdir(tmp_path)
    known = {name: one for one in command.params for name in one.opts}
    required = [one for one in command.params if one.required and one is not option]
    call = [*way, *given(*(one for one in required if one.opts[0].startswith("-")))]
    call += ["photo.jpg" for one in required if isinstance(one, click.Argument)]
    name = option.opts[0]
    wrong = [([], f"{name} needs {option.needs}")] if option.needs else []
    wrong += [(known[one], f"{name} and {one} don't go together") for one in option.excludes]
    assert option.needs is None or option.needs in known
    for others, sentence in wrong:
        code, said, err = cli(*call, *given(option, *([others] if others else [])))
        assert (code, said) == (2, "")
        assert re.fullmatch(rf"kogao-cli: {sentence}[^\n]+\n", err), err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("way", "command"), COMMANDS.items(), ids=map(" ".join, COMMANDS))
def test_whoever_takes_photos_takes_the_sample_and_says_how_to_find_faces(way, command):
    spelled = {opt for option in command.params for opt in option.opts}
    is_photo = any(one.type is common.PHOTO for one in command.params)
    if is_photo and way not in FINDS_NO_FACES:
        assert {"--landmarks", "--max-megapixels"} <= spelled
        assert "--sample" in spelled or way in TAKES_NO_SAMPLE
    if "--json" in spelled:
        assert "--force" in spelled


@pytest.mark.parametrize(
    "arguments", [("detect", "{photo}"), ("doctor",), ("warp", "{photo}", "-o", "{folder}/o.png")]
)
def test_json_goes_to_a_file_or_is_printed_in_place_of_the_text(
    cli, small_portrait, tmp_path, arguments
):
    arguments = [one.format(photo=small_portrait, folder=tmp_path) for one in arguments]
    file = tmp_path / "found.json"
    code, text, err = cli(*arguments, "--json", file)
    written = json.loads(file.read_text())
    assert (err, text[:1] != "{") == ("", True)
    assert cli(*arguments, "--json", file)[0] == 2
    again, printed, _ = cli(*arguments, "--json", "-", "--force")
    assert again == code
    assert json.loads(printed).keys() == written.keys()
    assert cli(*arguments, "--json", file, "--force")[0] == code
    _, bare, _ = cli(*arguments, "--force", "--json")
    assert json.loads(bare).keys() == written.keys()


@pytest.mark.parametrize(
    ("file", "code", "words"),
    [
        ("{photo}", 2, "is a photo; name a report file, or - for standard output"),
        ("{folder}/none/x.json", 3, "create the folder first"),
        ("{folder}", 2, "is a directory"),
    ],
)
def test_a_json_file_that_cannot_be_is_refused_before_work_begins(
    cli, small_portrait, tmp_path, file, code, words
):
    before = small_portrait.read_bytes()
    given = file.format(photo=small_portrait, folder=tmp_path)
    out = tmp_path / "out.png"
    found, text, err = cli("warp", small_portrait, "-o", out, "--json", given, "--force")
    assert (found, text) == (code, "")
    assert words in err
    assert not out.exists()
    assert small_portrait.read_bytes() == before


@pytest.mark.parametrize("kind", ["json", "csv", "html"])
def test_a_report_never_goes_over_a_photo(cli, small_portrait, kind):
    before = small_portrait.read_bytes()
    code, _, err = cli("experiment", "domains", "--sample", f"--{kind}", small_portrait, "--force")
    assert (code, "is a photo; name a report" in err) == (2, True)
    assert small_portrait.read_bytes() == before


@pytest.mark.parametrize(
    ("command", "made"),
    [
        (("landmarks", "export", "--format", "csv"), "{stem}.csv"),
        (("experiment", "study", "make", "--lattices", "1"), "study.json"),
    ],
)
def test_many_photos_are_files_folders_or_the_sample(
    cli, works, small_portrait, tmp_path, command, made
):
    (tmp_path / "in" / "below").mkdir(parents=True)
    (tmp_path / "in" / "below" / "me.jpg").write_bytes(small_portrait.read_bytes())
    (tmp_path / "in" / "notes.txt").touch()
    for given, stem in ((tmp_path / "in", "me"), ("--sample", "average")):
        out = tmp_path / f"out-{stem}"
        works(*command, given, "-o", out)
        assert (out / made.format(stem=stem)).is_file()
    (tmp_path / "empty").mkdir()
    for given, words in (
        ((), "or use --sample"),
        ((small_portrait, "--sample"), "or use --sample"),
        ((tmp_path / "empty",), "no photo found in"),
    ):
        code, _, err = cli(*command, *given, "-o", tmp_path / "none")
        assert (code, words in err) == (2, True)
    assert not (tmp_path / "none").exists()
