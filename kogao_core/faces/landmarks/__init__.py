"""Where faces come from: networks, the paper's AAM, a user's model, or a mean face set by hand."""

from kogao_core.faces.landmarks.locked import ModelRefused
from kogao_core.faces.landmarks.mesh import MeshSource
from kogao_core.faces.landmarks.sources import (
    CHOICES,
    Choice,
    Measured,
    check_networks,
    find,
    networks_are_here,
    source,
    template_face,
)

__all__ = [
    "CHOICES",
    "Choice",
    "Measured",
    "MeshSource",
    "ModelRefused",
    "check_networks",
    "find",
    "networks_are_here",
    "source",
    "template_face",
]
