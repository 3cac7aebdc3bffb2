#!/usr/bin/env python3
"""Keeps a service busy for hours as clients do, and watches whether what it holds grows: memory, descriptors, its store
and its folders.

    scripts/soak.py build/release/subpixel [--minutes 60] [--real-worker]

Clients upload captures, start, follow, cancel and delete runs and captures, send rubbish to every door, read pages,
break off answers and bodies in their middle. Each deletes what it made, so that the store has a bounded size. A line of
figures every so often; at the end the last quarter is compared with the second one. Exit code 1 when memory grew by more
than a tenth and 8 MB, descriptors by more than 16, the store or the folders by more than a tenth and 4 MB, when an answer
was not what it should be, or the log has an error. With --real-worker small frames are replayed.
"""
import argparse
import collections
import http.client
import os
import pathlib
import random
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time

from service_process import ServiceProcess, fake_capture, fake_worker_beside
from subpixel_client import Refused

CLIENTS = 6
LEAST_MINUTES = 5  # of a soak that says something of growth; a shorter one tells failures alone
MOST_RUNS_WAITING = 30  # of all clients; more than that are worked on later than they come


class Client(threading.Thread):
    """Does one thing after another until it is told to stop; `counts` says how often it did what."""

    def __init__(self, number, service, folder, real, stop):
        super().__init__(daemon=True)
        self.number, self.service, self.folder, self.real, self.stop = number, service, folder, real, stop
        self.chance = random.Random(number)
        self.counts, self.failures = collections.Counter(), []
        self.made = 0

    def run(self):
        doings = [self.measure, self.measure, self.cancel, self.rubbish, self.rubbish, self.read, self.break_off]
        while not self.stop.is_set():
            doing = self.chance.choice(doings)
            try:
                doing()
                self.counts[doing.__name__] += 1
            except Exception as error:  # each is a finding, and the others go on
                self.failures.append(f'{doing.__name__}: {error!r}')

    def upload(self):
        path = os.path.join(self.folder, f'{self.number}.spcap')
        self.made += 1
        title = f'{self.number}/{self.made}'
        if self.real:
            subprocess.run([self.service.binary, 'generate', 'spheres', path, '--frames', '2', '--size', '64x36',
                            '--seed', str(self.number * 1_000_000 + self.made)], check=True, stdout=subprocess.DEVNULL)
        else:
            fake_capture(path, {'frames': self.chance.randint(1, 4), 'result_ms': 5, 'title': title},
                         self.chance.randint(100, 300_000))
        return self.service.client.upload_capture(path)['hash']

    def start_run(self, capture):
        health = self.service.client.get_health()
        while health['queued'] > MOST_RUNS_WAITING and not self.stop.is_set():
            time.sleep(0.2)
            health = self.service.client.get_health()
        return self.service.client.start_run({'capture': capture, 'techniques': ['noaa', 'msaa:samples=4'], 'width': 64,
                                              'height': 36, 'repeat': 1, 'reference_samples': 0})['id']

    def forget(self, capture, runs):
        client = self.service.client
        for run in runs:
            client.delete_run(run)
        while True:  # the picture of a capture may still be made
            try:
                client.delete_capture(capture)
                return
            except Refused as refused:
                if refused.status != 409:
                    raise
                time.sleep(0.1)

    def measure(self):
        client = self.service.client
        capture = self.upload()
        client.set_tags(capture, {'tags': ['soak', str(self.number)]})
        run = self.start_run(capture)
        for event, data in client.follow_run(run):
            if event == 'end' and data['status'] != 'done':
                raise RuntimeError(f'run {run} ended as {data}')
        results = client.get_results(run)['results']
        if len({(r['frame'], r['technique']) for r in results}) != len(results) or not results:
            raise RuntimeError(f'run {run} has {len(results)} results')
        for result in results:
            client.download_blob(result['images']['image'])
        client.get_plot(run)
        self.forget(capture, [run])

    def cancel(self):
        client = self.service.client
        capture = self.upload()
        runs = [self.start_run(capture) for _ in range(3)]
        for run in runs:
            try:
                client.cancel_run(run)
            except Refused as refused:
                if refused.status != 409:  # it has ended
                    raise
        while any(client.get_run(run)['status'] in ('queued', 'running') for run in runs):
            time.sleep(0.05)
        self.forget(capture, runs)

    def ask(self, method, path, body=None, headers=None):
        connection = http.client.HTTPConnection('127.0.0.1', self.service.port, timeout=120)
        try:
            connection.request(method, path, body, headers or {})
            return connection.getresponse().status
        finally:
            connection.close()

    def rubbish(self):
        noise = self.chance.randbytes(self.chance.randint(0, 20_000))
        json_type = {'Content-Type': 'application/json'}
        method, path, body, headers, refused = self.chance.choice([
            ('POST', '/api/captures?name=x.spcap', noise, {}, True),
            ('POST', '/api/captures?name=x.zip', b'PK\x03\x04' + noise, {}, True),
            ('POST', '/api/captures?name=x.glb', b'glTF' + noise, {}, True),
            ('POST', '/api/captures?name=x.spcap', b'SPCAP' + noise, {}, True),
            ('POST', '/api/runs', noise, json_type, True),
            ('POST', '/api/runs', b'{"capture":"' + b'[' * 5000, json_type, True),
            ('POST', '/api/baselines', noise, json_type, True),
            ('POST', '/api/sign-in', b'{"token":"x"}', json_type, True),
            ('GET', '/api/runs/99999999999999999999', None, {}, True),
            ('GET', '/' + 'a' * 5000, None, {}, True),
            ('GET', '/api/captures?limit=-1', None, {}, True),
            ('DELETE', '/api/captures/' + '0' * 32, None, {}, True),
            ('PUT', '/api/health', b'x', {}, True),
            ('GET', '/api/health', None, {'X-' + 'a' * 3000: 'b'}, False)])
        status = self.ask(method, path, body, headers)
        if (status >= 400) != refused or status >= 500:
            raise RuntimeError(f'{method} {path}: {status}')

    def read(self):
        for path in ('/', '/app.js', '/metrics', '/readyz', '/api/captures', '/api/runs', '/api/nights', '/api/openapi.json'):
            if self.ask('GET', path) != 200:
                raise RuntimeError(path)

    def break_off(self):
        """Requests and answers that end in their middle."""
        first = self.chance.choice([
            b'GET /api/openapi.json HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n' * 3,
            b'POST /api/captures?name=x HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 1000000\r\n\r\nSPCAP',
            b'GET /api/hea', b'\x16\x03\x01\x02\x00', b''])
        with socket.create_connection(('127.0.0.1', self.service.port)) as connection:
            connection.sendall(first)
            if self.chance.random() < 0.5:
                connection.settimeout(0.2)
                try:
                    connection.recv(100)
                except OSError:
                    pass


