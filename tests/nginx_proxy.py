"""Run nginx by the recipes as they are, on ports of loopback, with a certificate of a test."""

from __future__ import annotations

import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

DEPLOY = Path(__file__).parents[1] / "assets" / "deploy"
NAME = "lab.example.org"
NGINX = shutil.which("nginx") or "/usr/sbin/nginx"
TEMPORARY = "".join(f"{kind}_temp_path {{place}}/{kind}; " for kind in ("client_body", "proxy", "fastcgi", "uwsgi", "scgi"))
PATIENCE = 60.0  # s


def listens(port: int) -> bool:
    """Whether somebody listens on a port of loopback."""
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


def free_ports(count: int) -> list[int]:
    """Ports of loopback that nobody has now."""
    probes = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    ports = [probe.getsockname()[1] for probe in probes]
    for probe in probes:
        probe.close()
    return ports


def changed(recipe: str, *changes: tuple[str, str]) -> str:
    """A recipe with a machine's own places; each must be there."""
    words = (DEPLOY / recipe).read_text(encoding="utf-8")
    for ours, here in changes:
        assert ours in words, ours
        words = words.replace(ours, here)
    return words


@contextmanager
def nginx(place: Path, lab: int, plain: int, tls: int, name: str = NAME) -> Iterator[None]:
    """nginx by our two recipes; only ports, the name, folders, the user and the certificate are others."""
    subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", f"/CN={name}",
                    "-keyout", place / "privkey.pem", "-out", place / "fullchain.pem"], check=True, capture_output=True)
    (place / "lab.conf").write_text(changed(
        "nginx.conf", ("listen 80;", f"listen 127.0.0.1:{plain};"), ("listen 443 ssl;", f"listen 127.0.0.1:{tls} ssl;"),
        ("127.0.0.1:8080", f"127.0.0.1:{lab}"), (f"/etc/letsencrypt/live/{NAME}", str(place)), ("https://$host$", f"https://$host:{tls}$"),
        ("/var/log/nginx", str(place)), (f"server_name {NAME}", f"server_name {name}")), encoding="utf-8")
    (place / "nginx.conf").write_text(changed(
        "nginx.main.conf", ("user www-data;", "daemon off;"), ("/run/nginx.pid", f"{place}/pid"), ("/var/log/nginx", str(place)),
        ("worker_processes auto", "worker_processes 1"),
        ("/etc/nginx/conf.d/*.conf;", f"{place}/lab.conf; {TEMPORARY.format(place=place)}")), encoding="utf-8")
    process = subprocess.Popen([NGINX, "-e", place / "errors", "-p", place, "-c", place / "nginx.conf"])
    try:
        end = time.monotonic() + PATIENCE
        while not listens(tls):
            assert process.poll() is None and time.monotonic() < end, (place / "errors").read_text()[-2000:]
            time.sleep(0.05)
        yield
    finally:
        process.terminate()
        process.wait(30)
