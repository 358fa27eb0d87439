"""Kogao for GIMP 2.10: sends the picture to Kogao and adds the result as a new layer.

GIMP runs any program that uses its library; ctypes loads the library.
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
from kogao_outside import AMOUNT, AMOUNT_LABEL, CLOSED, LARGEST, is_result

# GIMP's enumerations: types of arguments and procedures, run modes, status codes.
INT32, FLOAT, STRING, IMAGE, DRAWABLE, STATUS = 0, 3, 4, 13, 16, 21
PLUGIN = 1
INTERACTIVE, WITH_LAST_VALUES = 0, 2
NONINTERACTIVE = 1
CLIP_TO_IMAGE = 1
RGB_IMAGE, GRAY, NORMAL = 0, 1, 28  # types of layer and image, layer mode
FOREGROUND, BACKGROUND = 0, 1
EXECUTION_ERROR, SUCCESS, CANCEL = 0, 3, 4
GTK_OK, GTK_CANCEL = -5, -6
GAP_PX, WIDTH_PX = 6, 320
STORED = b"kogao-amount"


class Declared(Structure):
    """GimpParamDef."""

    _fields_ = (("type", c_int), ("name", c_char_p), ("description", c_char_p))


class Data(Union):
    """GimpParamData: the fields used here, and the largest, a colour."""

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
returned = (Value * 2)()  # global, because GIMP reads the values after `run`


def query():
    """Declare the procedures."""
    arguments = (Declared * 4)(
        (INT32, b"run-mode", b"Run mode"),
        (IMAGE, b"image", b"The picture"),
        (DRAWABLE, b"drawable", b"Not used: Kogao gets the visible picture"),
        (FLOAT, b"amount", b"Amount, %"),
    )
    for name, (label, _) in common.COMMANDS.items():
        texts = (name, *common.DOCUMENTATION, *common.ATTRIBUTION, label, common.IMAGE_TYPES)
        count = 4 if name == common.SMALLER_NAME else 3
        gimp.gimp_install_procedure(
            *(text.encode() for text in texts), PLUGIN, count, 0, arguments, None
        )
        gimp.gimp_plugin_menu_register(name.encode(), common.MENU.rstrip("/").encode())


def run(name, count, values, length, results):
    """Send the visible picture to Kogao and add the result as the top layer."""
    image, status, message = values[1].data.number, SUCCESS, b""
    try:
        given = values[3].data.real if count > 3 else None
        is_smaller = name.decode() == common.SMALLER_NAME
        amount = amount_of(values[0].data.number, given) if is_smaller else None
        file = gimp.gimp_image_get_filename(image)
        exchange = partial(save, image), partial(add_layer, image)
        select = partial(save_selection, image)
        common.send(name.decode(), file and os.fsdecode(file), *exchange, amount, select)
    except common.Cancelled:
        status = CANCEL
    except Exception as problem:  # ctypes would drop the exception
        status, message = EXECUTION_ERROR, str(problem).encode()
    returned[0] = Value(STATUS, Data(number=status))
    returned[1] = Value(STRING, Data(text=message))
    length[0] = 2 if message else 1
    results[0] = returned


def amount_of(mode, given):
    """Return the Amount, %, from the user in interactive mode; GIMP stores the answer."""
    value = c_double(AMOUNT)
    gimp.gimp_procedural_db_get_data(STORED, byref(value))
    if mode == INTERACTIVE:
        value.value = ask_amount(value.value)
    elif mode != WITH_LAST_VALUES and given is not None:
        return given
    gimp.gimp_procedural_db_set_data(STORED, byref(value), sizeof(value))
    return value.value


def ask_amount(amount):
    """Ask for the Amount, %, in a dialog. Raises Cancelled."""
    ui, gtk = CDLL("libgimpui-2.0.so.0"), CDLL("libgtk-x11-2.0.so.0")
    for function in (
        ui.gimp_dialog_new,
        gtk.gtk_dialog_get_content_area,
        gtk.gtk_hbox_new,
        gtk.gtk_label_new,
        gtk.gtk_spin_button_new_with_range,
    ):
        function.restype = c_void_p
    gtk.gtk_spin_button_get_value.restype = c_double
    ui.gimp_ui_init(b"kogao", 0)
    title = common.COMMANDS[common.SMALLER_NAME][0].replace("_", "").encode()
    buttons = b"gtk-cancel", GTK_CANCEL, b"gtk-ok", GTK_OK, None
    dialog = c_void_p(ui.gimp_dialog_new(title, b"kogao", None, 0, None, None, *buttons))
    gtk.gtk_window_set_default_size(dialog, WIDTH_PX, -1)  # room for the title
    row = c_void_p(gtk.gtk_hbox_new(0, GAP_PX))
    label = c_void_p(gtk.gtk_label_new(AMOUNT_LABEL.encode()))
    number = c_void_p(
        gtk.gtk_spin_button_new_with_range(c_double(0), c_double(LARGEST), c_double(0.5))
    )
    gtk.gtk_spin_button_set_value(number, c_double(amount))
    gtk.gtk_entry_set_activates_default(number, 1)
    gtk.gtk_dialog_set_default_response(dialog, GTK_OK)
    for one in (label, number):
        gtk.gtk_box_pack_start(row, one, 0, 0, GAP_PX)
    content = c_void_p(gtk.gtk_dialog_get_content_area(dialog))
    gtk.gtk_box_pack_start(content, row, 0, 0, GAP_PX)
    gtk.gtk_widget_show_all(content)
    answer = ui.gimp_dialog_run(dialog)
    amount = gtk.gtk_spin_button_get_value(number)
    gtk.gtk_widget_destroy(dialog)
    if answer != GTK_OK:
        raise common.Cancelled
    return amount


def keep_source(image):
    """Remove hidden layers and, unless all visible layers are results, the results of Kogao."""
    count = c_int()
    layers = gimp.gimp_image_get_layers(image, byref(count))[: count.value]
    visible = [layer for layer in layers if gimp.gimp_item_get_visible(layer)]
    names = {layer: gimp.gimp_item_get_name(layer).decode() for layer in visible}
    source = [layer for layer in visible if not is_result(names[layer])]
    for layer in set(layers) - set(source or visible):
        gimp.gimp_image_remove_layer(image, layer)


def save(image, path):
    """Write the visible picture, with the size of the canvas."""
    flat = gimp.gimp_image_duplicate(image)
    keep_source(flat)
    layer = gimp.gimp_image_merge_visible_layers(flat, CLIP_TO_IMAGE)
    export(flat, layer, path)


def save_selection(image, path):
    """Write the selection, white on black; return False without one."""
    if gimp.gimp_selection_is_empty(image):
        return False
    flat = gimp.gimp_image_duplicate(image)
    if gimp.gimp_image_base_type(flat) == GRAY:
        gimp.gimp_image_convert_rgb(flat)
    size = gimp.gimp_image_width(flat), gimp.gimp_image_height(flat)
    layer = gimp.gimp_layer_new(flat, b"selection", *size, RGB_IMAGE, c_double(100), NORMAL)
    gimp.gimp_image_insert_layer(flat, layer, 0, 0)
    gimp.gimp_context_push()
    gimp.gimp_context_set_default_colors()  # black, white
    gimp.gimp_drawable_fill(layer, FOREGROUND)
    gimp.gimp_drawable_edit_fill(layer, BACKGROUND)  # where selected
    gimp.gimp_context_pop()
    export(flat, gimp.gimp_image_flatten(flat), path)
    return True


def export(flat, layer, path):
    """Write a layer of a copy of an image as TIFF, and delete the copy."""
    file = os.fsencode(path)
    try:
        check(layer != -1 and gimp.gimp_layer_resize_to_image_size(layer))
        check(gimp.gimp_file_save(NONINTERACTIVE, flat, layer, file, file))
    finally:
        gimp.gimp_image_delete(flat)
    gimp.gimp_progress_init(b"Kogao")  # replaces the message about the exported file


def add_layer(image, path, title):
    """Add a file as the top layer of an image."""
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
    """Raise Failed with GIMP's last error unless `is_done`."""
    if not is_done:
        raise common.Failed(gimp.gimp_get_pdb_error().decode())


plug_in = PlugIn(query=Call(query), run=Run(run))
words = (c_char_p * len(sys.argv))(*map(os.fsencode, sys.argv))
sys.exit(gimp.gimp_main(byref(plug_in), len(words), words))
