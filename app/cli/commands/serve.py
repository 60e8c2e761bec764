"""Serve the lessons to browsers until interrupted: `serve`."""

from __future__ import annotations

import argparse
import logging
import os
import signal
import socket
import sys
from collections.abc import Callable
from dataclasses import replace
from importlib.util import find_spec
from typing import TYPE_CHECKING

from ...course.scenes import MODES
from ...text.languages import languages
from ..ending import ENDINGS, Ending
from ..file_limit import allow_many_files, bound_memory, held_folder
from ..lecture_room import LecturePlace, audience_address, names_of, open_room_place, room_told
from ..lesson_folder import follow_folder
from ..lti import open_platforms, token_for_launches
from ..opening import ServeRequest, opening_of
from ..options import (
    COURSE_STORE,
    PLANT_HELP,
    ROOM_STORE,
    STATE_HELP,
    CommandError,
    add_own_lessons,
    allowed_host,
    error_cause,
    host_name,
    network,
    redis_address,
    stated_redis,
    web_address,
    whole_number,
)
from ..records import add_record_options, reading_options

if TYPE_CHECKING:
    from ...page.access.shared_counters import WorkerSlot
    from ...page.access.tokens import AccessToken
    from ...page.screen.server import LabServer

log = logging.getLogger(__name__)

HELP = "serve the lessons to browsers (default)"

