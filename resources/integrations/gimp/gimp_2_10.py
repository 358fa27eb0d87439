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
    c_void_p,
    sizeof,
)
from functools import partial

import common
from kogao_outside import AMOUNT, CLOSED, LARGEST, PERCENT, is_ours

# Of GIMP's enumerations: kinds of arguments and procedures, how one is called, and how it ends.
INT32, FLOAT, STRING, IMAGE, DRAWABLE, STATUS = 0, 3, 4, 13, 16, 21
PLUGIN = 1
INTERACTIVE, WITH_LAST_VALUES = 0, 2
NONINTERACTIVE = 1
CLIP_TO_IMAGE = 1
EXECUTION_ERROR, SUCCESS, CANCEL = 0, 3, 4
GTK_OK, GTK_CANCEL = -5, -6
GAP_PX = 6
KEPT = b"kogao-percent"


class Declared(Structure):
    """GimpParamDef."""

    _fields_ = (("type", c_int), ("name", c_char_p), ("description", c_char_p))


class Data(Union):
    """GimpParamData: what is used of it, and its largest, a colour."""

    _fields_ = (
        ("number", c_int32),
        ("real", c_double),
        ("text", c_char_p),
        ("colour", c_double * 4),
    )


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
gimp.gimp_item_get_name.restype = c_char_p
gimp.gimp_image_get_layers.restype = POINTER(c_int)
returned = (Value * 2)()  # GIMP reads it after a run


def query():
    """Declare the procedures."""
    arguments = (Declared * 4)(
        (INT32, b"run-mode", b"How it is called"),
        (IMAGE, b"image", b"The picture"),
        (DRAWABLE, b"drawable", b"Not used: what is visible goes out"),
        (FLOAT, b"percent", b"How far the outline moves, % of its distance to the centre"),
    )
    for name, (label, _) in common.COMMANDS.items():
        texts = (name, *common.DOCUMENTATION, *common.ATTRIBUTION, label, common.IMAGE_TYPES)
        count = 4 if name == common.BY_AMOUNT else 3
        gimp.gimp_install_procedure(
            *(text.encode() for text in texts), PLUGIN, count, 0, arguments, None
        )
        gimp.gimp_plugin_menu_register(name.encode(), common.MENU.rstrip("/").encode())


def run(name, count, values, length, results):
    """Send what is visible to Kogao, and lay what comes back on top."""
    image, status, said = values[1].data.number, SUCCESS, b""
    try:
        given = values[3].data.real if count > 3 else None
        percent = (
            amount(values[0].data.number, given) if name.decode() == common.BY_AMOUNT else None
        )
        file = gimp.gimp_image_get_filename(image)
        ways = partial(save, image), partial(lay, image)
        common.send(name.decode(), file and os.fsdecode(file), *ways, percent)
    except common.Cancelled:
        status = CANCEL
    except Exception as problem:  # beyond here nobody hears of it
        status, said = EXECUTION_ERROR, str(problem).encode()
    returned[0] = Value(STATUS, Data(number=status))
    returned[1] = Value(STRING, Data(text=said))
    length[0] = 2 if said else 1
    results[0] = returned


def amount(mode, given):
    """Return the percentage to go by; a user is asked, and GIMP keeps the answer."""
    value = c_double(PERCENT)
    gimp.gimp_procedural_db_get_data(KEPT, byref(value))
    if mode == INTERACTIVE:
        value.value = asked(value.value)
    elif mode != WITH_LAST_VALUES and given is not None:
        return given
    gimp.gimp_procedural_db_set_data(KEPT, byref(value), sizeof(value))
    return value.value


def asked(percent):
    """Return what a user wants instead."""
    ui, gtk = CDLL("libgimpui-2.0.so.0"), CDLL("libgtk-x11-2.0.so.0")
    for made in (
        ui.gimp_dialog_new,
        gtk.gtk_dialog_get_content_area,
        gtk.gtk_hbox_new,
        gtk.gtk_label_new,
        gtk.gtk_spin_button_new_with_range,
    ):
        made.restype = c_void_p
    gtk.gtk_spin_button_get_value.restype = c_double
    ui.gimp_ui_init(b"kogao", 0)
    title = common.COMMANDS[common.BY_AMOUNT][0].replace("_", "").encode()
    buttons = b"gtk-cancel", GTK_CANCEL, b"gtk-ok", GTK_OK, None
    dialog = c_void_p(ui.gimp_dialog_new(title, b"kogao", None, 0, None, None, *buttons))
    row = c_void_p(gtk.gtk_hbox_new(0, GAP_PX))
    label = c_void_p(gtk.gtk_label_new(AMOUNT.encode()))
    number = c_void_p(
        gtk.gtk_spin_button_new_with_range(c_double(0), c_double(LARGEST), c_double(0.5))
    )
    gtk.gtk_spin_button_set_value(number, c_double(percent))
    gtk.gtk_entry_set_activates_default(number, 1)
    gtk.gtk_dialog_set_default_response(dialog, GTK_OK)
    for one in (label, number):
        gtk.gtk_box_pack_start(row, one, 0, 0, GAP_PX)
    content = c_void_p(gtk.gtk_dialog_get_content_area(dialog))
    gtk.gtk_box_pack_start(content, row, 0, 0, GAP_PX)
    gtk.gtk_widget_show_all(content)
    answer = ui.gimp_dialog_run(dialog)
    percent = gtk.gtk_spin_button_get_value(number)
    gtk.gtk_widget_destroy(dialog)
    if answer != GTK_OK:
        raise common.Cancelled
    return percent


def keep_source(image):
    """Remove the layers that Kogao has made, unless nothing else is seen, and the hidden ones."""
    count = c_int()
    layers = gimp.gimp_image_get_layers(image, byref(count))[: count.value]
    shown = [one for one in layers if gimp.gimp_item_get_visible(one)]
    theirs = [one for one in shown if not is_ours(gimp.gimp_item_get_name(one).decode())]
    for one in set(layers) - set(theirs or shown):
        gimp.gimp_image_remove_layer(image, one)


def save(image, path):
    """Write what is visible of an image, and no less than all of its canvas."""
    flat = gimp.gimp_image_duplicate(image)
    keep_source(flat)
    layer = gimp.gimp_image_merge_visible_layers(flat, CLIP_TO_IMAGE)
    file = os.fsencode(path)
    try:
        check(layer != -1 and gimp.gimp_layer_resize_to_image_size(layer))
        check(gimp.gimp_file_save(NONINTERACTIVE, flat, layer, file, file))
    finally:
        gimp.gimp_image_delete(flat)
    gimp.gimp_progress_init(b"Kogao")  # the file's is over


def lay(image, path, title):
    """Lay what a file shows over all other layers of an image."""
    if not gimp.gimp_image_is_valid(image):
        raise common.Failed(CLOSED)
    layer = gimp.gimp_file_load_layer(NONINTERACTIVE, image, os.fsencode(path))
    check(layer != -1)
    gimp.gimp_item_set_name(layer, title.encode())
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
