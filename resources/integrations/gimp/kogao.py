#!/usr/bin/env python3
"""Kogao for GIMP 3: the picture goes to Kogao, and comes back as a new layer.

Installed by `kogao-cli integrate gimp`, which fills in where the programs lie. GIMP's Python has
none of Kogao's libraries, so Kogao runs as a program of its own, on a file that it writes over.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import gi

gi.require_version("Gimp", "3.0")
from gi.repository import Gimp, Gio, GLib  # noqa: E402

# Within a Flatpak: out of its sandbox, whose /tmp others may not see; its cache is a usual folder.
SANDBOXED = "FLATPAK_ID" in os.environ
OUT = ["flatpak-spawn", "--host"] if SANDBOXED else []
SHARED = os.environ.get("XDG_CACHE_HOME") if SANDBOXED else None
EDITOR = [*OUT, "@KOGAO@", "--edit"]
BY_ITSELF = [*OUT, "@KOGAO_CLI@", "warp", "--in-place"]
CANCELLED = 6
COMMANDS = {
    "kogao-edit": ("_Kogao: edit…", EDITOR),
    "kogao-by-itself": ("Kogao: _smaller faces", BY_ITSELF),
}


class Kogao(Gimp.PlugIn):
    """Two procedures under Filters > Distorts."""

    def do_query_procedures(self):
        """Return their names."""
        return list(COMMANDS)

    def do_set_i18n(self, _name):
        """Return that there are no translations."""
        return False

    def do_create_procedure(self, name):
        """Declare one of them."""
        kind = Gimp.PDBProcType.PLUGIN
        procedure = Gimp.ImageProcedure.new(self, name, kind, self.run, None)
        procedure.set_image_types("RGB*, GRAY*")
        procedure.set_menu_label(COMMANDS[name][0])
        procedure.add_menu_path("<Image>/Filters/Distorts/")
        procedure.set_documentation("Make faces smaller", "The result is a new layer.", name)
        procedure.set_attribution("Kogao", "Kogao", "2026")
        return procedure

    def run(self, procedure, _mode, image, _drawables, _config, _data):
        """Send what is visible to Kogao, and lay what comes back on top."""
        with tempfile.TemporaryDirectory(prefix="kogao-", dir=SHARED) as folder:
            path = str(Path(folder, "picture.tif"))
            file = Gio.File.new_for_path(path)
            flat = image.duplicate()
            flat.merge_visible_layers(Gimp.MergeType.CLIP_TO_IMAGE)
            Gimp.file_save(Gimp.RunMode.NONINTERACTIVE, flat, file, None)
            flat.delete()
            done = subprocess.run(
                [*COMMANDS[procedure.get_name()][1], path], capture_output=True, text=True
            )
            if done.returncode == CANCELLED:
                return procedure.new_return_values(Gimp.PDBStatusType.CANCEL, None)
            if done.returncode:
                problem = GLib.Error(done.stderr.strip() or f"code {done.returncode}")
                return procedure.new_return_values(Gimp.PDBStatusType.EXECUTION_ERROR, problem)
            layer = Gimp.file_load_layer(Gimp.RunMode.NONINTERACTIVE, image, file)
        layer.set_name("Kogao")
        image.undo_group_start()
        image.insert_layer(layer, None, 0)
        image.undo_group_end()
        Gimp.displays_flush()
        return procedure.new_return_values(Gimp.PDBStatusType.SUCCESS, None)


Gimp.main(Kogao.__gtype__, sys.argv)
