"""What can be wrong with a landmark model."""


class ModelRefused(RuntimeError):
    """A file is no model of the kind asked for, or a damaged one; the message is one sentence."""
