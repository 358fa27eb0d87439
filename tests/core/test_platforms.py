"""Modules that use what only POSIX or Linux has are on a list, and say how they do without.

`.ci/run` also checks the types as on Windows and macOS, where a use without a guard is an error.
"""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
# Modules and attributes that Windows lacks, and paths that only Linux has.
LACKING = re.compile(
    r"\b(?:import|from) (?:fcntl|grp|posix|pty|pwd|resource|termios|tty)\b"
    r"|\bos\.(?:fork|forkpty|getuid|geteuid|getgid|killpg|getpgid|setsid|mkfifo|chown|fchmod"
    r"|sched_getaffinity|O_DIRECTORY|O_NOFOLLOW)\b"
    r"|\bsignal\.(?:pthread_sigmask|SIGKILL|SIGHUP|setitimer)\b"
    r"""|["'](?:/proc/|/sys/|/dev/shm|/tmp)"""
)
# How each module does without on other systems.
ALLOWED = {
    "kogao_core/base/atomic.py": "imports fcntl in a try; locks by msvcrt; keeps owners on POSIX",
    "kogao_core/batch/workers.py": "starts workers by spawn elsewhere; masks signals on POSIX",
    "kogao_core/cli/doctor.py": "speaks of apt-get on Linux only",
    "kogao_core/lab/reports/report.py": "names the processor by `platform` elsewhere",
    "kogao_core/photo/jpeg/coefficients.py": "reads nothing ahead elsewhere",
    "kogao_core/photo/reading.py": "assumes enough memory where there is no /proc/meminfo",
    "kogao_core/lab/study/server.py": "imports fcntl in a try",
}


def test_only_listed_modules_use_what_some_systems_lack():
    found = {
        path.relative_to(ROOT).as_posix()
        for folder in ("app", "kogao_core")
        for path in (ROOT / folder).rglob("*.py")
        if LACKING.search(path.read_text(encoding="utf-8"))
    }
    assert found == set(ALLOWED)
