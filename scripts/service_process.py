"""A service of a script's own, for the scripts beside this file: its process, its address, what it takes."""
import json
import os
import pathlib
import signal
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / 'python'))
from subpixel_client import Service  # noqa: E402, for those who import it from here


def fake_worker_beside(program):
    """The stand-in for the worker that the tests have; it starts at once and replays nothing."""
    path = pathlib.Path(program).resolve().parent / 'tests' / 'subpixel_fake_worker'
    if not path.exists():
        sys.exit(f'there is no {path}: build subpixel_fake_worker')
    return str(path)


def fake_capture(path, behaviour, size=0):
    """Writes what the fake worker takes for a capture (tests/service/fake_worker/main.cpp), of at least `size` bytes."""
    text = b'FAKE ' + json.dumps(behaviour).encode() + b'\n'
    pathlib.Path(path).write_bytes(text + bytes(max(0, size - len(text))))


class ServiceProcess:
    def __init__(self, program, data, worker=None, options=()):
        """`data`: its folder, beside which its log is written. `worker`: a stand-in; None: subpixel itself."""
        command = [program, 'serve', '--data', data, '--listen', '127.0.0.1:0', *options]
        command += ['--worker-program', worker] if worker else []
        self.log = open(os.path.join(os.path.dirname(data), 'service.log'), 'a')
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=self.log, text=True)
        said = self.process.stdout.readline().split()
        if not said:
            sys.exit(f'the service ended with {self.process.wait()}; see {self.log.name}')
        self.url = said[-1]
        self.port = int(self.url.rsplit(':', 1)[1])
        self.client = Service(self.url)

    def children(self):
        found = []
        try:
            for thread in os.listdir(f'/proc/{self.process.pid}/task'):
                with open(f'/proc/{self.process.pid}/task/{thread}/children') as file:
                    found += [int(child) for child in file.read().split()]
        except OSError:
            pass  # a thread that ended meanwhile
        return found

    def resident_bytes(self):
        for line in pathlib.Path(f'/proc/{self.process.pid}/status').read_text().splitlines():
            if line.startswith('VmRSS'):
                return int(line.split()[1]) * 1024
        return 0

    def descriptors(self):
        return len(os.listdir(f'/proc/{self.process.pid}/fd'))

    def kill(self):
        self.process.kill()
        self.process.wait()

    def end(self, within=None):
        """As an operator does, by SIGTERM."""
        self.process.send_signal(signal.SIGTERM)
        self.process.wait(timeout=within)
