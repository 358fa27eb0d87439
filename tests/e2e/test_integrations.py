"""Other programs get their pictures back: darktable, GIMP 2.10, Krita, a stand-in for GIMP 3."""

import itertools
import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import colours
import files
import numpy as np
import pytest
from PIL import Image
from systems import needs_linux
from timeouts import LONGEST_S

from kogao_core import photo
from kogao_core.base import installed
from kogao_core.cli import desktop, integrate

pytestmark = needs_linux("programs and folders of a Linux desktop")
BIN = "/usr/bin"  # where the Python of the system's programs lies
NO_FACE = "No face is certain. Choose Kogao: edit… to place faces by hand."
THEIRS = b"-- mine\nrequire 'tools/script_manager'"
DARKTABLE = """
assert(io.open("{begun}", "w")):close()
local dt, kogao = require "darktable", require "kogao"
local told = assert(io.open("{told}", "w"))
dt.print = function(said) told:write("said ", said, "\\n") end
local image, nobody = dt.database.import("{photo}"), dt.database.import("{nobody}")
image.rating = 3
kogao.process("{cancels}", {{image}})
kogao.process(kogao.smaller(), {{nobody, image}})
for _, one in ipairs(image:get_group_members()) do
  told:write(one.filename, " ", one.rating, "\\n")
end
-- The panel comes with the first photo under the pointer.
dt.register_event("hands", "mouse-over-image-changed", function(_, hovered)
  if not hovered or io.type(told) == "closed file" then return end
  local slider = kogao.slider()
  told:write(slider.value, " ", kogao.smaller():match("%-%-amount.*"), "\\n")
  slider.value = 7.5
  told:write(kogao.smaller():match("%-%-amount.*"), "\\n")
  told:write(dt.preferences.read("kogao", "amount", "float"), "\\n")
  told:close()
  os.rename("{told}", "{done}")
end)
"""
# A second plug-in, whose hands do what a user's would: open a photo, choose an action, look.
KRITA = """
import array, os, traceback
from krita import Extension, InfoObject, Krita, Selection
from PyQt5.QtCore import QTimer
from PyQt5.QtWidgets import QApplication, QInputDialog

def told(text):
    with open(r"{told}.part", "w") as file:
        file.write(text)
    os.replace(file.name, r"{told}")

# Do something as soon as it can be done; tell what went wrong.
def when(ready, then):
    try:
        if ready():
            then()
        else:
            QTimer.singleShot(200, lambda: when(ready, then))
    except Exception:
        told(traceback.format_exc())

def act():
    krita = Krita.instance()
    document = krita.openDocument(r"{photo}")
    krita.activeWindow().addView(document)
    krita.setActiveDocument(document)
    action = krita.action("kogao_smaller")
    when(lambda: krita.activeDocument() == document and action.isEnabled(),
         lambda: choose(document, action))

# Press OK in the dialog that is about to ask for the amount.
def answer(action):
    def press():
        dialog = QApplication.activeModalWidget()
        if isinstance(dialog, QInputDialog):
            dialog.accept()
        else:
            QTimer.singleShot(100, press)
    QTimer.singleShot(100, press)
    action.trigger()

def choose(document, action):
    place, selection = (0, 0, document.width(), document.height()), Selection()
    selection.select(*place, 255)
    document.setSelection(selection)
    answer(action)
    document.setSelection(None)
    answer(action)
    document.setBatchmode(True)
    document.exportImage(r"{shown}", InfoObject())
    nodes = document.topLevelNodes()
    depth = document.colorDepth()
    # Krita 5.2 converts 16 bits with errors of 1 and 2 levels, some of 6.
    kind, most = ("H", 8) if depth == "U16" else ("B", 0)
    was, now = (array.array(kind, bytes(node.pixelData(*place))) for node in nodes[:2])
    is_held = max(map(abs, map(int.__sub__, was, now))) <= most
    told(repr(([node.name() for node in nodes], depth, is_held)))

class Hands(Extension):
    def setup(self): pass
    def createActions(self, window):
        krita = Krita.instance()
        when(lambda: krita.activeWindow() and krita.action("kogao_smaller"), act)

Krita.instance().addExtension(Hands(Krita.instance()))
"""
# What a user of GIMP 2.10 would do: open two photos, choose entries for them, look what is there.
GIMP_2_10 = """
(let* ((opened (lambda (file) (car (gimp-file-load RUN-NONINTERACTIVE file ""))))
       (layers (lambda (image) (vector->list (cadr (gimp-image-get-layers image)))))
       (names (lambda (image) (map (lambda (one) (car (gimp-item-get-name one))) (layers image))))
       (mine (opened "{mine}"))
       (wide (opened "{mine}"))
       (nobody (opened "{nobody}"))
       (cancelled (catch #f (kogao-edit RUN-NONINTERACTIVE mine (car (layers mine)))))
       (after-cancelling (names mine))
       (hidden (car (gimp-layer-copy (car (layers wide)) 0))))
  (gimp-image-insert-layer wide hidden 0 0)
  (gimp-item-set-visible hidden 0)
  (catch #f (kogao-smaller RUN-NONINTERACTIVE nobody (car (layers nobody)) 4))
  (kogao-smaller RUN-NONINTERACTIVE mine (car (layers mine)) 4)
  (kogao-smaller RUN-NONINTERACTIVE mine (car (layers mine)) 4)
  (gimp-image-resize wide 340 350 30 40)
  (gimp-selection-all wide)
  (kogao-smaller RUN-NONINTERACTIVE wide (car (layers wide)) 4)
  (gimp-selection-none wide)
  (file-png-save RUN-NONINTERACTIVE wide (car (layers wide)) "{held}" "" 0 9 0 0 0 0 0)
  (file-png-save RUN-NONINTERACTIVE mine (car (layers mine)) "{shown}" "" 0 9 0 0 0 0 0)
  (call-with-output-file "{told}" (lambda (file)
    (write (list after-cancelling (names nobody) (names mine)) file)
    (write (map (lambda (of) (car (of (car (layers wide)))))
                (list gimp-drawable-width gimp-drawable-height)) file)
    (write (cons (car (gimp-image-get-precision mine)) (cadr (gimp-plugins-query "Kogao"))) file))))
"""
# What the plug-in calls of GIMP 3's library, on pictures of Pillow.
STAND_IN = """
import shutil, sys
from types import ModuleType, SimpleNamespace as Names

def require_version(name, version):
    assert name in ("Gimp", "GimpUi") and version == "3.0"

class PlugIn:
    __gtype__ = None

class Layer(Names):
    def get_name(self): return self.name
    def get_visible(self): return self.visible
    def set_name(self, name): self.name = name

class Picture:
    def __init__(self):
        names = {"Kogao, 2 %": True, "Background": True, "Draft": False}
        self.layers = [Layer(name=name, visible=visible) for name, visible in names.items()]
    def get_layers(self): return list(self.layers)
    def remove_layer(self, layer): self.layers.remove(layer)
    def get_file(self): return Names(get_basename=lambda: "mine.xcf")
    def is_valid(self): return "closed" not in sys.argv
    def duplicate(self): return Picture()
    def get_base_type(self): return "rgb"
    def merge_visible_layers(self, kind):
        assert kind == "clip"
        return Names(resize_to_image_size=lambda: setattr(self, "is_whole", True))
    def delete(self): pass
    def undo_group_start(self): pass
    def undo_group_end(self): pass
    def insert_layer(self, layer, parent, at): self.layers.insert(at, layer)

class Export(dict):
    set_property = dict.__setitem__
    def find_property(self, name): return name == "save-thumbnail"

def save(config):
    image = config["image"]
    assert image.is_whole and config["save-thumbnail"] is False
    assert [layer.name for layer in image.layers] == ["Background"]
    shutil.copy(sys.argv[1], config["file"].path)

def looked_up(name):
    assert name == "file-tiff-export"
    return Names(create_config=Export, run=save)

def load(mode, image, file):
    shutil.copy(file.path, sys.argv[2])
    return Layer(visible=True)

def main(kind, arguments):
    plug_in, image = sys.modules["__main__"].Kogao(), Picture()
    mode = "i" if "dialog" in sys.argv else "n"
    procedure = Names(get_name=lambda: "kogao-smaller", new_return_values=lambda *it: it)
    config = Names(get_property={"amount": 6.0}.get)
    assert "kogao-smaller" in plug_in.do_query_procedures()
    status, problem = plug_in.run(procedure, mode, image, [], config, None)
    print(status, problem, len(image.layers) - 3, image.layers[0].name)

Gimp = Names(
    PlugIn=PlugIn, main=main, get_pdb=lambda: Names(lookup_procedure=looked_up),
    file_load_layer=load, displays_flush=lambda: None,
    progress_init=lambda text: None,
    ImageBaseType=Names(GRAY="grey"), Selection=Names(is_empty=lambda image: True),
    RunMode=Names(NONINTERACTIVE="n", INTERACTIVE="i"), MergeType=Names(CLIP_TO_IMAGE="clip"),
    PDBStatusType=Names(SUCCESS="done", CANCEL="cancelled", EXECUTION_ERROR="failed"),
)
Gio = Names(File=Names(new_for_path=lambda path: Names(path=path)))
GLib = Names(Error=Exception)
repository = ModuleType("gi.repository")
dialog = Names(fill=lambda _: None, run=lambda: False, destroy=lambda: None)
repository.GimpUi = Names(
    init=lambda name: None, ProcedureDialog=Names(new=lambda *given: dialog)
)
repository.Gimp, repository.Gio, repository.GLib = Gimp, Gio, GLib
repository.GObject = Names(ParamFlags=Names(READWRITE=3))
sys.modules["gi.repository"] = repository
"""


