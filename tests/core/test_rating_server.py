"""The page of a rating session, served: to its own address alone, and no answer is lost."""

import http.client
import json
import os
import subprocess
import sys
import threading
import urllib.error
import urllib.request
from concurrent.futures import ThreadPoolExecutor
from unittest.mock import Mock
from urllib.parse import urlsplit

import pytest
from ratings import answered, graded, taken_back
from timeouts import LONGEST_S

from kogao_core.lab.study import plan, results
from kogao_core.lab.study.plan import Study
from kogao_core.lab.study.results import Session
from kogao_core.lab.study.server import Server

NAMES = tuple(f"{number:016x}.jpg" for number in range(8))
STUDY = Study("a-study", NAMES[:6], NAMES[6:])


@pytest.fixture
def folder(tmp_path):
    """A study whose pictures are a few bytes, with its key and a stranger's file about it."""
    plan.save(STUDY, tmp_path / "study.json")
    for name in NAMES:
        (tmp_path / name).write_bytes(b"picture " + name.encode())
    (tmp_path / "notes.txt").write_text("not for raters")
    return tmp_path


class Page:
    """What the page does, without a browser."""

    def __init__(self, server, rater="r1"):
        self.server, self.rater, self.session = server, rater, None

    def ask(self, what, content=None, **headers):
        data = None if content is None else json.dumps(content).encode()
        request = urllib.request.Request(self.server.address + what, data, headers)
        with urllib.request.urlopen(request, timeout=LONGEST_S) as reply:
            return reply.read()

    def open(self):
        told = json.loads(self.ask(f"sessions/{self.rater}", {}))
        if "number" in told:
            told = self.begin(NAMES)
        self.session = Session(STUDY, self.rater, tuple(told["order"]))
        return told

    def begin(self, order):
        return json.loads(self.ask(f"sessions/{self.rater}", {"order": order, "keys": "fj"}))

    def send(self, record):
        self.ask(f"sessions/{self.rater}/lines", record.to_dict())
        self.session.take(record)

    def judge(self, count, answer="natural"):
        for _ in range(count):
            self.send(answered(self.session, answer))


@pytest.fixture
def serve(folder):
    servers = []

    def start(place=folder):
        servers.append(Server(place))
        servers[-1].start()
        return servers[-1]

    yield start
    for server in servers:
        server.stop()


def log(folder):
    return results.load(folder / plan.RATINGS_FOLDER / "r1.jsonl")


def refusal(act, *arguments, **headers):
    """The status and the sentence with which a request is refused."""
    with pytest.raises(urllib.error.HTTPError) as refused:
        act(*arguments, **headers)
    with refused.value as reply:
        return reply.code, json.loads(reply.read())


def test_a_session_from_its_page_to_the_log(folder, serve):
    page = Page(serve())
    assert b"Natural or unnatural?" in page.ask("")
    assert json.loads(page.ask("sessions/r1", {})) == {"number": 0}
    assert page.open()["records"] == []
    for number in range(6):
        assert page.ask(page.session.current).endswith(page.session.current.encode())
        page.judge(1, "unnatural" if number % 3 else "natural")
        assert len(log(folder).records) == number + 1, "it is on the disk when the page hears of it"
    page.send(taken_back(page.session))
    page.judge(1)
    page.send(graded(page.session, 70))
    page.send(graded(page.session, None))
    assert json.loads(page.ask("sessions/r2", {})) == {"number": 1}
    held = log(folder)
    assert held.records == tuple(page.session.records)
    assert held.session(STUDY).current is None


def test_answers_that_are_withdrawn_are_deleted_from_the_disk(folder, serve):
    page = Page(serve())
    page.open()
    page.judge(2)
    path = folder / plan.RATINGS_FOLDER / "r1.jsonl"
    assert path.exists()
    assert json.loads(page.ask("sessions/r1/withdraw", {})) == {}
    assert not path.exists()
    assert refusal(page.ask, "sessions/r1/withdraw", {})[0] == 400
    assert refusal(page.judge, 1)[0] == 400
    assert json.loads(page.ask("sessions/r1", {})) == {"number": 0}


