#!/usr/bin/env python3
"""Kogao for GIMP 3: the picture goes to Kogao, and comes back as a new layer.

GIMP's Python has none of Kogao's libraries, so that Kogao runs as a program of its own.
"""

import sys
from functools import partial

import common
import gi
from kogao_outside import AMOUNT, CLOSED, LARGEST, PERCENT, is_ours

gi.require_version("Gimp", "3.0")
gi.require_version("GimpUi", "3.0")
from gi.repository import Gimp, GimpUi, Gio, GLib, GObject  # noqa: E402


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
        if name == common.BY_AMOUNT:
            flags = GObject.ParamFlags.READWRITE
            procedure.add_double_argument("percent", AMOUNT, None, 0, LARGEST, PERCENT, flags)
        return procedure

    def run(self, procedure, mode, image, _drawables, config, _data):
        """Send what is visible to Kogao, and lay what comes back on top."""
        file, name = image.get_file(), procedure.get_name()
        ways = partial(save, image), partial(lay, image)
        try:
            percent = amount(procedure, mode, config) if name == common.BY_AMOUNT else None
            common.send(name, file and file.get_basename(), *ways, percent)
        except common.Cancelled:
            return procedure.new_return_values(Gimp.PDBStatusType.CANCEL, None)
        except common.Failed as failure:
            problem = GLib.Error(str(failure))
            return procedure.new_return_values(Gimp.PDBStatusType.EXECUTION_ERROR, problem)
        return procedure.new_return_values(Gimp.PDBStatusType.SUCCESS, None)


def amount(procedure, mode, config):
    """Return the percentage to go by; a user is asked, and GIMP keeps the answer."""
    if mode == Gimp.RunMode.INTERACTIVE:
        GimpUi.init("kogao")
        dialog = GimpUi.ProcedureDialog.new(procedure, config, None)
        dialog.fill(None)
        wanted = dialog.run()
        dialog.destroy()
        if not wanted:
            raise common.Cancelled
    return config.get_property("percent")


def keep_source(image):
    """Remove the layers that Kogao has made, unless nothing else is seen, and the hidden ones."""
    layers = image.get_layers()
    shown = [one for one in layers if one.get_visible()]
    theirs = [one for one in shown if not is_ours(one.get_name())]
    for one in layers:
        if one not in (theirs or shown):
            image.remove_layer(one)


def save(image, path):
    """Write what is visible of an image, and no less than all of its canvas."""
    flat = image.duplicate()
    keep_source(flat)
    flat.merge_visible_layers(Gimp.MergeType.CLIP_TO_IMAGE).resize_to_image_size()
    Gimp.file_save(Gimp.RunMode.NONINTERACTIVE, flat, Gio.File.new_for_path(path), None)
    flat.delete()
    Gimp.progress_init("Kogao")  # the file's is over


def lay(image, path, title):
    """Lay what a file shows over all other layers of an image."""
    if not image.is_valid():
        raise common.Failed(CLOSED)
    file = Gio.File.new_for_path(path)
    layer = Gimp.file_load_layer(Gimp.RunMode.NONINTERACTIVE, image, file)
    layer.set_name(title)
    image.undo_group_start()
    image.insert_layer(layer, None, 0)
    image.undo_group_end()
    Gimp.displays_flush()


Gimp.main(Kogao.__gtype__, sys.argv)
