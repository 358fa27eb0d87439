"""How a session is held: what its page asks, how large it shows pictures, and what it says."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal, get_args

from kogao_core.base.language import Text
from kogao_core.base.strict import Node

Task = Literal["natural", "slider", "pair", "same"]
Answer = Literal["natural", "unnatural", "left", "right", "same", "different"]
# What can be answered to a picture; a slider gives grades.
ANSWERS: Final[Mapping[Task, tuple[Answer, ...]]] = {
    "natural": ("natural", "unnatural"),
    "slider": (),
    "pair": ("left", "right"),
    "same": ("same", "different"),
}
# The grey round every picture, in every browser: another one changes how a face's colours look.
SURROUND: Final = "#b8b8b8"
_LONGEST_TEXT: Final = 20_000
_LONGEST_CODE: Final = 64
_SIZE: Final = re.compile(r"(\d+(?:\.\d+)?)(px|deg)")
_LARGEST: Final = {"px": 4000.0, "deg": 90.0}


@dataclass(frozen=True, slots=True)
class Conduct:
    """What all sessions of a study share."""

    # Whether a picture is natural, or how much so; or, beside the photo as it is, which of the two
    # is more so, or whether they are the same.
    task: Task = "natural"
    break_every: int = 0  # answers; 0 for no breaks
    faces_each: int = 0  # how many of the faces a rater judges; 0 for all
    swap_keys: bool = False  # for half of the raters F and J change places
    # The pictures' long side: "640px" in CSS px, "12deg" in degrees of visual angle, or "fit", the
    # largest of a few scales that fits the window when a session begins.
    size: str = "fit"
    distance_mm: int = 600  # of the eyes from the screen, for degrees
    full_screen: bool = False
    consent: str = ""  # who doesn't agree to it doesn't begin
    instructions: str = ""  # in the place of the page's own
    debriefing: str = ""  # at the end
    completion_code: str = ""  # at the end, for whoever pays

    def __post_init__(self) -> None:
        """Refuse a size that is none."""
        found = _SIZE.fullmatch(self.size)
        fits = found is not None and 1.0 <= float(found[1]) <= _LARGEST[found[2]]
        if self.size != "fit" and not fits:
            raise ValueError(
                Text("{size} is no size such as fit, 640px or 12deg", size=repr(self.size))
            )

    @property
    def pairs(self) -> bool:
        """Whether pictures are shown beside the photo as it is."""
        return self.task in ("pair", "same")

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON values."""
        return dataclasses.asdict(self)

    @staticmethod
    def parse(node: Node) -> Conduct:
        """Read what a study holds."""
        node.only([one.name for one in dataclasses.fields(Conduct)])
        text = node.field("task").text(20, get_args(Task))
        task: Task = next(task for task in get_args(Task) if task == text)
        try:
            return Conduct(
                task,
                node.field("break_every").whole(0, 10**6),
                node.field("faces_each").whole(0, 10**6),
                node.field("swap_keys").flag(),
                node.field("size").text(20),
                node.field("distance_mm").whole(100, 10**5),
                node.field("full_screen").flag(),
                _text(node.field("consent")),
                _text(node.field("instructions")),
                _text(node.field("debriefing")),
                node.field("completion_code").text(_LONGEST_CODE),
            )
        except ValueError as problem:
            node.refuse(str(problem))


CONDUCT: Final = Conduct()


def _text(node: Node) -> str:
    """Return a text of several lines, which `Node.text` has not."""
    if not isinstance(node.value, str) or len(node.value) > _LONGEST_TEXT:
        node.refuse(Text("must be a text"))
    return node.value
