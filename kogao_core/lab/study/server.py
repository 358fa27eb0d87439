"""Local web server for the rating page of a study.

Each answer is on the disk before the next picture is shown. The address contains a random token.
Requests without the token, or with another host name (DNS rebinding), are refused.
"""

from __future__ import annotations

import hmac
import json
import os
import secrets
import socketserver
import sys
import threading
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any, BinaryIO, Final

from kogao_core.base.json_reader import BadFile, Node, parse
from kogao_core.base.language import Text
from kogao_core.base.wording import system_reason
from kogao_core.lab.study import page, plan, results
from kogao_core.lab.study.design import one_of
from kogao_core.lab.study.results import Log, Record, Session

if sys.platform == "win32":
    import msvcrt

    # Windows also blocks writes to locked bytes: lock a byte past the end of any log.
    _LOCKED_BYTE: Final = 2**31 - 2

    def _lock(file: int) -> None:
        os.lseek(file, _LOCKED_BYTE, os.SEEK_SET)
        msvcrt.locking(file, msvcrt.LK_NBLCK, 1)

else:
    import fcntl

    def _lock(file: int) -> None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


_HERE: Final = "127.0.0.1"
_TOKEN_BYTES: Final = 16
_MOST_BODY_BYTES: Final = 4 * 2**20  # the first request contains all picture names
_POLL_S: Final = 0.1
_HEADERS: Final = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": "frame-ancestors 'none'",  # the page contains the other directives
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}


class Behind(Exception):
    """Another window continued the session; the argument is the newer state."""


class Sessions:
    """A study and the open sessions; thread-safe."""

    def __init__(self, folder: Path) -> None:
        self.study = plan.load_study(folder)
        self.folder = folder
        self._names = {*self.study.ratings, *self.study.satisfaction, *self.study.practice}
        self._lock = threading.Lock()
        self._open: dict[str, tuple[Log, BinaryIO]] = {}

    def picture(self, name: str) -> bytes | None:
        """Return a picture of the study; None for other names and missing files."""
        if name not in self._names:
            return None
        try:
            return (self.folder / name).read_bytes()
        except OSError:
            return None

    def open(self, rater: str, beginning: Node) -> dict[str, Any]:
        """Continue the session of a rater, or begin one in the order of the page; return the state.

        For a new rater without an order, return the number of sessions: the page draws the order
        from this number. Raises BadFile.
        """
        if not plan.is_rater(rater):
            raise BadFile(Text("A code has at most 32 characters: a to z, 0 to 9 and dashes."))
        with self._lock:
            if rater not in self._open:
                path = self.folder / plan.RATINGS_FOLDER / f"{rater}{results.SUFFIX}"
                begins = beginning.field("order").value is not None
                if not begins and not (path.exists() and b"\n" in path.read_bytes()):
                    return {"number": len(list(path.parent.glob(f"*{results.SUFFIX}")))}
                order = plan.names(beginning.field("order")) if begins else ()
                keys: results.Keys = (
                    one_of(beginning.field("keys"), results.Keys, 2) if begins else "fj"
                )
                path.parent.mkdir(exist_ok=True)
                file = _locked(path, rater)
                try:
                    self._open[rater] = Log(path, self.study, rater, order, keys), file
                except (BadFile, OSError):
                    file.close()
                    if not path.stat().st_size:
                        path.unlink()
                    raise
            return _state_of(self._open[rater][0].session)

    def add(self, rater: str, record: Record) -> dict[str, Any]:
        """Write a record to the disk and add the record to the session. Raises Behind, BadFile."""
        with self._lock:
            log, _ = self._opened(rater)
            if record.number <= len(log.session.records):
                raise Behind(_state_of(log.session))
            log.add(record)
            return {}

    def withdraw(self, rater: str) -> dict[str, Any]:
        """Delete the answers of an open session from the disk. Raises BadFile."""
        with self._lock:
            log, file = self._opened(rater)
            del self._open[rater]
            file.close()
            log.path.unlink()
            return {}

    def _opened(self, rater: str) -> tuple[Log, BinaryIO]:
        if rater not in self._open:
            raise BadFile(Text("this session isn't open; load the page again"))
        return self._open[rater]

    def close(self) -> None:
        """Close all sessions."""
        with self._lock:
            for _, file in self._open.values():
                file.close()
            self._open.clear()


def _locked(path: Path, rater: str) -> BinaryIO:
    """Open the file of a session with a lock, released on close or at the end of the program."""
    file = path.open("ab")
    try:
        _lock(file.fileno())
    except (BlockingIOError, PermissionError):
        file.close()
        raise BadFile(
            Text(
                "The session {rater} is open in another program. Continue there, or close the "
                "other program.",
                rater=rater,
            )
        ) from None
    except OSError:
        file.close()
        raise
    return file


def _state_of(session: Session) -> dict[str, Any]:
    records = [record.to_dict() for record in session.records]
    state = {"rater": session.rater, "order": session.order, "keys": session.keys}
    return {**state, "records": records}