USUAL_TABS, ROOM_TABS = 200, 600  # followers cost little
HEARTBEATS_PER_TIMEOUT = 10  # signs of life within the time after which a silent worker is replaced
OPEN_TO_ALL = """\
observer-lab: {host} can be reached by other machines. Whoever reaches it {may}, and what
observer-lab: they send and see is not encrypted. For a course put a proxy with TLS in front, listen on 127.0.0.1 and
observer-lab: name the proxy with --allow-host NAME."""


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `serve`."""
    port = whole_number(0, 65535, "is not a port; give a number from 1 to 65535, or 0 for a free one")
    count = whole_number(1, 100_000, "is not a number of tabs; give one from 1 to 100000")
    seconds = whole_number(2, 3600, "is not a time limit for a worker; give 2 to 3600 seconds")
    minutes = whole_number(0, 100_000, "is not a time in minutes; give a whole number, or 0 for never")
    several = whole_number(1, 64, "is not a number of workers; give one from 1 to 64")
    parser.add_argument("--host", default="127.0.0.1", help="address to listen on (default %(default)s)")
    parser.add_argument("--port", type=port, default=8080,
                        help="port, or the next free one; 0 for any (default %(default)s)")
    parser.add_argument("--exact-port", action="store_true", help="that port or none, as a proxy in front needs it")
    parser.add_argument("--workers", type=several, default=1, metavar="N",
                        help="processes behind the address, as many as there are cores to give (default %(default)s; Linux)")
    parser.add_argument("--worker-timeout", type=seconds, default=90.0, metavar="SECONDS",
                        help="replace a worker that gives no sign of life for so long (default %(default)s)")
    parser.add_argument("--token", metavar="WORD|auto", help="let nobody in who does not know this word; auto draws one (or in the "
                                                             "environment, OBSERVER_LAB_TOKEN, where it is not printed)")
    parser.add_argument("--lesson", metavar="ID", help="lesson that a page opens on")
    add_own_lessons(parser)
    parser.add_argument("--allow-lessons", action="store_true",
                        help="let a page open a .zip of lessons, for its own tab alone; none of its code runs")
    parser.add_argument("--view", choices=MODES, default="guide", help="how a page shows its lesson (default %(default)s)")
    parser.add_argument("--lang", choices=languages(), default="en", help="language that a page opens in")
    parser.add_argument("--plant", metavar="FILE", help=PLANT_HELP)
    add_record_options(parser)
    parser.add_argument("--state", metavar="TOKEN|FILE", help=STATE_HELP)
    parser.add_argument("--lecture", metavar="FILE", help="give this lecture: a TOML file of scenes with minutes and notes")
    parser.add_argument("--exam", action="store_true", help="note answers to exams and tell nothing of them; no tab can practise")
    parser.add_argument("--course", metavar="FILE", help="a course file: what is handed in, what is for practice; see README.md")
    parser.add_argument("--public", action="store_true", help="yes, listen on an address that other machines can reach")
    parser.add_argument("--allow-host", action="append", default=[], type=allowed_host, metavar="NAME[:PORT]", dest="names",
                        help="a name that people reach this server by, as that of a proxy; may be repeated")
    parser.add_argument("--embed-in", action="append", default=[], type=host_name, metavar="NAME", dest="frames",
                        help="a site that may show the page inside its own, over TLS; may be repeated (default: none may)")
    parser.add_argument("--room", action="store_true",
                        help="hold a lecture: one tab presents, all others follow; prints the links of both")
    parser.add_argument("--room-store", type=redis_address, metavar="redis://…", dest="store",
                        help=f"keep the room in a Redis server, where other machines find it (or in the environment, {ROOM_STORE})")
    parser.add_argument("--at", type=web_address, metavar="URL", help="the address of the audience's link, as that of a proxy")
    parser.add_argument("--lti", metavar="FILE",
                        help="the learning platforms that may open lessons by LTI 1.3: a TOML file; see README.md")
    parser.add_argument("--course-store", type=redis_address, metavar="redis://…",
                        help=f"keep logins and hand-ins in a Redis server, for several machines (or in the environment, {COURSE_STORE})")
    parser.add_argument("--log-json", action="store_true", help="write the log as lines of JSON")
    parser.add_argument("--data-dir", metavar="FOLDER", help="folder for what is kept: the log, in files that rotate")
    parser.add_argument("--trust-proxy", action="append", default=[], type=network, metavar="NETWORK", dest="proxies",
                        help="proxies that may say for whom they ask, as 10.0.0.0/8; may be repeated (default: this machine)")
    parser.add_argument("--idle", type=minutes, default=60.0, metavar="MINUTES",
                        help="a tab that nobody touches for so long gives its place back until it is touched; 0 for never "
                             "(default %(default)g)")
    parser.add_argument("--max-sessions", type=count, metavar="N",
                        help=f"most tabs, of all workers together (default {USUAL_TABS}, in a room {ROOM_TABS})")


def execute(options: argparse.Namespace) -> int:
    """Serve until interrupted."""
    return serve(ServeRequest(options.host, options.port, options.lesson, options.lang, options.max_sessions,
                              options.plant, tuple(options.names), options.public, options.log_json, options.data_dir,
                              tuple(options.frames), options.state, options.exam, options.workers, options.exact_port,
                              options.view, options.worker_timeout,
                              options.token, options.data, options.columns, options.lecture, options.course, options.lessons,
                              options.trust_code, options.room, options.at, options.lti, options.store, tuple(options.proxies),
                              60.0 * options.idle or float("inf"), reading_options(options), options.course_store,
                              options.allow_lessons))


def serve(request: ServeRequest) -> int:
    """Serve until interrupted (Ctrl-C or SIGTERM); prints the address that was really taken."""
    end = Ending()
    before = [signal.signal(ending, end.handle_signals) for ending in ENDINGS]  # a shell may have them ignored
    hang_up = signal.signal(signal.SIGHUP, end.handle_hang_up) if hasattr(signal, "SIGHUP") else None
    try:
        with held_folder(request.data_dir):
            _serve(request, end)
    except KeyboardInterrupt:
        pass
    finally:
        for ending, handler in zip(ENDINGS, before, strict=True):
            signal.signal(ending, handler)
        if hang_up is not None:
            signal.signal(signal.SIGHUP, hang_up)
    return 0


def _serve(request: ServeRequest, end: Ending) -> None:
    from ...engine.kernels import prepare_kernels

    _keep_log(request)
    allow_many_files()
    bound_memory()
    first = opening_of(request)
    if request.at is not None and not request.room:
        raise CommandError("--at names the address of a room's audience; give it with --room.")
    if request.store is not None and not request.room:
        raise CommandError("--room-store says where a room is kept; give it with --room.")
    room_place = open_room_place(request.data_dir, stated_redis(request.store, ROOM_STORE)) if request.room else None
    platforms = open_platforms(request)
    if platforms is not None:
        request = replace(request, names=(*request.names, *names_of(platforms.address)), token=token_for_launches(request))
    listener, access, url, printed = _door(request)
    presenter, audience, links = None, "", ""
    if room_place is not None:
        presenter, audience, links = _links(request, room_place, listener.getsockname()[1], access)
        request = replace(request, names=(*request.names, *names_of(request.at)))
    doors = None if platforms is None else platforms.doors(first, request, listener.getsockname()[1])
    from observer_lab.lessons.from_files.packed import uploaded_lessons

    from ...page.access.proxies import TrustedProxies
    from ...page.access.shared_counters import SharedCounters, WorkerSlot
    from ...page.screen.server import LabServer  # viser is loaded only here

    def server(listener: socket.socket, slot: WorkerSlot, worker: int = 0) -> LabServer:
        from ...page.room.lecture_room import LectureRoom

        room = None if room_place is None else LectureRoom(room_place.place, worker, request.language, audience)
        return LabServer(first.lessons, request.host, 0, first.lesson, request.language, plant=first.plant, names=request.names,
                         state=first.state, insists=first.insists, sealed=request.exam or first.course is not None, access=access,
                         frames=request.frames, listener=listener, slot=slot, mode="present" if first.talk else request.mode,
                         talk=first.talk, course=first.course, room=room, presenter=presenter, doors=doors,
                         proxies=TrustedProxies.of(request.proxies), idle=request.idle,
                         read_lessons=uploaded_lessons if request.uploads else None)

    def tell() -> None:
        log.info("serving %s", url)
        print(printed, *([links] if links else []), sep="\n", flush=True)
        if sys.stderr.isatty():
            print(f"To show it without a server: observer-lab publish {first.lesson} -o site", file=sys.stderr, flush=True)
            if find_spec("numba") is None:
                print('For faster maps and long runs: pip install "observer-lab[fast]"', file=sys.stderr, flush=True)

    def prepare(made: LabServer) -> None:
        if first.folder is not None:
            follow_folder(first.folder, made.replace_lessons, end.come)
        prepare_kernels()

    most = request.max_sessions or (ROOM_TABS if request.room else USUAL_TABS)
    tally = SharedCounters(request.workers, most)
    if request.workers == 1:
        _run(server(listener, WorkerSlot(tally, 0)), tell, prepare, end)
        return
    from ...page.access.socket_handoff import READY, HandedListener
    from ..workers import CHECK_INTERVAL_S, WorkerPool

    address = listener.getsockname()

    def work(number: int, channel: socket.socket) -> None:
        _keep_log(request, number + 1)
        handed = HandedListener(
            channel, address, lambda: tally.count_ended_connection(number), lambda: os.kill(os.getpid(), signal.SIGTERM)
        )
        _run(server(handed, WorkerSlot(tally, number), number), lambda: handed.send(READY), prepare, end,
             request.timeout / HEARTBEATS_PER_TIMEOUT)

    def stand() -> None:
        tell()
        end.stands = True

    WorkerPool(listener, tally, work, silent=request.timeout, check=min(CHECK_INTERVAL_S, request.timeout / HEARTBEATS_PER_TIMEOUT)).run(
        stand, end.come
    )


def _links(request: ServeRequest, place: LecturePlace, port: int, access: AccessToken | None) -> tuple[AccessToken, str, str]:
    """The presenter's word, the audience's address, and what is printed of a room."""
    from ...page.access.addresses import url
    from ...page.access.tokens import PRESENTER_FIELD, AccessToken

    presenter = AccessToken(place.secret, port, PRESENTER_FIELD)
    audience, own = audience_address(request.host, port, request.at), url(request.host, port)
    mine = presenter.at(own) if access is None else f"{access.at(own)}&{PRESENTER_FIELD}={place.secret}"
    theirs = audience if access is None else access.at(audience)
    return presenter, theirs, room_told(mine, theirs, request.data_dir is not None or isinstance(place.place, str))


def _run(server: LabServer, tell: Callable[[], object], prepare: Callable[[LabServer], object], end: Ending,
         heartbeat: float = 5.0) -> None:
    """Serve until somebody asks for the end; `tell` is called first. `heartbeat` is the time in s between two signs of life."""
    try:
        end.stands = True  # raised within an import, an interrupt could set the exit status, even when it is caught
        tell()
        server.prepare()
        prepare(server)
        server.wait(end.come, heartbeat)
    finally:
        for ending in ENDINGS:
            signal.signal(ending, signal.SIG_IGN)  # it is ending already
        server.stop()
        log.info("stopped")


def _keep_log(request: ServeRequest, worker: int = 0) -> None:
    from ..logs import set_up

    try:
        set_up(request.log_json, request.data_dir, worker)
    except (OSError, ValueError) as problem:
        raise CommandError(f"{str(request.data_dir)[:80]} cannot hold the log ({error_cause(problem)}); choose another "
                           f"folder.") from problem


def _door(request: ServeRequest) -> tuple[socket.socket, AccessToken | None, str, str]:
    """The listening socket, what one must know to come in, the address, and what of it is printed.

    That holds the token, but for a word of the environment: who put it there knows it, and what a service prints is a log.
    """
    from ...page.access.addresses import is_public, listen, url
    from ...page.access.tokens import VARIABLE, AccessToken, draw_token
    from ..workers import NOT_HERE, can_fork_workers

    given = os.environ.get(VARIABLE) if request.token is None else request.token
    word = draw_token() if given == "auto" else given
    if request.workers > 1 and not can_fork_workers():
        raise CommandError(NOT_HERE)
    try:
        access = AccessToken(word, request.port) if word else None
    except ValueError as problem:
        raise CommandError(f"The token of --token or {VARIABLE} cannot be used: {problem}.") from problem
    try:
        public = is_public(request.host)
        if public and not request.public:
            raise CommandError(f"{request.host[:80]} can be reached by other machines, without a password; say "
                               "--public as well if that is meant.")
        listener = listen(request.host, request.port, request.exact)
    except OSError as problem:
        raise CommandError(f"The server cannot listen on {request.host[:80]}, port {request.port} ({error_cause(problem)}); "
                           "choose a free port of an address of this machine.") from problem
    port = listener.getsockname()[1]
    access = None if access is None else replace(access, port=port)
    if public:
        may = "can open tabs, without a password" if access is None else "and knows its token can open tabs"
        print(OPEN_TO_ALL.format(host=request.host, may=may), file=sys.stderr)
    address, hidden = url(request.host, port), request.token is None and word == given
    return listener, access, address, address if access is None or hidden else access.at(address)
