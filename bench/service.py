#!/usr/bin/env python3
"""How fast the service is: uploads against `cp`, queries of a store of a million results, a thousand watchers of a run.

    bench/service.py build/release/subpixel [--only uploads|queries|watchers] [--results 1000000] [--megabytes 512]

Prints tables; docs/operations.md has the figures. The store is filled past the service, by SQL, since each of its commits
would wait for the disk; the documents are the fake worker's. Needs 4 GB in TMPDIR.
"""
import argparse
import json
import os
import pathlib
import random
import selectors
import socket
import sqlite3
import statistics
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / 'scripts'))
from service_process import ServiceProcess, fake_capture, fake_worker_beside  # noqa: E402

TECHNIQUES = ['noaa', 'msaa:samples=8', 'streaming:samples=8', 'dcaa:samples=64']
FRAMES = 250  # of each run in the large store: a thousand results


def uploads(start, folder, megabytes):
    service = start()
    print('| | MB/s | of cp |\n| --- | --- | --- |')
    rates = []
    for turn in range(3):
        file = os.path.join(folder, 'large.spcap')
        fake_capture(file, {'frames': 1, 'title': str(turn)}, megabytes << 20)
        os.sync()
        began = time.monotonic()
        subprocess.run(['cp', file, file + '.copy'], check=True)
        subprocess.run(['sync', '-d', file + '.copy'], check=True)
        copied = time.monotonic() - began
        os.remove(file + '.copy')
        began = time.monotonic()
        service.client.upload_capture(file)
        rates.append((megabytes / copied, megabytes / (time.monotonic() - began)))
    copied, sent = (statistics.median(rate[i] for rate in rates) for i in (0, 1))
    print(f'| cp, synced | {copied:.0f} | 1 |\n| upload, hashed, synced, inspected | {sent:.0f} | {sent / copied:.2f} |')
    service.end()


def fill(store, results):
    """Copies the store's one run, whose results are those of each technique on a frame, until it has so many."""
    database = sqlite3.connect(store)
    database.execute('PRAGMA synchronous = OFF')

    def copies(table, columns, of_run):
        return database.execute(f'SELECT {", ".join(columns)} FROM {table} WHERE {of_run}').fetchall()

    (run,) = database.execute("SELECT max(id) FROM runs WHERE kind = 'run'").fetchone()
    columns = [row[1] for row in database.execute('PRAGMA table_info(runs)') if row[1] != 'id']
    database.execute(f"UPDATE runs SET expected_results = {FRAMES * len(TECHNIQUES)} WHERE id = {run}")
    techniques = copies('run_techniques', ['ordinal', 'technique', 'parameters'], f'run = {run}')
    result_columns = ['technique_ordinal', 'technique', 'total_ms', 'fitted_bytes_per_pixel', 'executions', 'mse',
                      'flip_mean', 'document', 'id']
    first = copies('frame_results', result_columns, f'run = {run} AND frame = 0')
    passes = {row[-1]: copies('pass_times', ['ordinal', 'name', 'median_ms'], f'result = {row[-1]}') for row in first}
    images = {row[-1]: copies('images', ['role', 'blob'], f'result = {row[-1]}') for row in first}
    (result,) = database.execute('SELECT max(id) FROM frame_results').fetchone()
    count = database.execute('SELECT count(*) FROM frame_results').fetchone()[0]
    while count < results:
        new = database.execute(f'INSERT INTO runs ({", ".join(columns)}) SELECT {", ".join(columns)} FROM runs '
                               'WHERE id = ?', (run,)).lastrowid
        database.executemany(f'INSERT INTO run_techniques VALUES ({new}, ?, ?, ?)', techniques)
        rows, pass_rows, image_rows = [], [], []
        for frame in range(FRAMES):
            for row in first:
                result += 1
                document = row[7].replace('"frame":0', f'"frame":{frame}')
                rows.append((result, new, len(rows) + 1, frame, *row[:7], document))
                pass_rows += [(result, *each) for each in passes[row[-1]]]
                image_rows += [(result, *each) for each in images[row[-1]]]
        database.executemany(f'INSERT INTO frame_results VALUES ({", ".join("?" * 12)})', rows)
        database.executemany('INSERT INTO pass_times VALUES (?, ?, ?, ?)', pass_rows)
        database.executemany('INSERT INTO images VALUES (?, ?, ?)', image_rows)
        count += len(rows)
        database.commit()
    runs = [row[0] for row in database.execute("SELECT id FROM runs WHERE kind = 'run' AND id > ?", (run,))]
    database.close()
    return count, runs


