"""Nobody speaks to the app but its own page on this machine: hostile requests over plain sockets, all refused."""

import contextlib
import re
import socket
from pathlib import Path

import pytest

from .conftest import Live

OWN = "127.0.0.1:{port}"
ORIGIN = "http://127.0.0.1:{port}"
TOKEN = "peristalsis.1, token.{token}"
CHAT = (
    "Upgrade: websocket",
    "Connection: Upgrade",
    "Sec-WebSocket-Version: 13",
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==",
)

HOSTS = {
    "another name": ["Host: evil.example"],
    "another name with the port": ["Host: evil.example:{port}"],
    "ours as a prefix": ["Host: 127.0.0.1.evil.example:{port}"],
    "ours as a suffix": ["Host: evil.example.127.0.0.1:{port}"],
    "localhost as a prefix": ["Host: localhost.evil.example:{port}"],
    "localhost as a suffix": ["Host: evil-localhost:{port}"],
    "another port": ["Host: 127.0.0.1:1"],
    "no port": ["Host: 127.0.0.1"],
    "localhost without a port": ["Host: localhost"],
    "port with a zero before it": ["Host: 127.0.0.1:0{port}"],
    "more digits in the port": ["Host: 127.0.0.1:{port}0"],
    "a name before an at sign": ["Host: 127.0.0.1:{port}@evil.example"],
    "ours after an at sign": ["Host: evil.example@127.0.0.1:{port}"],
    "null": ["Host: null"],
    "empty": ["Host: "],
    "missing": [],
    "twice": ["Host: 127.0.0.1:{port}", "Host: evil.example"],
    "twice ours": ["Host: 127.0.0.1:{port}", "Host: 127.0.0.1:{port}"],
    "IPv6 loopback": ["Host: [::1]:{port}"],
    "IPv4 in IPv6": ["Host: [::ffff:127.0.0.1]:{port}"],
    "capitals": ["Host: LOCALHOST:{port}"],
    "a dot at the end": ["Host: localhost.:{port}"],
    "a dot after the address": ["Host: 127.0.0.1.:{port}"],
    "another loopback address": ["Host: 127.0.0.2:{port}"],
    "all addresses": ["Host: 0.0.0.0:{port}"],
    "short form": ["Host: 127.1:{port}"],
    "as a number": ["Host: 2130706433:{port}"],
    "octal": ["Host: 0177.0.0.1:{port}"],
    "a whole address": ["Host: http://127.0.0.1:{port}"],
    "two in one line": ["Host: 127.0.0.1:{port}, evil.example"],
    "a name that points here": ["Host: 127.0.0.1.nip.io:{port}"],
    "forwarded for another host": ["Host: 127.0.0.1:{port}", "X-Forwarded-Host: evil.example"],
    "forwarded for our host": ["Host: evil.example", "X-Forwarded-Host: 127.0.0.1:{port}"],
    "Forwarded": ["Host: 127.0.0.1:{port}", "Forwarded: host=evil.example"],
    "forwarded for an address": ["Host: 127.0.0.1:{port}", "X-Forwarded-For: 10.0.0.1"],
}
ORIGINS = {
    "another page": ["Origin: http://evil.example"],
    "another page with the port": ["Origin: http://evil.example:{port}"],
    "null": ["Origin: null"],
    "empty": ["Origin: "],
    "encrypted": ["Origin: https://127.0.0.1:{port}"],
    "another port": ["Origin: http://127.0.0.1:1"],
    "no port": ["Origin: http://127.0.0.1"],
    "localhost beside the address": ["Origin: http://localhost:{port}"],
    "ours as a prefix": ["Origin: http://127.0.0.1:{port}.evil.example"],
    "ours before an at sign": ["Origin: http://127.0.0.1:{port}@evil.example"],
    "ours with a path": ["Origin: http://127.0.0.1:{port}/"],
    "capitals": ["Origin: HTTP://127.0.0.1:{port}"],
    "IPv6": ["Origin: http://[::1]:{port}"],
    "a file": ["Origin: file://"],
    "an extension": ["Origin: chrome-extension://abcdefghijklmnop"],
    "twice": ["Origin: http://127.0.0.1:{port}", "Origin: http://evil.example"],
    "two in one line": ["Origin: http://127.0.0.1:{port} http://evil.example"],
    "fetched by another site": ["Origin: http://127.0.0.1:{port}", "Sec-Fetch-Site: cross-site"],
    "fetched by a sibling": ["Origin: http://127.0.0.1:{port}", "Sec-Fetch-Site: same-site"],
}
VARIANTS = {
    **{f"host: {name}": lines for name, lines in HOSTS.items()},
    **{f"origin: {name}": [f"Host: {OWN}", *lines] for name, lines in ORIGINS.items()},
}


