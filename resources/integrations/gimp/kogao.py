#!/usr/bin/env python3
"""Kogao for GIMP 3: the picture goes to Kogao, and comes back as a new layer.

GIMP's Python has none of Kogao's libraries, so that Kogao runs as a program of its own.
"""

import sys
from functools import partial

import common
import gi

gi.require_version("Gimp", "3.0")
from gi.repository import Gimp, Gio, GLib  # noqa: E402


class Kogao(Gimp.PlugIn):
    """Two procedures under Filters > Distorts."""

    def do_query_procedures(self):
        """Return their names."""
        return list(common.COMMANDS)

    def do_set_i18n(self, _name):
        """Return that there are no translations."""
        return False

    def do_create_procedure(self, name):
        """Declare one of them."""
        kind = Gimp.PDBProcType.PLUGIN
        procedure = Gimp.ImageProcedure.new(self, name, kind, self.run, None)
        procedure.set_image_types(common.IMAGE_TYPES)
        procedure.set_menu_label(common.COMMANDS[name][0])
        procedure.add_menu_path(common.MENU)
        procedure.set_documentation(*common.DOCUMENTATION, name)
        procedure.set_attribution(*common.ATTRIBUTION)
        return procedure

    def run(self, procedure, _mode, image, _drawables, _config, _data):
        """Send what is visible to Kogao, and lay what comes back on top."""
        file = image.get_file()
        ways = partial(save, image), partial(lay, image)
        try:
            common.send(procedure.get_name(), file and file.get_basename(), *ways)
        except common.Cancelled:
            return procedure.new_return_values(Gimp.PDBStatusType.CANCEL, None)
        except common.Failed as failure:
            problem = GLib.Error(str(failure))
            return procedure.new_return_values(Gimp.PDBStatusType.EXECUTION_ERROR, problem)
        return procedure.new_return_values(Gimp.PDBStatusType.SUCCESS, None)


def save(image, path):
    """Write what is visible of an image, and no less than all of its canvas."""
    flat = image.duplicate()
    flat.merge_visible_layers(Gimp.MergeType.CLIP_TO_IMAGE).resize_to_image_size()
    Gimp.file_save(Gimp.RunMode.NONINTERACTIVE, flat, Gio.File.new_for_path(path), None)
    flat.delete()
    Gimp.progress_init("Kogao")  # the file's is over


def lay(image, path):
    """Lay what a file shows over all other layers of an image."""
    if not image.is_valid():
        raise common.Failed(common.CLOSED)
    file = Gio.File.new_for_path(path)
    layer = Gimp.file_load_layer(Gimp.RunMode.NONINTERACTIVE, image, file)
    layer.set_name(common.LAYER)
    image.undo_group_start()
    image.insert_layer(layer, None, 0)
    image.undo_group_end()
    Gimp.displays_flush()


Gimp.main(Kogao.__gtype__, sys.argv)