class Server(ThreadingHTTPServer):
    """Web server for the study of one folder."""

    daemon_threads = True

    def __init__(self, folder: Path) -> None:
        self.sessions = Sessions(folder)
        self.token = secrets.token_urlsafe(_TOKEN_BYTES)
        super().__init__((_HERE, 0), _Handler)

    @property
    def host(self) -> str:
        """The only accepted host name."""
        return f"{_HERE}:{self.server_port}"

    @property
    def address(self) -> str:
        """Address to open in a browser."""
        return f"http://{self.host}/{self.token}/"

    def start(self) -> None:
        """Serve in a separate thread."""
        threading.Thread(target=self.serve_forever, args=(_POLL_S,), daemon=True).start()

    def stop(self) -> None:
        """Stop the server; all answers are on the disk already."""
        self.shutdown()
        self.server_close()

    def server_bind(self) -> None:
        """Bind without a name lookup, which can take seconds."""
        socketserver.TCPServer.server_bind(self)
        self.server_name, self.server_port = _HERE, self.server_address[1]

    def server_close(self) -> None:
        """Close the sessions."""
        super().server_close()
        self.sessions.close()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Ignore a browser that closes the connection."""
        if not isinstance(sys.exception(), ConnectionError | TimeoutError):
            super().handle_error(request, client_address)


def _parsed(body: bytes) -> Node:
    return parse(body, _MOST_BODY_BYTES)


class _Handler(BaseHTTPRequestHandler):
    server: Server
    protocol_version = "HTTP/1.1"
    server_version, sys_version = "Kogao", ""
    timeout = 60

    def do_GET(self) -> None:
        sessions, wanted = self.server.sessions, self._wanted()
        if wanted == "":
            text = page.page(sessions.study, sessions.folder, served=True)
            self._reply(HTTPStatus.OK, text.encode(), "text/html; charset=utf-8")
        elif wanted is not None:
            self._picture(wanted)

    def do_POST(self) -> None:
        wanted, body = self._wanted(), self._body()
        if wanted is None or body is None:
            return
        match wanted.split("/"):
            case ["sessions", rater]:
                self._attempt(lambda: self.server.sessions.open(rater, _parsed(body)))
            case ["sessions", rater, "lines"]:
                self._attempt(lambda: self._add(rater, body))
            case ["sessions", rater, "withdraw"]:
                self._attempt(lambda: self.server.sessions.withdraw(rater))
            case _:
                self._refuse(HTTPStatus.NOT_FOUND, "not found")

    def _add(self, rater: str, body: bytes) -> dict[str, Any]:
        record = results.record(_parsed(body))
        return self.server.sessions.add(rater, record)

    def _attempt(self, act: Any) -> None:
        try:
            self._reply_json(HTTPStatus.OK, act())
        except Behind as behind:
            self._reply_json(HTTPStatus.CONFLICT, behind.args[0])
        except BadFile as problem:
            self._refuse(HTTPStatus.BAD_REQUEST, str(problem))
        except OSError as problem:
            reason = system_reason(problem)
            self._refuse(
                HTTPStatus.INSUFFICIENT_STORAGE,
                f"That wasn't kept ({reason}). Make room, or the folder writable, and try again.",
            )

    def _picture(self, name: str) -> None:
        # Only names listed in the study are looked up: no path traversal.
        data = self.server.sessions.picture(name)
        if data is None:
            self._refuse(HTTPStatus.NOT_FOUND, "there is no such picture")
        else:
            self._reply(HTTPStatus.OK, data, "image/jpeg")

    def _wanted(self) -> str | None:
        """Return the path after the token; None after a refusal."""
        start = f"/{self.server.token}/"
        given = self.path[: len(start)].encode()
        named = self.headers.get_all("Host", [])
        if named != [self.server.host] or not hmac.compare_digest(given, start.encode()):
            self._refuse(HTTPStatus.FORBIDDEN, "open the address that Kogao has shown")
            return None
        return self.path[len(start) :].split("?")[0]

    def _body(self) -> bytes | None:
        length = self.headers.get("Content-Length", "")
        if not (length.isdecimal() and int(length) <= _MOST_BODY_BYTES):
            self._refuse(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, "that is no answer")
            return None
        return self.rfile.read(int(length))

    def _refuse(self, status: HTTPStatus, problem: str) -> None:
        self.close_connection = True  # the rest of the request isn't read
        self._reply_json(status, {"problem": problem})

    def _reply_json(self, status: HTTPStatus, content: object) -> None:
        self._reply(status, json.dumps(content).encode(), "application/json")

    def _reply(self, status: HTTPStatus, data: bytes, kind: str) -> None:
        self.send_response(status)
        for name, value in {**_HEADERS, "Content-Type": kind}.items():
            self.send_header(name, value)
        self.send_header("Content-Length", str(len(data)))
        if self.close_connection:
            self.send_header("Connection", "close")
        self.end_headers()
        self.wfile.write(data)

    def log_message(self, format: str, *args: Any) -> None:  # noqa: A002
        """Don't log: addresses contain the token."""
