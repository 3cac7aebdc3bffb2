#!/usr/bin/env python3
"""Whether slow clients of the service hold up others: starts one, sets slow ones on it and measures another client.

    scripts/slow_clients.py build/release/subpixel [--seconds 30] [--addresses 50]

2,000 idle connections, 500 that send a header byte by byte, 200 uploads that come byte by byte, 200 clients that ask for
a large file and don't read, 1,000 followers of a run; each that is closed comes back. Prints one line for each kind and
one for all at once, and exits with 1 when one breaks the bounds: median 100 ms, worst 1 s, 300 MB. Python's standard
library only.
"""
import argparse
import http.client
import multiprocessing
import os
import resource
import socket
import statistics
import sys
import tempfile
import threading
import time

from service_process import ServiceProcess, fake_capture, fake_worker_beside

CAPTURE_BYTES = 16 << 20
MEDIAN_S, WORST_S, MEMORY_MB = 0.1, 1.0, 300
HOST = "Host: 127.0.0.1\r\n"


class Slow:
    """One connection that sends its first words at once and then a byte of `drip` every second; renewed when closed."""

    def __init__(self, port, address, first, drip):
        self.port, self.address, self.first, self.drip, self.socket = port, address, first, drip, None

    def step(self):
        try:
            if self.socket is None:
                self.connect()
            elif self.drip:
                self.socket.send(self.drip)
            elif self.socket.recv(1, socket.MSG_PEEK) == b"":
                raise ConnectionError
        except BlockingIOError:
            pass
        except OSError:
            self.close()

    def connect(self):
        self.socket = socket.socket()
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        self.socket.bind((self.address, 0))
        self.socket.connect(("127.0.0.1", self.port))
        self.socket.setblocking(False)
        if self.first:
            self.socket.send(self.first)

    def close(self):
        if self.socket is not None:
            self.socket.close()
            self.socket = None


def kinds(large_file, run):
    """Name: how many, what each sends first, what it drips."""
    get = lambda path: f"GET {path} HTTP/1.1\r\n{HOST}\r\n".encode()
    return {
        "idle": (2000, b"", b""),
        "headers": (500, f"GET /api/health HTTP/1.1\r\n{HOST}X: ".encode(), b"a"),
        "uploads": (200, f"POST /api/captures HTTP/1.1\r\n{HOST}Content-Length: 1000000\r\n\r\n".encode(), b"S"),
        "readers": (200, get(large_file), b""),
        "followers": (1000, get(f"/api/runs/{run}/events"), b""),
    }


def attack(port, wanted, addresses, ready):
    """Runs until it is killed."""
    clients = []
    for count, first, drip in wanted:
        for i in range(count):
            clients.append(Slow(port, f"127.0.0.{2 + i % addresses}" if addresses else "127.0.0.1", first, drip))
    while True:
        begin = time.monotonic()
        for client in clients:
            client.step()
        ready.set()
        time.sleep(max(0.05, 1 - (time.monotonic() - begin)))


class Usage(threading.Thread):
    """The most memory and descriptors a service had."""

    def __init__(self, service):
        super().__init__(daemon=True)
        self.service, self.megabytes, self.descriptors, self.ended = service, 0, 0, threading.Event()

    def run(self):
        while not self.ended.wait(0.2):
            self.megabytes = max(self.megabytes, self.service.resident_bytes() / 2**20)
            self.descriptors = max(self.descriptors, self.service.descriptors())


def request(port, method, path, body=None, headers=None):
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=120)
    connection.request(method, path, body, headers or {})
    response = connection.getresponse()
    content = response.read()
    connection.close()
    if response.status >= 300:
        raise RuntimeError(f"{method} {path}: {response.status} {content[:300]}")
    return content


def measure(service, name, wanted, addresses, seconds):
    """One line of figures; whether it is within the bounds."""
    ready = multiprocessing.Event()
    attacker = multiprocessing.Process(target=attack, args=(service.port, wanted, addresses, ready), daemon=True)
    usage = Usage(service)
    usage.start()
    attacker.start()
    times = []
    end = None
    while end is None or time.monotonic() < end:  # also while they come
        for path in ("/api/health", "/api/runs"):
            begin = time.monotonic()
            request(service.port, "GET", path)
            times.append(time.monotonic() - begin)
        if end is None and ready.is_set():
            end = time.monotonic() + seconds
        time.sleep(0.05)
    attacker.kill()
    attacker.join()
    usage.ended.set()
    usage.join()
    median, worst = statistics.median(times), max(times)
    print(f"| {name} | {'many' if addresses else 'one'} | {median * 1000:.1f} | {worst * 1000:.0f} | {len(times)} | "
          f"{usage.megabytes:.0f} | {usage.descriptors} |", flush=True)
    time.sleep(1)
    return median <= MEDIAN_S and worst <= WORST_S and usage.megabytes <= MEMORY_MB


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", help="subpixel")
    parser.add_argument("--seconds", type=float, default=30, help="of measuring, each kind")
    parser.add_argument("--addresses", type=int, default=0, help="that slow clients come from; 0: the measured one's")
    parser.add_argument("--only", help="one kind")
    arguments = parser.parse_args()
    hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
    good = True
    with tempfile.TemporaryDirectory() as folder:
        # The worker would take the time that is measured: a run that has a result a second and never ends.
        capture = os.path.join(folder, "large.spcap")
        fake_capture(capture, {"frames": 1000, "result_ms": 1000, "width": 4, "height": 4}, CAPTURE_BYTES)
        # Two workers: one has the thumbnail of the capture, the other the run.
        service = ServiceProcess(arguments.program, os.path.join(folder, "data"),
                                 fake_worker_beside(arguments.program), ["--workers", "2"])
        try:
            stored = service.client.upload_capture(capture)
            run = service.client.start_run({"capture": stored["hash"], "techniques": ["noaa"]})
            what = kinds(f"/api/captures/{stored['hash']}/file", run["id"])
            print(f"file of {stored['size_bytes']} bytes")
            print("| slow clients | addresses | median ms | worst ms | answers | memory MB | descriptors |")
            print("| --- | --- | --- | --- | --- | --- | --- |")
            for name, wanted in what.items():
                if arguments.only in (None, name):
                    label = f"{wanted[0]} {name}"
                    good &= measure(service, label, [wanted], arguments.addresses, arguments.seconds)
            if arguments.only in (None, "all"):
                good &= measure(service, "all of them", list(what.values()), arguments.addresses,
                                arguments.seconds)
        finally:
            service.end()
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
