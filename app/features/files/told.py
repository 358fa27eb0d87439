"""What saved pictures tell about themselves: nothing, unless the user wants it; remembered."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, Final

from PySide6.QtCore import QSettings

from kogao_core.photo.credentials import Signer
from kogao_core.photo.disclosure import Disclosure
from kogao_core.photo.label import LONGEST
from kogao_core.photo.label_picture import LabelPicture
from kogao_core.settings import CORNERS, LABEL_CORNER, LABEL_PERCENT, LABEL_SHARE, Corner

from ...i18n import tr

_GROUP: Final = "saving"


@dataclass(frozen=True, slots=True)
class Told:
    """What pictures are to tell, and what the user has entered for the time when they are to.

    Parameters
    ----------
    record, labelled, pictured, signed : bool
        Whether there is an edit record, a label of text, one that is a picture, and credentials
        that are signed.
    label, picture : str
        The text, and the picture's file.
    corner : str
        Where the picture lies.
    share : float
        How much of the photo's area it takes, %.
    certificate, key : str
        Files that it takes to sign.
    """

    record: bool = False
    labelled: bool = False
    label: str = ""
    pictured: bool = False
    picture: str = ""
    corner: Corner = LABEL_CORNER
    share: float = LABEL_PERCENT
    signed: bool = False
    certificate: str = ""
    key: str = ""

    @staticmethod
    def remembered(settings: QSettings) -> Told:
        """Return what was chosen last; what makes no sense is as at first."""
        first = dataclasses.asdict(Told(label=tr("Retouched")))
        kept: dict[str, Any] = {
            name: settings.value(f"{_GROUP}/{name}", value, type(value))
            for name, value in first.items()
        }
        least, most = LABEL_SHARE
        kept["label"] = kept["label"][:LONGEST]
        kept["share"] = min(max(kept["share"], least), most)
        if kept["corner"] not in CORNERS:
            kept["corner"] = LABEL_CORNER
        return Told(**kept)

    def remember(self, settings: QSettings) -> None:
        """Keep the choices for this time and later."""
        for name, value in dataclasses.asdict(self).items():
            settings.setValue(f"{_GROUP}/{name}", value)

    @property
    def disclosure(self) -> Disclosure:
        """What of it is wanted."""
        laid = LabelPicture(self.picture, self.corner, self.share) if self.pictured else None
        signer = Signer(self.certificate, self.key) if self.signed else None
        label = self.label if self.labelled else ""
        return Disclosure(self.record, label, picture=laid, signer=signer)


def words(what: Disclosure) -> str:
    """Return what pictures tell, as a line for the user; empty for nothing."""
    parts = []
    if what.record:
        parts.append(tr("an edit record"))
    if what.label:
        parts.append(tr("the label “{label}”", label=what.label))
    if what.picture:
        parts.append(tr("a picture as label"))
    if what.signer:
        parts.append(tr("signed content credentials"))
    return tr("Results carry {what} (Save options).", what=" + ".join(parts)) if parts else ""
