"""Many photos through one recipe: in other processes, one bad file never stops the rest.

It may use all rooms but the command line and the laboratory.
"""

from kogao_core.batch.planning import NothingToDo, check_free, plan
from kogao_core.batch.tasks import Outcome, Task, measures_of, record, work
from kogao_core.batch.workers import NoWorkers, Workers, run
from kogao_core.projects.results import REPORT

__all__ = [
    "REPORT",
    "NoWorkers",
    "NothingToDo",
    "Outcome",
    "Task",
    "Workers",
    "check_free",
    "measures_of",
    "plan",
    "record",
    "run",
    "work",
]
