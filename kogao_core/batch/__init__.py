"""Batch processing: render many photos in worker processes. A bad file never stops the rest.

Imports every package except `cli` and `lab`.
"""

from kogao_core.batch.planning import NothingToDo, check_free, outdated, partial, plan
from kogao_core.batch.tasks import Outcome, Task, measures_of, outputs_of, record, work
from kogao_core.batch.workers import Workers, run
from kogao_core.projects.results import REPORT