def test_a_session_goes_on_in_its_own_order_after_the_program_was_killed(folder, serve):
    code = (
        "import sys; from pathlib import Path\n"
        "from kogao_core.lab.study.server import Server\n"
        "server = Server(Path(sys.argv[1]))\n"
        "print(server.address, flush=True)\n"
        "server.serve_forever()"
    )
    victim = subprocess.Popen(
        [sys.executable, "-c", code, folder], stdout=subprocess.PIPE, text=True
    )
    try:
        server = type("Killed", (), {"address": victim.stdout.readline().strip()})
        page = Page(server)
        order = page.open()["order"]
        page.judge(3)
        other = Page(serve())
        code, told = refusal(other.open)
        assert (code, "open in another program" in told["problem"]) == (400, True)
    finally:
        victim.kill()
        victim.communicate()
    path = folder / plan.RATINGS_FOLDER / "r1.jsonl"
    with path.open("ab") as file:
        file.write(b'{"n": 4, "picture": "00')  # as if it had died in the middle of a line
    told = other.open()
    assert told["order"] == order
    assert [line["n"] for line in told["records"]] == [1, 2, 3]
    for record in page.session.records:
        other.session.take(record)
    other.judge(3)
    held = log(folder)
    assert (len(held.records), held.torn) == (6, 1)


def test_many_windows_at_once_leave_one_answer(folder, serve):
    server = serve()
    pages = [Page(server) for _ in range(8)]
    for page in pages:
        page.open()
    together = threading.Barrier(len(pages))

    def judge(page):
        together.wait()
        try:
            page.judge(1)
        except urllib.error.HTTPError as refused:
            with refused:
                return refused.code, json.loads(refused.read())["records"]

    with ThreadPoolExecutor(len(pages)) as pool:
        refusals = [refused for refused in pool.map(judge, pages) if refused]
    (kept,) = log(folder).records
    assert refusals == [(409, [kept.to_dict()])] * 7


def test_what_doesnt_follow_is_refused_and_not_kept(folder, serve):
    page = Page(serve())
    page.open()
    before = (folder / plan.RATINGS_FOLDER / "r1.jsonl").read_bytes()
    line = {**answered(page.session, "natural").to_dict(), "name": "A. Person"}
    code, told = refusal(page.ask, "sessions/r1/lines", line)
    assert (code, "\n" in told["problem"]) == (400, False)
    assert (folder / plan.RATINGS_FOLDER / "r1.jsonl").read_bytes() == before


def test_a_full_disk_is_said_and_the_answer_can_be_given_again(folder, serve, monkeypatch):
    page = Page(serve())
    page.open()
    page.judge(1)

    full = Mock(side_effect=OSError(28, "No space left on device"))
    monkeypatch.setattr(results.os, "fsync", full)
    code, told = refusal(page.judge, 1)
    assert (code, "No space left" in told["problem"]) == (507, True)
    monkeypatch.undo()
    page.judge(1, "unnatural")
    assert [record.answer for record in log(folder).records] == ["natural", "unnatural"]


def test_a_code_that_could_be_a_path_begins_nothing(folder, serve):
    page = Page(serve())
    for code in ("A", "a+b", "-a", "..", "%2e%2e", "%C3%A4", "x" * 33, ""):
        assert refusal(page.ask, f"sessions/{code}", {})[0] in (400, 404), code
    assert not list(folder.rglob("*.jsonl"))


def raw(server, path, host=None, method="GET", body=None, headers=()):
    """One request, word for word; the answer's status, headers and body."""
    connection = http.client.HTTPConnection(
        *urlsplit(server.address).netloc.split(":"), timeout=LONGEST_S
    )
    try:
        connection.putrequest(method, path, skip_host=True)
        if host != "":
            connection.putheader("Host", host or server.host)
        for name, value in headers:
            connection.putheader(name, value)
        connection.endheaders(body)
        reply = connection.getresponse()
        return reply.status, dict(reply.getheaders()), reply.read()
    finally:
        connection.close()


