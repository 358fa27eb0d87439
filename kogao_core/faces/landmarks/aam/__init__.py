"""The paper's own extractor of feature points: an Active Appearance Model (section 3.1)."""

from kogao_core.faces.landmarks.aam.source import AamSource
from kogao_core.faces.landmarks.locked import ModelRefused

__all__ = ["AamSource", "ModelRefused"]