def kept(data):
    """Whether an original of the picture has been kept, which the other program has itself."""
    return (data / "kogao" / "originals").exists()


def shell_script(path, text):
    """Write a shell script that can be started."""
    path.parent.mkdir(exist_ok=True)
    path.write_text(f"#!/bin/sh\n{text}")
    path.chmod(0o755)
    return path


def deep(portrait, path, depth):
    """Write a portrait as a PNG file with a profile; return its pixels."""
    pixels = photo.read(portrait).pixels.astype(depth) * (np.iinfo(depth).max // 255)
    path.write_bytes(files.png(pixels))
    return pixels


def test_darktables_settings_keep_what_is_in_them(works, tmp_path):
    marks = tmp_path / "luarc"
    marks.write_bytes(THEIRS)
    for _ in range(2):
        works("integrate", "darktable", "--settings", tmp_path)
    assert marks.read_bytes() == THEIRS + b"\n" + integrate._LINE.encode() + b"\n"
    assert "@KOGAO" not in (tmp_path / "lua" / "kogao.lua").read_text()
    works("integrate", "darktable", "--settings", tmp_path, "--remove")
    assert marks.read_bytes() == THEIRS + b"\n"
    assert not (tmp_path / "lua" / "kogao.lua").exists()


def test_the_desktop_starts_this_very_program_and_forgets_it(works, tmp_path, monkeypatch):
    monkeypatch.setattr(installed, "program", lambda name: Path("/opt/a b/50% $1", name))
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    theirs = tmp_path / "applications" / "theirs.desktop"
    theirs.parent.mkdir()
    theirs.touch()
    before = set(tmp_path.rglob("*"))
    works("integrate", "desktop")
    entry = (tmp_path / "applications" / f"{desktop.NAME}.desktop").read_text()
    starts = re.findall("^Exec=.*", entry, re.MULTILINE)
    program = r'Exec="/opt/a b/50%% \\$1/kogao"'
    assert starts == [f"{program} %F", f"{program} --sample"]
    assert "\nMimeType=application/vnd.kogao.project+json;\n" in entry
    assert all((tmp_path / folder / name).is_file() for name, folder in desktop.PLACES.items())
    works("integrate", "desktop", "--remove")
    left = {path for path in set(tmp_path.rglob("*")) - before if desktop.NAME in path.name}
    assert left == set()
    assert theirs.exists()
    assert "no menu entry" in works("integrate", "desktop", "--remove")


def test_removing_takes_everything_out_and_says_what_there_was(works, fails, tmp_path, monkeypatch):
    fails(2, "desktop, darktable, gimp, krita", "integrate")
    monkeypatch.setenv("HOME", str(tmp_path))
    for name in ("DATA", "CONFIG"):
        monkeypatch.setenv(f"XDG_{name}_HOME", str(tmp_path / name))
    for version in ("2.10", "3.0"):
        (tmp_path / "CONFIG" / "GIMP" / version).mkdir(parents=True)
    before = {file for file in tmp_path.rglob("*") if file.is_file()}
    for host in ("desktop", *integrate.HOSTS):
        works("integrate", host)
    said = works("integrate", "--remove")
    for name in ("darktable", "GIMP", "Krita", "Kogao was removed from"):
        assert name in said
    left = {file for file in tmp_path.rglob("*") if file.is_file()} - before
    assert [
        file for file in left if "kogao" in file.name.lower() or "kogao" in contents(file)
    ] == []
    works("integrate", "--remove")


def contents(file):
    """What a file says, caches of the desktop's own aside."""
    return "" if file.suffix == ".cache" else file.read_text(errors="replace").lower()


@pytest.mark.parametrize("has_own", [True, False])
def test_darktable_as_a_flatpak_gets_the_script_and_its_user_the_command(
    works, tmp_path, monkeypatch, has_own
):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("XDG_CONFIG_HOME", raising=False)
    own, inner = tmp_path / ".config", tmp_path / ".var/app/org.darktable.Darktable/config"
    for config in [inner, own][: 1 + has_own]:
        (config / "darktable").mkdir(parents=True)
    said = works("integrate", "darktable")
    assert "flatpak override --user --talk-name=org.freedesktop.Flatpak" in said
    assert (inner / "darktable/lua/kogao.lua").is_file()
    assert (own / "darktable/lua/kogao.lua").is_file() == has_own
    works("integrate", "darktable", "--remove")
    assert list(tmp_path.rglob("kogao.lua")) == []


@pytest.mark.parametrize(
    ("host", "version", "started"),
    [("gimp", "3.0", "kogao.py"), ("gimp", "2.10", "kogao"), ("krita", "krita", "__init__.py")],
)
def test_a_plug_in_has_a_folder_of_its_name_and_goes_with_it(
    works, tmp_path, host, version, started
):
    settings = tmp_path / version
    folder = settings / {"gimp": "plug-ins", "krita": "pykrita"}[host] / "kogao"
    said = works("integrate", host, "--settings", settings)
    assert ("Python Plugin Manager" in said) == (host == "krita")
    assert [file.name for file in folder.iterdir() if os.access(file, os.X_OK)] == [started]
    for file in folder.iterdir():
        assert "@KOGAO" not in file.read_text()
        if file.suffix == ".py":
            compile(file.read_text(), file, "exec")
    (folder.parent / "theirs").touch()
    works("integrate", host, "--settings", settings, "--remove")
    assert [path.name for path in folder.parent.iterdir()] == ["theirs"]


@pytest.mark.parametrize("started", [{"2.10"}, {"2.10", "3.0"}, set()])
def test_each_gimp_that_has_been_started_gets_its_plug_in(
    cli, works, tmp_path, monkeypatch, started
):
    # One that finds a folder of settings when it first starts doesn't fill it.
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    for version in started:
        (tmp_path / "GIMP" / version).mkdir(parents=True)
    code, _, complaint = cli("integrate", "gimp")
    assert {path.parents[2].name for path in tmp_path.rglob("plug-ins/kogao/common.py")} == started
    assert (code == 0) == bool(started)
    assert ("start GIMP once" in complaint) == (not started)
    works("integrate", "gimp", "--remove")
    assert list(tmp_path.rglob("plug-ins/kogao")) == []


@pytest.mark.parametrize("has_python", [True, False])
def test_a_bundle_has_gimp_start_kogao_by_the_systems_python(
    cli, tmp_path, monkeypatch, has_python
):
    monkeypatch.setattr(installed, "is_bundle", lambda: True)
    monkeypatch.setattr(installed, "program", Path("/opt/kogao").joinpath)
    monkeypatch.setenv("PATH", str(tmp_path))
    if has_python:
        (tmp_path / "python3").touch(0o755)
    code, _, complaint = cli("integrate", "gimp", "--settings", tmp_path / "2.10")
    assert (code == 0) == has_python
    assert ("a Python 3" in complaint) == (not has_python)
    starting = tmp_path / "2.10" / "plug-ins" / "kogao" / "kogao"
    assert starting.exists() == has_python
    if has_python:
        assert f"in {tmp_path}/python3 " in starting.read_text()


@pytest.fixture
def sandbox(tmp_path):
    """What a program knows of the Flatpak it is in, with a door that notes who leaves."""
    leaves = f'test "$1" = --host && shift && echo left >>"{tmp_path}/door"\n"$@"'
    door = shell_script(tmp_path / "bin" / "flatpak-spawn", leaves)
    cache = tmp_path / "cache"
    cache.mkdir()
    path = f"{door.parent}{os.pathsep}{os.environ['PATH']}"
    return {"FLATPAK_ID": "a.host", "XDG_CACHE_HOME": str(cache), "PATH": path}


@pytest.fixture
def gimp_3(works, tmp_path):
    """Let a stand-in for GIMP 3 call the plug-in; return what it prints."""

    def run(sent, *words, **environment):
        (tmp_path / "gi.py").write_text(STAND_IN)
        works("integrate", "gimp", "--settings", tmp_path)
        plug_in = tmp_path / "plug-ins" / "kogao" / "kogao.py"
        places = {"PYTHONPATH": str(tmp_path), "XDG_DATA_HOME": str(tmp_path / "data")}
        return subprocess.run(
            [sys.executable, plug_in, sent, tmp_path / "back.tif", *words],
            env=os.environ | places | environment, capture_output=True, text=True, check=True,
        ).stdout  # fmt: skip

    return run


@pytest.mark.slow
@pytest.mark.parametrize(("has_face", "is_sandboxed"), [(True, True), (True, False), (False, True)])
def test_gimp_gets_a_layer_back(gimp_3, sandbox, small_portrait, tmp_path, has_face, is_sandboxed):
    sent = tmp_path / "sent.tif"
    with Image.open(small_portrait) as picture:
        (picture if has_face else Image.new("RGB", (90, 80))).save(sent)
    said = gimp_3(sent, **(sandbox if is_sandboxed else {}))
    assert (tmp_path / "door").exists() == is_sandboxed
    assert not kept(tmp_path / "data")
    if has_face:
        assert said == "done None 1 Kogao, 6 %, faces: 1\n"
        assert (photo.read(tmp_path / "back.tif").pixels != photo.read(sent).pixels).any()
    else:
        assert said.startswith(f"failed {NO_FACE}")
        assert said.endswith(" 0 Kogao, 2 %\n")


@pytest.mark.parametrize(
    ("meanwhile", "code", "words"),
    [
        ("closed", 0, "The picture was closed meanwhile."),
        ("dialog", 3, "cancelled None"),
        ("uninstalled", None, "can't be started; run kogao-cli integrate gimp again."),
        ("cancelled", 6, "cancelled None"),
    ],
)
def test_gimp_gets_nothing_back_and_says_why(
    gimp_3, small_portrait, tmp_path, monkeypatch, meanwhile, code, words
):
    program = tmp_path / "kogao-cli"
    if code is not None:
        shell_script(program, f"exit {code}")
    monkeypatch.setattr(installed, "program", lambda _: program)
    said = gimp_3(small_portrait, meanwhile)
    assert words in said
    assert said.endswith(" 0 Kogao, 2 %\n")


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("gimp-console-2.10"), reason="needs GIMP 2.10")
@pytest.mark.parametrize(("depth", "is_sandboxed"), [(np.uint8, False), (np.uint16, True)])
def test_gimp_2_10_gets_a_layer_back(
    cli, works, sandbox, faceless, small_portrait, tmp_path, monkeypatch, depth, is_sandboxed
):
    monkeypatch.setattr(files, "profile_for", lambda _: colours.profile("Display P3"))
    names = "小 顔's.png", "told", "shown.png", "held.png"
    mine, told, shown, held = (tmp_path / name for name in names)
    pixels = deep(small_portrait, mine, depth)
    cancels = shell_script(tmp_path / "cancels", "exit 6")
    programs = {"kogao": cancels, "kogao-cli": installed.program("kogao-cli")}
    monkeypatch.setattr(installed, "program", programs.get)
    config = tmp_path / "its settings"
    works("integrate", "gimp", "--settings", config / "GIMP" / "2.10")
    folders = {"XDG_CONFIG_HOME": config, "XDG_DATA_HOME": tmp_path / "data",
               "XDG_CACHE_HOME": tmp_path / "cache", "TMPDIR": tmp_path}  # fmt: skip
    script = GIMP_2_10.format(mine=mine, nobody=faceless, shown=shown, told=told, held=held)
    done = subprocess.run(
        ["gimp-console-2.10", "-b", script, "-b", "(gimp-quit 1)"],
        env=os.environ | {name: str(folder) for name, folder in folders.items()}
        | (sandbox if is_sandboxed else {}),
        capture_output=True, encoding="utf-8", timeout=4 * LONGEST_S,
    )  # fmt: skip
    assert told.exists(), done.stderr
    assert not kept(tmp_path / "data")
    made = '"Kogao, 4 %, faces: 1'
    assert told.read_text().startswith(
        f'(("Background") ("Background") ({made} #1" {made}" "Background"))'
    )
    assert "(340 350)" in told.read_text()
    assert f"({ {np.uint8: 150, np.uint16: 250}[depth] } " in told.read_text()
    for entry in ("edit…", "smaller faces…"):
        assert f'"<Image>/Filters/Distorts/Kogao: {entry}"' in told.read_text()
    assert f"'kogao-smaller':\n{NO_FACE}" in done.stderr
    assert "'kogao-edit'" not in done.stderr
    by_itself = tmp_path / "by itself.png"
    assert cli("warp", mine, "-o", by_itself, "--amount", 4)[0] == 0
    inside = photo.read(held).pixels[40:340, 30:330, :3]  # of the enlarged canvas
    np.testing.assert_array_equal(inside, pixels)
    result, was = photo.read(shown), photo.read(by_itself)
    assert result.pixels.dtype == depth
    assert (result.pixels[..., :3] == was.pixels).all()
    assert (result.pixels[..., :3] != pixels).any()
    assert list(tmp_path.rglob("kogao-*")) == []
    assert (tmp_path / "door").exists() == is_sandboxed


