"""An option means the same in every command."""

import json
import re

import click
import pytest

from kogao_core.cli import common
from kogao_core.cli.commands import program
from kogao_core.cli.words import Option

# Many photos into a folder, where the sample would only be in the way.
TAKES_NO_SAMPLE = {"batch"}


def leaves(command, name=""):
    if isinstance(command, click.Group):
        for below, one in command.every.items():
            yield from leaves(one, below)
    else:
        yield name, command


COMMANDS = dict(leaves(program))


def options():
    for name, command in COMMANDS.items():
        for option in command.params:
            if isinstance(option, click.Option):
                for spelled in option.opts:
                    yield spelled, name, option


# `-o` is the photo of `warp`, and a folder of whatever makes several files.
SHARED = sorted({spelled for spelled, _, _ in options()} - {"-o", "--output"})


@pytest.mark.parametrize("spelled", SHARED)
def test_it_takes_the_same_kind_of_value(spelled):
    kinds = {
        name: (option.is_flag, option.multiple, option.nargs, option.type.name, option.metavar)
        for known, name, option in options()
        if known == spelled
    }
    assert len(set(kinds.values())) == 1, kinds


def paths(command, before=()):
    if isinstance(command, click.Group):
        for name, below in command.commands.items():
            yield from paths(below, (*before, name))
    else:
        yield before, command


def given(*options):
    for option in options:
        yield option.opts[0]
        if not option.is_flag:
            yield option.type.choices[0] if isinstance(option.type, click.Choice) else "1"


PARTNERS = [
    (path, command, option)
    for path, command in paths(program)
    for option in command.params
    if isinstance(option, Option) and (option.needs or option.excludes)
]


@pytest.mark.parametrize(
    ("path", "command", "option"),
    PARTNERS,
    ids=[f"{'-'.join(path)} {option.opts[0]}" for path, _, option in PARTNERS],
)
def test_an_option_that_would_say_nothing_is_refused(
    cli, tmp_path, monkeypatch, path, command, option
):
    monkeypatch.chdir(tmp_path)
    known = {name: one for one in command.params for name in one.opts}
    required = [one for one in command.params if one.required and one is not option]
    call = [*path, *given(*(one for one in required if one.opts[0].startswith("-")))]
    call += ["photo.jpg" for one in required if isinstance(one, click.Argument)]
    name = option.opts[0]
    wrong = [([], f"{name} needs {option.needs}")] if option.needs else []
    wrong += [(known[one], f"{name} and {one} don't go together") for one in option.excludes]
    assert option.needs is None or option.needs in known
    for others, sentence in wrong:
        code, said, err = cli(*call, *given(option, *([others] if others else [])))
        assert (code, said) == (2, "")
        assert err.startswith(f"kogao-cli: {sentence}")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "arguments",
    [
        ("warp", "--protect-width", 3),
        ("warp", "--protect-feather", 3),
        ("warp", "--temporary"),
        ("warp", "--points-map", "0-16/36,39,42,45/48,54"),
        ("warp", "--label-font", "x.ttf"),
        ("warp", "--label-corner", "top-left"),
        ("warp", "--label-share", 5),
        ("warp", "--sign-key", "x.pem"),
        ("warp", "--points", "x.csv", "--landmarks", "aam"),
        ("batch", "--label-share", 5),
        ("batch", "--jobs", 2, "--dask", "tcp://127.0.0.1:1"),
    ],
)
def test_half_a_pair_is_one_sentence(cli, small_portrait, tmp_path, arguments):
    code, said, err = cli(*arguments, small_portrait, "-o", tmp_path / "out.png")
    assert (code, said) == (2, "")
    assert re.fullmatch(r"kogao-cli: [^\n]+ (needs --|don't go together)[^\n]+\n", err), err


@pytest.mark.parametrize("spelled", ["--json", "--csv", "--html"])
def test_every_report_goes_to_a_file_or_is_printed(spelled):
    found = [option for known, _, option in options() if known == spelled]
    assert found
    for option in found:
        assert not option.is_flag
        assert option.type.allow_dash
        assert "print it" in option.help


@pytest.mark.parametrize("name", COMMANDS)
def test_whoever_takes_photos_takes_the_sample_and_says_how_to_find_faces(name):
    command = COMMANDS[name]
    spelled = {opt for option in command.params for opt in option.opts}
    if any(one.type is common.PHOTO for one in command.params):
        assert {"--landmarks", "--max-megapixels"} <= spelled
        assert "--sample" in spelled or name in TAKES_NO_SAMPLE
    if "--json" in spelled:
        assert "--force" in spelled


@pytest.mark.parametrize(
    "arguments", [("detect", "--sample"), ("doctor",), ("warp", "--sample", "-o", "{folder}/o.png")]
)
def test_json_goes_to_a_file_or_is_printed_in_place_of_the_text(cli, weights, tmp_path, arguments):
    assert weights.is_dir()
    arguments = [one.format(folder=tmp_path) for one in arguments]
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
        ("{photo}", 2, "is a photo's name; name another file, or - to print"),
        ("{folder}/none/x.json", 3, "there is no folder"),
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
    assert (code, "is a photo's name" in err) == (2, True)
    assert small_portrait.read_bytes() == before


@pytest.mark.parametrize(
    ("command", "made"),
    [
        (("experiment", "figures", "--width", "240"), "-lattice.png"),
        (("landmarks", "export", "--format", "tem"), ".tem"),
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
        assert (out / f"{stem}{made}").is_file()
    (tmp_path / "empty").mkdir()
    for given, words in (
        ((), "or use --sample"),
        ((small_portrait, "--sample"), "or use --sample"),
        ((tmp_path / "empty",), "there is no photo in"),
    ):
        code, _, err = cli(*command, *given, "-o", tmp_path / "none")
        assert (code, words in err) == (2, True)
    assert not (tmp_path / "none").exists()


def test_a_study_is_made_of_files_folders_or_the_sample(cli, weights, small_portrait, tmp_path):
    assert weights.is_dir()
    (tmp_path / "in" / "below").mkdir(parents=True)
    (tmp_path / "in" / "below" / "me.jpg").write_bytes(small_portrait.read_bytes())
    make, brief = ("experiment", "study", "make"), ("--lattices", "1")
    for given, name in ((tmp_path / "in", "folder"), ("--sample", "sample")):
        code, said, _ = cli(*make, given, "-o", tmp_path / name, *brief)
        assert (code, "pictures of 1 face;" in said) == (0, True)
    for given in ((), (small_portrait, "--sample")):
        code, _, err = cli(*make, *given, "-o", tmp_path / "none", *brief)
        assert (code, "or use --sample" in err) == (2, True)
    assert not (tmp_path / "none").exists()
