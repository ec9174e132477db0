"""Who may speak to the server: this machine's browser on the server's own page, and nobody else.

Every request must name the server by its own address, exactly (`Host`), so a name that is made to point here is
refused. What comes from a page must come from this one (`Origin`, `Sec-Fetch-Site`). The page is shown to who holds
the key that the terminal printed, and what changes anything goes through one WebSocket that asks for a token besides.
"""

from __future__ import annotations

import hmac
import secrets
from collections.abc import Awaitable, Callable, MutableMapping
from dataclasses import dataclass, field
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
Application = Callable[[Scope, Receive, Send], Awaitable[None]]

PROTOCOL = "peristalsis.1"
"""Subprotocol of the WebSocket; the token follows it as a second one."""
FORWARDED = (b"forwarded", b"x-forwarded-host", b"x-forwarded-for", b"x-forwarded-proto", b"x-original-host")
"""Headers of proxies: none stands before this server, so who sends one means to be taken for another."""


@dataclass(frozen=True)
class Secrets:
    """What the terminal prints (`key`) and what the page is given (`token`)."""

    key: str = field(default_factory=lambda: secrets.token_urlsafe(24))
    token: str = field(default_factory=lambda: secrets.token_urlsafe(24))


class Guard:
    """Lets through to an application what `hosts` and the secrets allow, and adds headers to every answer.

    hosts: the exact values of `Host` that are taken, with their port.
    """

    def __init__(self, application: Application, hosts: tuple[str, ...], known: Secrets) -> None:
        self.application = application
        self.hosts = hosts
        self.known = known
        self.cookie = f"peristalsis-{hosts[0].rpartition(':')[2]}"  # cookies do not tell ports apart
        sockets = " ".join(f"ws://{host}" for host in hosts)
        policy = (
            "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
            f"connect-src 'self' {sockets}; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
        )
        self.headers = [
            (b"content-security-policy", policy.encode("ascii")),
            (b"x-content-type-options", b"nosniff"),
            (b"x-frame-options", b"DENY"),
            (b"referrer-policy", b"no-referrer"),
            (b"cross-origin-resource-policy", b"same-origin"),
            (b"cross-origin-opener-policy", b"same-origin"),
            (b"cache-control", b"no-store"),
        ]

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, or hand on."""
        if scope["type"] == "lifespan":
            await self.application(scope, receive, send)
            return
        if scope["type"] == "websocket":
            if self.refusal(scope) or self._refused_socket(scope):
                await receive()
                await send({"type": "websocket.close", "code": 4403})
                return
            await self.application(scope, receive, send)
            return
        safe = self._with_headers(send)
        refused = self.refusal(scope)
        if refused is None and self._asks_with_key(scope):
            path = scope["path"].encode("ascii", "ignore")
            cookie = f"{self.cookie}={self.known.key}; Path=/; HttpOnly; SameSite=Strict"
            await _answer(safe, 303, b"", [(b"location", path), (b"set-cookie", cookie.encode("ascii"))])
        elif refused is None and not self._holds_key(scope):
            await _answer(safe, 403, b"This page opens with the whole address that `peristalsis app` printed.\n")
        elif refused is not None:
            await _answer(safe, *refused)
        else:
            await self.application(scope, receive, safe)

    def refusal(self, scope: Scope) -> tuple[int, bytes] | None:
        """Status and words with which a request is refused for what it says of itself, or None."""
        names = [name for name, _ in scope["headers"]]
        hosts = _all(scope, b"host")
        if len(hosts) != 1 or hosts[0] not in self.hosts or any(name in FORWARDED for name in names):
            return 403, b"This server answers to its own address alone.\n"
        origins = _all(scope, b"origin")
        if len(origins) > 1 or any(origin != f"http://{hosts[0]}" for origin in origins):
            return 403, b"Requests of other pages are refused.\n"
        if any(site not in ("same-origin", "none") for site in _all(scope, b"sec-fetch-site")):
            return 403, b"Requests of other pages are refused.\n"
        if scope["type"] == "http":
            if scope["method"] not in ("GET", "HEAD"):
                return 403, b"What changes anything goes through the page.\n"
            if b"transfer-encoding" in names or any(text != "0" for text in _all(scope, b"content-length")):
                return 413, b"Requests have no body here.\n"
        return None

    def _refused_socket(self, scope: Scope) -> bool:
        """Whether a WebSocket lacks what it must bring: its origin, the key, the token."""
        offered = [one.strip() for text in _all(scope, b"sec-websocket-protocol") for one in text.split(",")]
        right = len(offered) == 2 and offered[0] == PROTOCOL and _same(offered[1], f"token.{self.known.token}")
        return not (_all(scope, b"origin") and right and self._holds_key(scope))

    def _asks_with_key(self, scope: Scope) -> bool:
        asked = parse_qs(scope.get("query_string", b"").decode("ascii", "ignore")).get("key", [])
        return scope["path"] == "/" and len(asked) == 1 and _same(asked[0], self.known.key)

    def _holds_key(self, scope: Scope) -> bool:
        jar = SimpleCookie()
        for text in _all(scope, b"cookie"):
            try:
                jar.load(text)
            except CookieError:
                return False
        return self.cookie in jar and _same(jar[self.cookie].value, self.known.key)

    def _with_headers(self, send: Send) -> Send:
        async def wrapped(message: MutableMapping[str, Any]) -> None:
            if message["type"] == "http.response.start":
                message = {**message, "headers": [*message.get("headers", []), *self.headers]}
            await send(message)

        return wrapped


def _all(scope: Scope, name: bytes) -> list[str]:
    return [value.decode("latin-1") for key, value in scope["headers"] if key == name]


def _same(one: str, other: str) -> bool:
    """Whether two texts are equal, in a time that does not tell where they differ."""
    return hmac.compare_digest(one.encode("utf-8"), other.encode("utf-8"))


async def _answer(send: Send, status: int, body: bytes, headers: list[tuple[bytes, bytes]] | None = None) -> None:
    kind = (b"content-type", b"text/plain; charset=utf-8")
    length = (b"content-length", str(len(body)).encode("ascii"))
    await send({"type": "http.response.start", "status": status, "headers": [kind, length, *(headers or [])]})
    await send({"type": "http.response.body", "body": body})