def is_there_within(seconds, file, program, act=lambda: None):
    """Wait for a file that a running program writes; do something meanwhile, over and over."""
    ends = time.monotonic() + seconds
    while not file.exists() and program.poll() is None and time.monotonic() < ends:
        act()
        time.sleep(0.1)
    return file.exists()


@pytest.mark.slow
@pytest.mark.skipif(
    not all(map(shutil.which, ("darktable", "Xvfb", "xdotool"))),
    reason="needs darktable, Xvfb and xdotool",
)
@pytest.mark.parametrize("is_sandboxed", [True, False])
def test_darktable_gets_a_photo_back_beside_its_own(
    works, request, sandbox, faceless, small_portrait, tmp_path, is_sandboxed
):
    settings, done = tmp_path / "settings", tmp_path / "done"
    mine = Path(shutil.copy(small_portrait, tmp_path / "mine's.jpg"))
    works("integrate", "darktable", "--settings", settings)
    cancels = shell_script(tmp_path / "cancels", "exit 6")
    places = {"photo": mine, "nobody": faceless, "cancels": cancels, "told": tmp_path / "told"}
    begun = tmp_path / "begun"
    spots = itertools.cycle([("330", "170"), ("360", "200"), ("10", "10")])  # on a photo, and off
    command = ["darktable", "--configdir", settings, "--cachedir", tmp_path / "cache",
               "--library", ":memory:", "--disable-opencl",
               "--luacmd", DARKTABLE.format(begun=begun, done=done, **places)]  # fmt: skip
    named = {"DISPLAY": request.getfixturevalue("screen"), "XDG_DATA_HOME": str(tmp_path / "data")}

    def move():
        subprocess.run(["xdotool", "mousemove", *next(spots)], env=os.environ | named, check=False)

    # One start in some thirty of darktable 4.2 stands still in its own script installer, which asks
    # for a widget before the main loop runs: then none of our words were reached, and it starts
    # again.
    for _ in range(5):
        with subprocess.Popen(
            [str(word) for word in command],
            env=os.environ | named | (sandbox if is_sandboxed else {}),
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        ) as darktable:  # fmt: skip
            if is_there_within(LONGEST_S, begun, darktable):
                is_there_within(4 * LONGEST_S, done, darktable, move)
            darktable.kill()
        if begun.exists():
            break
    said, *photos, first, moved_to, kept_for_next = done.read_text().splitlines()
    assert said == f"said faceless.png: {NO_FACE}"
    assert (first, moved_to, kept_for_next) == ("6 --amount 6.0", "--amount 7.5", "7.5")
    assert sorted(photos) == ["mine's.jpg 3", "mine's_kogao.tif 3"]
    result, was = photo.read(tmp_path / "mine's_kogao.tif"), photo.read(mine)
    assert result.bits == 16
    moved = np.abs(result.pixels / 257.0 - was.pixels).max(axis=2) > 16
    assert 0.001 < moved.mean() < 0.5
    assert list(tmp_path.rglob("*.said")) == []
    assert [file.name for file in tmp_path.rglob("*.tif")] == ["mine's_kogao.tif"]
    assert not kept(tmp_path / "data")
    assert (tmp_path / "door").exists() == is_sandboxed


