"""Many photos through one recipe: in other processes, one bad file never stops the rest."""

from kogao_core.batch.tasks import NothingToDo, Outcome, Task, plan, work
from kogao_core.batch.workers import Workers, run

__all__ = ["NothingToDo", "Outcome", "Task", "Workers", "plan", "run", "work"]