def test_without_the_token_there_is_nothing(serve):
    server = serve()
    token = server.token
    wrong = ("A" if token[0] != "A" else "B") + token[1:]
    other = serve().token
    for path in ("/", "", f"/{wrong}/", f"/{token}", f"/{token[:-1]}/", f"/{other}/", "//"):
        status, _, body = raw(server, path)
        assert status == 403, path
        assert token.encode() not in body
    assert len(token) >= 20
    for method in ("POST", "PUT", "DELETE", "OPTIONS", "HEAD", "TRACE"):
        headers = [("Content-Length", "2")]
        assert raw(server, f"/{wrong}/sessions/r1", None, method, b"{}", headers)[0] in (403, 501)


def test_a_foreign_name_for_this_machine_reaches_nothing(serve):
    """DNS rebinding: a page of elsewhere whose name is pointed here sends that name as Host."""
    server = serve()
    path, port = f"/{server.token}/", server.server_port
    assert server.server_address[0] == "127.0.0.1"
    assert raw(server, path)[0] == 200
    for host in ("", f"evil.example:{port}", "127.0.0.1", f"localhost:{port}", f"127.0.0.2:{port}"):
        assert raw(server, path, host)[0] == 403, host
    assert raw(server, path, headers=[("Host", "evil.example")])[0] == 403, "two hosts"


def test_nothing_but_the_studys_pictures_is_given(folder, serve):
    (folder.parent / "secret.txt").write_text("a secret")
    server, name = serve(), NAMES[0]
    Page(server).open()
    for path in (
        *("notes.txt", "study.json", "ratings/r1.jsonl", "../secret.txt", "..%2fsecret.txt"),
        *("%2e%2e/secret.txt", "//etc/passwd", "/etc/passwd", "C:\\\\secret.txt"),
        *(f"./{name}", f"{name}/", f"{name}%00", name.replace("0", "f")),
    ):
        status, _, body = raw(server, f"/{server.token}/{path}")
        assert (status, b"secret" in body or b"raters" in body) == (404, False), path


def test_replies_are_kept_by_nobody_and_framed_by_nobody(serve):
    server = serve()
    for path, kind in (("", "text/html; charset=utf-8"), (NAMES[0], "image/jpeg")):
        status, headers, _ = raw(server, f"/{server.token}/{path}")
        assert (status, headers["Content-Type"]) == (200, kind)
        assert headers["Cache-Control"] == "no-store"
        assert headers["Referrer-Policy"] == "no-referrer"
        assert headers["X-Content-Type-Options"] == "nosniff"
        assert headers["Content-Security-Policy"] == "frame-ancestors 'none'"
        assert not any(name.startswith("Access-Control") for name in headers)


def test_a_session_that_isnt_the_studys_isnt_begun(serve):
    page = Page(serve())
    first, *others = NAMES
    for order in ([], others, [*others, first], [*NAMES[:-1], first], ["../x"], "x"):
        assert refusal(page.begin, order)[0] == 400, order
    assert json.loads(page.ask("sessions/r1", {})) == {"number": 0}
    assert page.open()["records"] == []


def test_a_body_that_is_no_answer_isnt_read(serve):
    server = serve()
    path = f"/{server.token}/sessions/r1"
    for length in ("5000000", "-1", "x", ""):
        assert raw(server, path, None, "POST", b"", [("Content-Length", length)])[0] == 413, length


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_cant_be_written_to_is_said(folder, serve):
    folder.chmod(0o500)
    try:
        code, told = refusal(Page(serve()).open)
    finally:
        folder.chmod(0o700)
    assert (code, "Permission denied" in told["problem"]) == (507, True)


def test_a_browser_that_goes_away_in_the_middle_is_passed_over(serve, capfd):
    server = serve()
    connection = http.client.HTTPConnection(server.host, timeout=LONGEST_S)
    connection.putrequest("POST", f"/{server.token}/sessions/r1")
    connection.putheader("Content-Length", "100")
    connection.endheaders(b"{")
    connection.close()
    assert raw(server, f"/{server.token}/")[0] == 200
    assert capfd.readouterr().err == ""