def krita_runs():
    """Whether there is a Krita that runs plug-ins, and a screen for it."""
    if not (shutil.which("krita") and shutil.which("Xvfb") and shutil.which("python3", path=BIN)):
        return False
    asked = [shutil.which("python3", path=BIN), "-c", "import PyQt5.QtWidgets"]
    return subprocess.run(asked, capture_output=True).returncode == 0


@pytest.mark.slow
@pytest.mark.skipif(not krita_runs(), reason="needs Krita, its Python with PyQt5, and Xvfb")
@pytest.mark.parametrize("depth", [np.uint8, np.uint16])
def test_krita_gets_a_layer_back(works, request, small_portrait, tmp_path, depth):
    mine, told, shown = (tmp_path / name for name in ("mine.png", "told", "shown.png"))
    deep(small_portrait, mine, depth)  # with a profile, for which Krita would ask
    data, config = tmp_path / "data", tmp_path / "config"
    works("integrate", "krita", "--settings", data / "krita")
    hands = data / "krita" / "pykrita" / "hands"
    hands.mkdir()
    (hands / "__init__.py").write_text(KRITA.format(photo=mine, told=told, shown=shown))
    entry = (hands.parent / "kogao.desktop").read_text().replace("kogao", "hands")
    hands.with_suffix(".desktop").write_text(entry)
    config.mkdir()
    (config / "kritarc").write_text("[python]\nenable_kogao=true\nenable_hands=true\n")
    folders = {"XDG_DATA_HOME": data, "XDG_CONFIG_HOME": config, "XDG_CACHE_HOME": tmp_path / "c"}
    named = {"DISPLAY": request.getfixturevalue("screen"), "HOME": tmp_path} | folders
    with subprocess.Popen(
        ["krita", "--nosplash"], env=os.environ | {k: str(v) for k, v in named.items()},
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    ) as krita:  # fmt: skip
        is_there_within(4 * LONGEST_S, told, krita)
        krita.kill()
    assert not kept(data)
    assert told.read_text() == repr(
        (["Background", *["Kogao, 6 %, faces: 1"] * 2], f"U{8 * depth().itemsize}", True)
    )
    result, was = photo.read(shown), photo.read(mine)
    assert result.bits == was.bits
    steps = np.abs(result.pixels[..., :3].astype(int) - was.pixels).max(axis=2)
    assert 0.001 < (steps > 16 * (np.iinfo(depth).max // 255)).mean() < 0.5
    assert (steps <= np.iinfo(depth).max // 2**14).mean() > 0.3
