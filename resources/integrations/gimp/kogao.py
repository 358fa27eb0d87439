#!/usr/bin/env python3
"""Kogao for GIMP 3: sends the picture to Kogao and adds the result as a new layer.

GIMP's Python has none of Kogao's libraries, so Kogao runs as a separate program.
"""

import os
import sys
from functools import partial

import common
from kogao_outside import AMOUNT, AMOUNT_LABEL, CLOSED, LARGEST, is_result

SYSTEM_PYTHON = "/usr/bin/python3"
try:
    import gi
except ModuleNotFoundError:
    # An environment that is first on PATH has no library of GIMP.
    if sys.executable == SYSTEM_PYTHON or not os.path.exists(SYSTEM_PYTHON):
        raise
    os.execv(SYSTEM_PYTHON, [SYSTEM_PYTHON, *sys.argv])

gi.require_version("Gimp", "3.0")
gi.require_version("GimpUi", "3.0")
from gi.repository import Gimp, GimpUi, Gio, GLib, GObject  # noqa: E402


class Kogao(Gimp.PlugIn):
    """Two procedures under Filters > Distorts."""

    def do_query_procedures(self):
        """Return the names of the procedures."""
        return list(common.COMMANDS)

    def do_set_i18n(self, _name):
        """Return False: GIMP has no translations of the plug-in."""
        return False

    def do_create_procedure(self, name):
        """Declare a procedure."""
        kind = Gimp.PDBProcType.PLUGIN
        procedure = Gimp.ImageProcedure.new(self, name, kind, self.run, None)
        procedure.set_image_types(common.IMAGE_TYPES)
        procedure.set_menu_label(common.COMMANDS[name][0])
        procedure.add_menu_path(common.MENU)
        procedure.set_documentation(*common.DOCUMENTATION, name)
        procedure.set_attribution(*common.ATTRIBUTION)
        if name == common.SMALLER_NAME:
            flags = GObject.ParamFlags.READWRITE
            procedure.add_double_argument("amount", AMOUNT_LABEL, None, 0, LARGEST, AMOUNT, flags)
        return procedure

    def run(self, procedure, mode, image, _drawables, config, _data):
        """Send the visible picture to Kogao and add the result as the top layer."""
        file, name = image.get_file(), procedure.get_name()
        exchange = partial(save, image), partial(add_layer, image)
        select = partial(save_selection, image)
        try:
            amount = ask_amount(procedure, mode, config) if name == common.SMALLER_NAME else None
            common.send(name, file and file.get_basename(), *exchange, amount, select)
        except common.Cancelled:
            return procedure.new_return_values(Gimp.PDBStatusType.CANCEL, None)
        except common.Failed as failure:
            problem = GLib.Error(str(failure))
            return procedure.new_return_values(Gimp.PDBStatusType.EXECUTION_ERROR, problem)
        return procedure.new_return_values(Gimp.PDBStatusType.SUCCESS, None)


def ask_amount(procedure, mode, config):
    """Return the Amount, %, from the user in interactive mode; GIMP stores the answer."""
    if mode == Gimp.RunMode.INTERACTIVE:
        GimpUi.init("kogao")
        dialog = GimpUi.ProcedureDialog.new(procedure, config, None)
        dialog.fill(None)
        is_accepted = dialog.run()
        dialog.destroy()
        if not is_accepted:
            raise common.Cancelled
    return config.get_property("amount")


def keep_source(image):
    """Remove hidden layers and, unless all visible layers are results, the results of Kogao."""
    layers = image.get_layers()
    visible = [layer for layer in layers if layer.get_visible()]
    source = [layer for layer in visible if not is_result(layer.get_name())]
    for layer in layers:
        if layer not in (source or visible):
            image.remove_layer(layer)


def save(image, path):
    """Write the visible picture, with the size of the canvas."""
    flat = image.duplicate()
    keep_source(flat)
    flat.merge_visible_layers(Gimp.MergeType.CLIP_TO_IMAGE).resize_to_image_size()
    if flat.get_base_type() == Gimp.ImageBaseType.GRAY:
        flat.convert_rgb()  # Kogao reads no grey with alpha in 16 or 32 bits
    export_tiff(flat, path)


def save_selection(image, path):
    """Write the selection, white on black; return False without one."""
    if Gimp.Selection.is_empty(image):
        return False
    flat = image.duplicate()
    if flat.get_base_type() == Gimp.ImageBaseType.GRAY:
        flat.convert_rgb()
    size = flat.get_width(), flat.get_height()
    kind, mode = Gimp.ImageType.RGB_IMAGE, Gimp.LayerMode.NORMAL
    layer = Gimp.Layer.new(flat, "selection", *size, kind, 100, mode)
    flat.insert_layer(layer, None, 0)
    Gimp.context_push()
    Gimp.context_set_default_colors()  # black, white
    layer.fill(Gimp.FillType.FOREGROUND)
    layer.edit_fill(Gimp.FillType.BACKGROUND)  # where selected
    Gimp.context_pop()
    flat.flatten()
    export_tiff(flat, path)
    return True


def export_tiff(flat, path):
    """Write a copy of an image as TIFF, and delete the copy."""
    export = Gimp.get_pdb().lookup_procedure("file-tiff-export")
    config = export.create_config()
    config.set_property("run-mode", Gimp.RunMode.NONINTERACTIVE)
    config.set_property("image", flat)
    config.set_property("file", Gio.File.new_for_path(path))
    for thumbnail in ("save-thumbnail", "include-thumbnail"):  # of 3.0 and of 3.2
        if config.find_property(thumbnail):
            config.set_property(thumbnail, False)
    export.run(config)
    flat.delete()
    Gimp.progress_init("Kogao")  # replaces the message about the exported file


def add_layer(image, path, title):
    """Add a file as the top layer of an image."""
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
