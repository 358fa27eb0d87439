"""What saved pictures tell about themselves: nothing, unless the user wants it; remembered."""

from __future__ import annotations

from typing import Final

from PySide6.QtCore import QSettings

from kogao_core.photo.disclosure import Disclosure
from kogao_core.photo.label import LONGEST

from .i18n import tr

_RECORD: Final = "saving/record"
_LABEL: Final = "saving/label"
_LABELLED: Final = "saving/labelled"


def disclosure(settings: QSettings) -> Disclosure:
    """Return what saved pictures are to tell."""
    record = bool(settings.value(_RECORD, False, bool))
    return Disclosure(record, label(settings) if is_labelled(settings) else "")


def label(settings: QSettings) -> str:
    """Return the text of the label, whether it is wanted or not."""
    return str(settings.value(_LABEL, tr("Retouched"), str))[:LONGEST]


def is_labelled(settings: QSettings) -> bool:
    """Return whether pictures get a label."""
    return bool(settings.value(_LABELLED, False, bool))


def remember(settings: QSettings, *, record: bool, labelled: bool, label: str) -> None:
    """Keep the choices for this time and later."""
    settings.setValue(_RECORD, record)
    settings.setValue(_LABELLED, labelled)
    settings.setValue(_LABEL, label[:LONGEST])


def words(told: Disclosure) -> str:
    """Return what pictures tell, as a line for the user; empty for nothing."""
    parts = []
    if told.record:
        parts.append(tr("an edit record"))
    if told.label:
        parts.append(tr("the label “{label}”", label=told.label))
    return tr("Results carry {what} (Save options).", what=" + ".join(parts)) if parts else ""
