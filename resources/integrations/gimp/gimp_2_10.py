"""Kogao for GIMP 2.10: the picture goes to Kogao, and comes back as a new layer.

GIMP runs any program that speaks to it by its library, which ctypes can load.
"""

import os
import sys
from ctypes import (
    CDLL,
    CFUNCTYPE,
    POINTER,
    Structure,
    Union,
    byref,
    c_char_p,
    c_double,
    c_int,
    c_int32,
)
from functools import partial

import common

# Of GIMP's enumerations: kinds of arguments and procedures, how one is called, and how it ends.
INT32, STRING, IMAGE, DRAWABLE, STATUS = 0, 4, 13, 16, 21
PLUGIN = 1
NONINTERACTIVE = 1
CLIP_TO_IMAGE = 1
EXECUTION_ERROR, SUCCESS, CANCEL = 0, 3, 4


class Declared(Structure):
    """GimpParamDef."""

    _fields_ = (("type", c_int), ("name", c_char_p), ("description", c_char_p))


class Data(Union):
    """GimpParamData: what is used of it, and its largest, a colour."""

    _fields_ = (("number", c_int32), ("text", c_char_p), ("colour", c_double * 4))


class Value(Structure):
    """GimpParam."""

    _fields_ = (("type", c_int), ("data", Data))


Call = CFUNCTYPE(None)
Run = CFUNCTYPE(None, c_char_p, c_int, POINTER(Value), POINTER(c_int), POINTER(POINTER(Value)))


class PlugIn(Structure):
    """GimpPlugInInfo."""

    _fields_ = (("init", Call), ("quit", Call), ("query", Call), ("run", Run))


gimp = CDLL("libgimp-2.0.so.0")
gimp.gimp_get_pdb_error.restype = gimp.gimp_image_get_filename.restype = c_char_p
returned = (Value * 2)()  # GIMP reads it after a run


def query():
    """Declare the procedures."""
    arguments = (Declared * 3)(
        (INT32, b"run-mode", b"How it is called"),
        (IMAGE, b"image", b"The picture"),
        (DRAWABLE, b"drawable", b"Not used: what is visible goes out"),
    )
    for name, (label, _) in common.COMMANDS.items():
        texts = (name, *common.DOCUMENTATION, *common.ATTRIBUTION, label, common.IMAGE_TYPES)
        gimp.gimp_install_procedure(
            *(text.encode() for text in texts), PLUGIN, len(arguments), 0, arguments, None
        )
        gimp.gimp_plugin_menu_register(name.encode(), common.MENU.rstrip("/").encode())


def run(name, _count, values, length, results):
    """Send what is visible to Kogao, and lay what comes back on top."""
    image, status, said = values[1].data.number, SUCCESS, b""
    try:
        file = gimp.gimp_image_get_filename(image)
        ways = partial(save, image), partial(lay, image)
        common.send(name.decode(), file and os.fsdecode(file), *ways)
    except common.Cancelled:
        status = CANCEL
    except Exception as problem:  # beyond here nobody hears of it
        status, said = EXECUTION_ERROR, str(problem).encode()
    returned[0] = Value(STATUS, Data(number=status))
    returned[1] = Value(STRING, Data(text=said))
    length[0] = 2 if said else 1
    results[0] = returned


def save(image, path):
    """Write what is visible of an image, and no less than all of its canvas."""
    flat = gimp.gimp_image_duplicate(image)
    layer = gimp.gimp_image_merge_visible_layers(flat, CLIP_TO_IMAGE)
    file = os.fsencode(path)
    try:
        check(layer != -1 and gimp.gimp_layer_resize_to_image_size(layer))
        check(gimp.gimp_file_save(NONINTERACTIVE, flat, layer, file, file))
    finally:
        gimp.gimp_image_delete(flat)
    gimp.gimp_progress_init(b"Kogao")  # the file's is over


def lay(image, path):
    """Lay what a file shows over all other layers of an image."""
    if not gimp.gimp_image_is_valid(image):
        raise common.Failed(common.CLOSED)
    layer = gimp.gimp_file_load_layer(NONINTERACTIVE, image, os.fsencode(path))
    check(layer != -1)
    gimp.gimp_item_set_name(layer, common.LAYER.encode())
    gimp.gimp_image_undo_group_start(image)
    check(gimp.gimp_image_insert_layer(image, layer, 0, 0))
    gimp.gimp_image_undo_group_end(image)
    gimp.gimp_displays_flush()


def check(is_done):
    """Raise what GIMP complained of last, unless all is well."""
    if not is_done:
        raise common.Failed(gimp.gimp_get_pdb_error().decode())


plug_in = PlugIn(query=Call(query), run=Run(run))
words = (c_char_p * len(sys.argv))(*map(os.fsencode, sys.argv))
sys.exit(gimp.gimp_main(byref(plug_in), len(words), words))
