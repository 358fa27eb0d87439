"""The documents are whole: numbered without holes, with links, paths and tests that are there."""

import re
import runpy
from pathlib import Path

import pytest

from kogao_core.base.wording import columns
from kogao_core.cli.declarations import program

ROOT = Path(__file__).parents[2]
DECISIONS = ROOT / "docs" / "decisions"
PAGES = sorted(DECISIONS.glob("[0-9]*.md"))
DOCUMENTS = [
    path
    for folder in ("docs", "resources", "tests")
    for path in sorted((ROOT / folder).rglob("*.md"))
] + sorted(ROOT.glob("*.md"))
WIDTH = 100
# What nobody wraps: tables, links longer than a line, and lines to be copied into a terminal.
UNWRAPPED = re.compile(r"\||    |[!-~]*$|!?\[[^\]]*\]\([^ ]*\)$")
# Where there are no spaces there is no place to break a line: browsers would show it as one.
WIDE = "[\u3000-\u30ff\u4e00-\u9fff\uff00-\uffef]"
JAPANESE = [path for path in DOCUMENTS if re.search(WIDE, path.read_text(encoding="utf-8"))]


def read(path):
    return path.read_text(encoding="utf-8")


def prose(path):
    """Return the text of a document without its blocks of code, which may hold anything."""
    return re.sub(r"^```.*?^```$", "", read(path), flags=re.DOTALL | re.MULTILINE)


def headings(path):
    """Return the anchors of a document's headings, as GitHub makes them."""
    found = re.findall(r"^#+ (.*)$", prose(path), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", text).strip().lower().replace(" ", "-") for text in found}


def test_lines_are_wrapped():
    lines = [(path, line) for path in DOCUMENTS for line in prose(path).splitlines()]
    long = [(path, line) for path, line in lines if columns(line) > WIDTH]
    kept = re.compile(f"{UNWRAPPED.pattern}|.*{WIDE}")
    assert [(path, line) for path, line in long if not kept.match(line)] == []


@pytest.mark.parametrize("path", JAPANESE, ids=lambda path: path.stem)
def test_japanese_lines_break_and_words_stand_apart_only_where_they_may(path):
    text = prose(path)
    break_ = f"{WIDE}(?:\\*\\*)?\n(?:\\*\\*)?{WIDE}|[、。]\n(?!\\Z|[-#|>\\s]|\\d+\\. |!\\[)"
    assert re.findall(f".*(?:{break_}).*", text) == []
    shown = re.sub(r"`[^`]*`", "x", text)
    assert re.findall(f".*{WIDE}[ \u2009\u202f]+{WIDE}.*", shown) == []


def test_pages_in_two_languages_lead_to_each_other():
    translated = sorted((ROOT / "docs" / "ja").glob("*.md"))
    assert len(translated) == 4
    for page in translated:
        assert f"[English](../{page.name})" in read(page)
        assert f"[日本語](ja/{page.name})" in read(ROOT / "docs" / page.name)
    assert "[English](README.md)" in read(ROOT / "README.ja.md")
    assert "[日本語](README.ja.md)" in read(ROOT / "README.md")


def test_links_lead_somewhere():
    to = re.compile(r"\]\(([^) ]+)\)")
    broken = []
    for path, link in ((page, one) for page in DOCUMENTS for one in to.findall(prose(page))):
        name, _, anchor = link.partition("#")
        target = path.parent / name if name else path
        if name.startswith(("http:", "https:")):
            continue
        if not target.exists() or (anchor and anchor not in headings(target)):
            broken.append((path, link))
    assert broken == []


def blocks(path):
    """Return what a document says to type into a terminal."""
    return re.findall(r"^```sh\n(.*?)^```$", read(path), re.DOTALL | re.MULTILINE)


def test_the_japanese_readme_gives_the_same_commands_and_leads_to_the_same_pages():
    english, japanese = ROOT / "README.md", ROOT / "README.ja.md"
    assert len(blocks(english)) == 3
    assert blocks(japanese) == blocks(english)
    pages = [set(re.findall(r"\]\((docs/[^) ]+\.md)", read(one))) for one in (english, japanese)]
    assert pages[0] <= pages[1]


def test_decisions_are_numbered_without_holes_and_all_are_in_the_index():
    titles = [re.match(r"# (\d+)\. (.*)\n\n", read(page)).groups() for page in PAGES]
    numbers = [int(number) for number, _ in titles]
    assert numbers == [int(page.name[:2]) for page in PAGES] == list(range(1, len(PAGES) + 1))
    lines = [
        f"| {number} | [{title}]({page.name}) |"
        for page, (number, title) in zip(PAGES, titles, strict=True)
    ]
    assert re.findall(r"^\| \d.*$", read(DECISIONS / "README.md"), re.MULTILINE) == lines


def absent(text):
    """Return the files and tests that a text names, each file ahead of its tests, and that lack."""
    missing, file = [], None
    for path, test, more in re.findall(r"`(?:([\w./-]+\.py)(?:::(\w+))?|::(\w+))", text):
        file = ROOT / path if "/" in path else file
        name = test or more
        if not file.is_file() or (name and f"def {name}(" not in read(file)):
            missing.append(f"{path}::{name}")
    return missing


def test_a_decision_names_tests_that_are_there():
    held = {page.stem: read(page).partition("**Held by**")[2] for page in PAGES}
    assert all(held.values())
    assert {page: absent(text) for page, text in held.items() if absent(text)} == {}


def test_how_to_add_to_it_names_files_and_tests_that_are_there():
    page = read(ROOT / "docs" / "extending.md")
    assert "::test_" in page
    assert absent(page) == []


def test_every_module_of_the_core_is_in_its_map():
    rooms = re.search(r"^kogao_core/.*?(?=^app/)", read(ROOT / "ARCHITECTURE.md"), re.S | re.M)[0]
    inside = [path for path in (ROOT / "kogao_core").iterdir() if path.name[0] != "_"]
    modules = {path.name for path in inside if path.suffix == ".py"}
    packages = {f"{path.name}/" for path in inside if path.is_dir()}
    assert modules | packages == set(re.findall(r"^  (\w+(?:\.py|/))", rooms, re.MULTILINE))


def test_figures_show_todays_engine():
    """Mend them with ``python docs/figures.py``."""
    drawn = runpy.run_path(str(ROOT / "docs" / "figures.py"))["figures"]()
    assert {name: read(ROOT / "docs" / "figures" / f"{name}.svg") for name in drawn} == drawn


def test_the_walk_through_the_paper_shows_its_code():
    page, walk = read(ROOT / "docs" / "paper.md"), read(ROOT / "kogao_core" / "paper" / "walk.py")
    code = [block for block in walk.split('"""')[1].split("\n\n") if block.startswith(">>>")]
    assert code
    assert [block for block in code if block.strip() not in page] == []


def test_decisions_that_are_named_are_there():
    named = {int(n) for path in DOCUMENTS for n in re.findall(r"\bdecisions?[ /](\d+)", read(path))}
    assert named <= set(range(1, len(PAGES) + 1))


def test_the_page_of_the_command_line_is_that_of_todays_options():
    """Mend it with ``python docs/command_line.py``."""
    written = runpy.run_path(str(ROOT / "docs" / "command_line.py"))["text"]()
    assert read(ROOT / "docs" / "command-line.md") == written
    program.main(["-h"], standalone_mode=False)  # click keeps the names of the first context
