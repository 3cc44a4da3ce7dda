"""Lets only the server's own pages talk to the server of `view`.

In: the host it serves. Out: within `own_pages_only`, a viser server that refuses WebSockets of other pages.

A browser lets any page open a WebSocket to this machine, and says in the header Origin which page it was. It must be
the one that the address in the header Host served. That alone is not enough: an attacker's name may point to this
machine (DNS rebinding), and then both agree. So the name must be an IP address, "localhost", the host that was asked
for or the machine's own name. Browsers request pages without Origin, but WebSockets always with it: a WebSocket without
Origin is refused. Programs other than browsers may send any Origin; this module does not concern them.
"""

from __future__ import annotations

import http
import ipaddress
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any
from urllib.parse import urlsplit

# `own_pages_only` puts a function of another library in place of its own for as long as a server starts.
_STARTING = threading.Lock()


def is_own_page(origin: str | None, host_header: str | None, served: str) -> bool:
    """Whether a WebSocket comes from a page of the server that it goes to.

    Args:
        origin: The header Origin, e.g. "http://localhost:8080"; None if there is none, as where a page is asked for.
        host_header: The header Host, e.g. "localhost:8080".
        served: The host that the server was asked to listen on.

    Returns:
        Whether it may be let in.
    """
    if origin is None:
        return True
    try:
        page, asked = urlsplit(origin), urlsplit(f"//{host_header or ''}")
        same = page.scheme in ("http", "https") and page.hostname is not None and page.netloc == asked.netloc
    except ValueError:  # brackets that are no address
        return False
    return same and _is_of_this_machine(str(page.hostname), served)


def _is_of_this_machine(name: str, served: str) -> bool:
    """Whether a name can't be another's that was made to point here."""
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return name in {"localhost", served.lower(), socket.gethostname().lower(), socket.getfqdn().lower()}
    return True


@contextmanager
def own_pages_only(served: str) -> Iterator[None]:
    """Within, viser's server is started so that it refuses other pages; viser itself has no setting for that.

    Args:
        served: The host that the server is asked to listen on.

    Raises:
        RuntimeError: If viser started without asking; the server must then not be used.
    """
    import websockets.asyncio.server as server

    with _STARTING:
        original, asked = server.serve, threading.Event()

        def serve(handler: Any, *arguments: Any, **options: Any) -> Any:
            if str(getattr(handler, "__module__", "")).partition(".")[0] == "viser":
                asked.set()
                options["process_request"] = _refusing(options.get("process_request"), served)
            return original(handler, *arguments, **options)

        server.serve = serve  # type: ignore[misc, assignment]
        try:
            yield
        finally:
            server.serve = original  # type: ignore[misc]
        if not asked.is_set():
            raise RuntimeError("this version of viser can't be told to refuse other pages: write a page by --html FILE")


def _refusing(then: Callable[[Any, Any], Any] | None, served: str) -> Callable[[Any, Any], Any]:
    """What is asked first of each request; `then` is what viser itself does with it."""

    def answered(connection: Any, request: Any) -> Any:
        origins, hosts = request.headers.get_all("Origin"), request.headers.get_all("Host")
        asks_for_page = not any("websocket" in each.lower() for each in request.headers.get_all("Upgrade"))
        alone = len(origins) <= 1 and len(hosts) <= 1 and (asks_for_page or len(origins) == 1)
        if not alone or not is_own_page(next(iter(origins), None), next(iter(hosts), None), served):
            return connection.respond(http.HTTPStatus.FORBIDDEN, "only this server's own page may connect\n")
        return None if then is None else then(connection, request)

    return answered