def answer(live: Live, lines: list[str], path: str = "/", method: str = "GET", body: bytes = b"") -> tuple[int, str]:
    """Status and head of the answer to a request of exactly these lines."""
    known = {"port": live.port, "token": live.token}
    text = "\r\n".join([f"{method} {path} HTTP/1.1", *(line.format(**known) for line in lines), "Connection: close"])
    with socket.create_connection(("127.0.0.1", live.port), timeout=30) as own:
        own.sendall(
            text.replace("\r\nConnection: close", "", "Upgrade: websocket" in lines).encode() + b"\r\n\r\n" + body
        )
        got = b""
        while b"\r\n\r\n" not in got:
            part = own.recv(4096)
            if not part:
                break
            got += part
    head = got.decode("latin-1")
    return int(head.split()[1]) if head else 0, head


def test_there_are_enough_variants() -> None:
    assert len(VARIANTS) >= 40


@pytest.mark.parametrize("name", VARIANTS)
def test_hostile_requests_are_refused(live: Live, name: str) -> None:
    """With the right cookie, which a browser that was led here might send; 400 is the server's for what is no HTTP."""
    status, head = answer(live, [*VARIANTS[name], f"Cookie: {live.cookie}"])
    assert status == 403 or (status == 400 and name in ("host: missing", "host: twice", "host: twice ours")), head


@pytest.mark.parametrize("name", VARIANTS)
def test_hostile_sockets_are_refused(live: Live, name: str) -> None:
    """With the right cookie and the right token; only the origin that the page brings is missing or wrong."""
    lines = list(VARIANTS[name])
    if not any(line.startswith("Origin") for line in lines):
        lines.append(f"Origin: {ORIGIN}")
    lines += [*CHAT, f"Cookie: {live.cookie}", f"Sec-WebSocket-Protocol: {TOKEN}"]
    status, head = answer(live, lines, "/talk?page=page-of-the-tests-1")
    assert status in (400, 403), head


def test_its_own_page_is_let_in(live: Live) -> None:
    """The same requests without what is wrong with them: the refusals above are for that alone."""
    lines = [f"Host: {OWN}", f"Cookie: {live.cookie}"]
    assert answer(live, lines)[0] == 200
    assert answer(live, [*lines, f"Origin: {ORIGIN}", "Sec-Fetch-Site: same-origin"])[0] == 200
    assert answer(live, ["Host: localhost:{port}", f"Cookie: {live.cookie}"])[0] == 200
    own = [*lines, f"Origin: {ORIGIN}", *CHAT, f"Sec-WebSocket-Protocol: {TOKEN}"]
    assert answer(live, own, "/talk?page=page-of-the-tests-1")[0] == 101


@pytest.mark.parametrize(
    "protocol",
    [
        None,
        "peristalsis.1",
        "peristalsis.1, token.",
        "peristalsis.1, token.x{token}",
        "token.{token}",
        "peristalsis.1, token.{token}, more",
        "peristalsis.2, token.{token}",
    ],
)
def test_a_socket_needs_the_token(live: Live, protocol: str | None) -> None:
    lines = [f"Host: {OWN}", f"Cookie: {live.cookie}", f"Origin: {ORIGIN}", *CHAT]
    if protocol is not None:
        lines.append(f"Sec-WebSocket-Protocol: {protocol}")
    assert answer(live, lines, "/talk?page=page-of-the-tests-1")[0] == 403


def test_a_socket_needs_an_origin(live: Live) -> None:
    lines = [f"Host: {OWN}", f"Cookie: {live.cookie}", *CHAT, f"Sec-WebSocket-Protocol: {TOKEN}"]
    assert answer(live, lines, "/talk?page=page-of-the-tests-1")[0] == 403


@pytest.mark.parametrize("path", ["/", "/catalogue", "/defaults", "/assets/main.js", "/files/x", "/talk", "/nothing"])
@pytest.mark.parametrize("cookie", [None, "peristalsis-{port}=", "peristalsis-{port}=wrong", "other={key}"])
def test_nothing_is_shown_without_the_key(live: Live, path: str, cookie: str | None) -> None:
    lines = [f"Host: {OWN}"]
    if cookie is not None:
        lines.append(f"Cookie: {cookie.replace('{key}', live.key)}")
    assert answer(live, lines, path)[0] == 403


@pytest.mark.parametrize("key", ["", "wrong", "{key}x", "{key}&key=x"])
def test_a_wrong_key_opens_nothing(live: Live, key: str) -> None:
    status, head = answer(live, [f"Host: {OWN}"], f"/?key={key.replace('{key}', live.key)}")
    assert status == 403
    assert "set-cookie" not in head.lower()


