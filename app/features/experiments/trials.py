"""Store the setting times of photos set by hand, for table 2."""

from __future__ import annotations

import secrets
from collections.abc import Sequence

from kogao_core.base.wording import system_reason
from kogao_core.faces.face import Face
from kogao_core.lab.experiments import trials
from kogao_core.lab.experiments.trials import Mode, Trial
from kogao_core.lab.subjects import set_by_hand

from ...i18n import tr
from ..faces import Faces
from ..feature import Context, Feature
from ..manual import Manual
from . import TRIALS


class Trials(Feature):
    """Stores a trial of both modes each time the user applies manual points."""

    def __init__(self, context: Context, faces: Faces, manual: Manual) -> None:
        super().__init__(context)
        self._faces, self._manual = faces, manual
        self._trial = ""
        self.document.opened.connect(self._begin)
        manual.applied.connect(self._keep_both)

    def _begin(self) -> None:
        self._trial = secrets.token_hex(8)

    def _keep_both(self) -> None:
        state, clock = self.document.state, self._manual.clock
        if not self._manual.fresh or not state.active or self.document.path is None:
            return
        first, *later = clock.applied_s
        corrections = tuple(b - a for a, b in zip(clock.applied_s, later, strict=False))
        by_hand, found = state.sheet("manual").active, state.sheet("automatic").active
        try:
            self._keep("manual", by_hand, False, clock.looking_s or 0.0, first, corrections)
            if found and self._faces.finding_s is not None:
                cold = self._faces.finding_was_cold
                self._keep("automatic", found, cold, 0.0, self._faces.finding_s, ())
        except OSError as problem:
            self.say(tr("The trial couldn't be saved ({why}).", why=system_reason(problem)))

    def _keep(
        self,
        mode: Mode,
        faces: Sequence[Face],
        cold: bool,
        looking_s: float,
        setting_s: float,
        corrections_s: tuple[float, ...],
    ) -> None:
        image, path = self.document.image, self.document.path
        assert path is not None
        trial = Trial(
            trial=self._trial,
            mode=mode,
            photo=path.name,
            width=image.width,
            height=image.height,
            cold=cold,
            looking_s=looking_s,
            setting_s=setting_s,
            corrections_s=corrections_s,
            faces=set_by_hand(faces, self.document.state.sheet(mode).recipe),
            at=trials.now(),
        )
        trials.append(self.storage.data / TRIALS, trial)