def queries(start, folder, results):
    service = start()
    capture = os.path.join(folder, 'small.spcap')
    fake_capture(capture, {'frames': 1, 'result_ms': 1, 'width': 16, 'height': 9})
    stored = service.client.upload_capture(capture)
    run = service.client.start_run({'capture': stored['hash'], 'techniques': TECHNIQUES, 'width': 16, 'height': 9})['id']
    for event, _ in service.client.follow_run(run):
        pass
    service.end()
    store = os.path.join(folder, 'data', 'subpixel.sqlite')
    began = time.monotonic()
    count, runs = fill(store, results)
    print(f'{count} results in {len(runs) + 1} runs, {os.path.getsize(store) / 2**30:.2f} GiB, '
          f'filled in {time.monotonic() - began:.0f} s\n')
    service = start()
    chance = random.Random(1)
    client = service.client
    asked = {'list of runs': lambda run: client.list_runs(limit=50, before=run),
             'list of captures': lambda run: client.list_captures(),
             'one run': client.get_run,
             f'its {FRAMES * len(TECHNIQUES)} results, JSON': client.get_results,
             'the same, CSV': client.get_results_csv,
             'its plot': client.get_plot,
             'advice': lambda run: client.get_advice(run, max_mse=0.01),
             'metrics': lambda run: client.get_metrics()}
    print('| query | p50 ms | p95 ms | worst ms |\n| --- | --- | --- | --- |')
    for name, ask in asked.items():
        times = []
        for _ in range(100):
            began = time.monotonic()
            ask(chance.choice(runs))
            times.append(1000 * (time.monotonic() - began))
        times.sort()
        print(f'| {name} | {times[49]:.1f} | {times[94]:.1f} | {times[-1]:.1f} |', flush=True)
    service.end()


def watchers(start, folder, count):
    service = start()
    capture = os.path.join(folder, 'watched.spcap')
    fake_capture(capture, {'frames': 25, 'result_ms': 200, 'width': 16, 'height': 9})
    stored = service.client.upload_capture(capture)
    run = service.client.start_run({'capture': stored['hash'], 'techniques': ['noaa', 'msaa'], 'width': 16, 'height': 9})
    request = f'GET /api/runs/{run["id"]}/events HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n'.encode()
    selector = selectors.DefaultSelector()
    for _ in range(count):
        connection = socket.create_connection(('127.0.0.1', service.port))
        connection.sendall(request)
        connection.setblocking(False)
        selector.register(connection, selectors.EVENT_READ, bytearray())
    arrivals = {}  # event's number to the times at which watchers had it
    open_connections = count
    while open_connections:
        for key, _ in selector.select():
            bytes_now = key.fileobj.recv(1 << 16)
            now = time.monotonic()
            begin = max(0, len(key.data) - 20)
            key.data.extend(bytes_now)
            for line in key.data[begin:].split(b'\n'):
                if line.startswith(b'id: ') and line[4:].strip().isdigit():
                    arrivals.setdefault(int(line[4:]), {}).setdefault(key.fd, now)
            if not bytes_now or b'event: end' in key.data:
                selector.unregister(key.fileobj)
                key.fileobj.close()
                open_connections -= 1
    lags = [1000 * (max(times.values()) - min(times.values())) for times in arrivals.values()]
    missed = sum(count - len(times) for times in arrivals.values())
    print(f'{count} watchers, {len(arrivals)} results, {missed} not told; from the first watcher that has a result to the '
          f'last: median {statistics.median(lags):.0f} ms, worst {max(lags):.0f} ms; {service.resident_bytes() >> 20} MB')
    service.end()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('program', help='subpixel')
    parser.add_argument('--only', choices=['uploads', 'queries', 'watchers'])
    parser.add_argument('--results', type=int, default=1_000_000)
    parser.add_argument('--megabytes', type=int, default=512)
    parser.add_argument('--watchers', type=int, default=1000)
    arguments = parser.parse_args()
    worker = fake_worker_beside(arguments.program)
    for name, measure in (('uploads', lambda start, folder: uploads(start, folder, arguments.megabytes)),
                          ('queries', lambda start, folder: queries(start, folder, arguments.results)),
                          ('watchers', lambda start, folder: watchers(start, folder, arguments.watchers))):
        if arguments.only in (None, name):
            print(f'\n## {name}\n', flush=True)
            with tempfile.TemporaryDirectory() as folder:
                measure(lambda: ServiceProcess(arguments.program, os.path.join(folder, 'data'), worker), folder)


main()