def bytes_below(folder):
    total = 0
    for path in pathlib.Path(folder).rglob('*'):
        try:
            total += path.stat().st_size if path.is_file() else 0
        except OSError:
            pass  # it went meanwhile
    return total


def sample(service, data):
    return {'memory': service.resident_bytes(), 'descriptors': service.descriptors(),
            'store': sum(path.stat().st_size for path in pathlib.Path(data).glob('subpixel.sqlite*')),
            'folders': sum(bytes_below(os.path.join(data, name)) for name in ('captures', 'uploads', 'jobs', 'cache'))}


def growths(samples):
    """Of each figure the medians of the second and the last quarter, and whether that is flat."""
    quarter = len(samples) // 4
    for name, share, more in (('memory', 0.1, 8 << 20), ('descriptors', 0, 16), ('store', 0.1, 4 << 20),
                              ('folders', 0.1, 4 << 20)):
        before = statistics.median(each[name] for each in samples[quarter:2 * quarter])
        after = statistics.median(each[name] for each in samples[-quarter:])
        yield name, before, after, after <= before * (1 + share) + more


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('program', help='subpixel')
    parser.add_argument('--minutes', type=float, default=60)
    parser.add_argument('--lines', type=int, default=12, help='of figures')
    parser.add_argument('--real-worker', action='store_true')
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        data = os.path.join(folder, 'data')
        worker = None if arguments.real_worker else fake_worker_beside(arguments.program)
        service = ServiceProcess(arguments.program, data, worker)
        service.binary = arguments.program
        stop = threading.Event()
        clients = [Client(number, service, folder, arguments.real_worker, stop) for number in range(CLIENTS)]
        for client in clients:
            client.start()
        seconds = arguments.minutes * 60
        began, samples = time.monotonic(), []
        print('| minute | done | failed | memory MB | descriptors | store MB | folders MB |')
        print('| --- | --- | --- | --- | --- | --- | --- |')
        while (passed := time.monotonic() - began) < seconds and service.process.poll() is None:
            samples.append(now := sample(service, data))
            if len(samples) == 1 or passed >= shown + seconds / arguments.lines:
                shown = passed
                done = sum(sum(client.counts.values()) for client in clients)
                failed = sum(len(client.failures) for client in clients)
                print(f"| {passed / 60:.1f} | {done} | {failed} | {now['memory'] / 2**20:.1f} | {now['descriptors']} | "
                      f"{now['store'] / 2**20:.1f} | {now['folders'] / 2**20:.1f} |", flush=True)
            time.sleep(min(2, seconds / 40))
        stop.set()
        for client in clients:
            client.join(60)
        service.end(within=5)
        done = sum((client.counts for client in clients), collections.Counter())
        print(', '.join(f'{count} x {name}' for name, count in sorted(done.items())))
        good = service.process.returncode == 0 and all(done.values())
        for name, before, after, flat in growths(samples) if arguments.minutes >= LEAST_MINUTES else ():
            print(f'{name}: {before:.0f} in the second quarter, {after:.0f} in the last' + ('' if flat else ': it grows'))
            good &= flat
        failures = [failure for client in clients for failure in client.failures]
        errors = [line for line in pathlib.Path(service.log.name).read_text().splitlines() if 'error' in line]
        for problem in failures[:10] + errors[:10]:
            print(problem)
        sys.exit(0 if good and not failures and not errors else 1)


main()
