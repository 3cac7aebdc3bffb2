#!/usr/bin/env python3
"""Kills the service or its worker, as kill -9 does, at random moments of a run of many frames until it has done so KILLS
times, lets the run end, and compares it with the same run left alone: every result is there once, with the same bits.

    scripts/kill_campaign.py build/release/subpixel --kills 500
    scripts/kill_campaign.py build/release/subpixel --kills 500 --fake-worker build/release/tests/subpixel_fake_worker

The real worker replays small frames of `subpixel generate`. The fake one starts at once, so that more kills fall into the
store's commits. A campaign that ends before its kills are done starts another run. Exit code 1 when anything differs.
"""
import argparse
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time

from service_process import ServiceProcess, fake_capture


def results_of(service, run):
    """(frame, technique with parameters) to the hashes of images and the counts; stops at one that is there twice."""
    found = {}
    for result in service.client.get_results(run)['results']:
        key = (result['frame'], json.dumps([result['technique'], result['parameters']], sort_keys=True))
        if key in found:
            sys.exit(f'run {run}: {key} is there twice')
        found[key] = json.dumps([result['images'], result['shading'], result['error']], sort_keys=True)
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('binary')
    parser.add_argument('--kills', type=int, default=500)
    parser.add_argument('--fake-worker')
    parser.add_argument('--frames', type=int, default=60)
    parser.add_argument('--longest-wait', type=float, help='seconds between kills; default 3, with a fake worker 0.1')
    parser.add_argument('--seed', type=int, default=1)
    arguments = parser.parse_args()
    longest = arguments.longest_wait or (0.1 if arguments.fake_worker else 3)
    chance = random.Random(arguments.seed)
    with tempfile.TemporaryDirectory() as folder:
        capture = os.path.join(folder, 'capture.spcap')
        if arguments.fake_worker:
            fake_capture(capture, {'frames': arguments.frames, 'result_ms': 3})
        else:
            subprocess.run([arguments.binary, 'generate', 'spheres', capture, '--frames', str(arguments.frames),
                            '--size', '96x64'], check=True, stdout=subprocess.DEVNULL)
        def start():
            return ServiceProcess(arguments.binary, os.path.join(folder, 'data'), arguments.fake_worker)

        service = start()
        stored = service.client.upload_capture(capture)
        request = {'capture': stored['hash'], 'techniques': ['noaa', 'msaa:samples=4', 'dcaa'], 'repeat': 1,
                   'width': 96, 'height': 64, 'reference_samples': 64, 'retries': 1000}

        def status(run):
            return service.client.get_run(run)

        def wait_for(run):
            while (now := status(run))['status'] in ('queued', 'running'):
                time.sleep(0.05)
            if now['status'] != 'done' or now['stored_results'] != now['expected_results']:
                sys.exit(f'run {run} ended as {now["status"]}: {now["reason"]}')

        started = time.monotonic()
        alone = service.client.start_run(request)['id']
        wait_for(alone)
        expected = results_of(service, alone)
        print(f'{len(expected)} results, {time.monotonic() - started:.1f} s when left alone', flush=True)
        kills = {'service': 0, 'worker': 0}
        runs = []
        started = time.monotonic()
        while sum(kills.values()) < arguments.kills:
            run = service.client.start_run(request)['id']
            runs.append(run)
            seen = {}
            while sum(kills.values()) < arguments.kills and status(run)['status'] in ('queued', 'running'):
                time.sleep(chance.uniform(0, longest))
                committed = results_of(service, run)
                if not seen.items() <= committed.items():
                    sys.exit(f'run {run}: a result that was read is gone or another')
                seen = committed
                if chance.random() < 0.5:
                    service.kill()
                    service = start()
                    kills['service'] += 1
                else:
                    for child in service.children():
                        os.kill(child, signal.SIGKILL)
                        kills['worker'] += 1
        for run in runs:
            wait_for(run)
            if results_of(service, run) != expected:
                sys.exit(f'run {run} has other results than the one that was left alone')
        service.end(within=5)
        print(f'{kills["service"]} kills of the service, {kills["worker"]} of workers in {len(runs)} runs and '
              f'{time.monotonic() - started:.0f} s: every result once, all the same')


main()