def test_the_key_becomes_a_cookie_that_scripts_and_other_sites_do_not_get(live: Live) -> None:
    status, head = answer(live, [f"Host: {OWN}"], f"/?key={live.key}")
    assert status == 303
    assert re.search(r"set-cookie: peristalsis-\d+=\S+; Path=/; HttpOnly; SameSite=Strict", head)
    assert re.search(r"location: /\r\n", head)


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "CONNECT"])
@pytest.mark.parametrize("path", ["/", "/talk", "/defaults", "/files/x"])
def test_nothing_is_changed_by_requests(live: Live, method: str, path: str) -> None:
    assert answer(live, [f"Host: {OWN}", f"Cookie: {live.cookie}"], path, method)[0] in (400, 403)


@pytest.mark.parametrize("line", ["Content-Length: 5", "Transfer-Encoding: chunked"])
def test_requests_have_no_body(live: Live, line: str) -> None:
    assert answer(live, [f"Host: {OWN}", f"Cookie: {live.cookie}", line], body=b"5\r\nhello\r\n0\r\n\r\n")[0] == 413


@pytest.mark.parametrize(
    "path",
    [
        "/assets/..%2fserver.py",
        "/assets/../server.py",
        "/assets/server.py",
        "/assets/%00",
        "/assets//etc/passwd",
        "/files/..%2f..%2fetc%2fpasswd",
        "/files/",
        "/__init__.py",
    ],
)
def test_no_path_leads_out_of_the_page(live: Live, path: str) -> None:
    assert answer(live, [f"Host: {OWN}", f"Cookie: {live.cookie}"], path)[0] in (404, 400)


@pytest.mark.parametrize("path", ["/", "/catalogue", "/assets/main.js", "/nothing", "/defaults?scenario=<script>"])
@pytest.mark.parametrize("known", [True, False])
def test_every_answer_has_the_policy(live: Live, path: str, known: bool) -> None:
    _, head = answer(live, [f"Host: {OWN}", *([f"Cookie: {live.cookie}"] if known else [])], path)
    policy = re.search(r"content-security-policy: (.*)\r\n", head)
    assert policy is not None
    assert "default-src 'none'" in policy[1]
    assert "unsafe" not in policy[1]
    assert "x-content-type-options: nosniff" in head
    assert "access-control-allow-origin" not in head


def test_only_loopback_listens(live: Live) -> None:
    """Of the server and the processes that it has started; read from the kernel's tables."""
    if not Path("/proc/net/tcp").is_file():
        pytest.skip("there is no /proc/net/tcp to read sockets from")
    listening = set()
    for table in ("tcp", "tcp6"):
        for line in Path(f"/proc/{live.process}/net/{table}").read_text(encoding="ascii").splitlines()[1:]:
            _, own, _, state, *rest = line.split()
            if state == "0A":
                listening.add((own.partition(":")[0], int(own.partition(":")[2], 16), rest[5]))
    inodes = {name for place in _family(live.process) for name in _open_in(place)}
    own_sockets = [(address, port) for address, port, inode in listening if f"socket:[{inode}]" in inodes]
    assert own_sockets == [("0100007F", live.port)]


def _family(process: int) -> list[Path]:
    """A process and what it started, as their places in /proc; one that ends meanwhile has no children."""
    try:
        children = Path(f"/proc/{process}/task/{process}/children").read_text(encoding="ascii").split()
    except (FileNotFoundError, ProcessLookupError):
        children = []
    return [Path(f"/proc/{process}"), *(place for child in children for place in _family(int(child)))]


def _open_in(place: Path) -> set[str]:
    """What the descriptors of a process stand for; they close, and processes end, while one looks."""
    found: set[str] = set()
    with contextlib.suppress(OSError):
        for link in place.joinpath("fd").iterdir():
            with contextlib.suppress(OSError):
                found.add(link.readlink().name)
    return found


def test_the_page_has_no_script_of_its_own_text(live: Live) -> None:
    """Scripts and styles are files; nothing in them makes markup or code out of text."""
    text = live.get("/")[2].decode()
    assert re.findall(r"<script(?![^>]*src=)", text) == []
    assert re.findall(r"\son\w+=|<style|style=", text) == []
    assert "http://" not in text
    assert "https://" not in text
    folder = Path(__file__).parents[2] / "src" / "peristalsis" / "app" / "page"
    for file in folder.glob("*.js"):
        code = file.read_text(encoding="utf-8")
        assert not re.search(
            r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|eval\(|new Function|https?://", code
        ), file
