"""python/subpixel_client.py against the service's own description, and the commands of docs/http_api.md as they stand."""
import inspect
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), '../..')
sys.path.insert(0, os.path.join(ROOT, 'python'))
import subpixel_client  # noqa: E402

BINARY = os.environ['SUBPIXEL_BINARY']
WORKER = os.environ['SUBPIXEL_FAKE_WORKER']
CAPTURE = b'FAKE {"frames": 2, "title": "Park"}\n'


class Served(unittest.TestCase):
    arguments = []

    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)
        self.data = os.path.join(self.folder, 'data')
        self.server = subprocess.Popen([BINARY, 'serve', '--data', self.data, '--listen', '127.0.0.1:0', '--worker-program',
                                        WORKER] + self.arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(self.end)
        self.address = self.server.stdout.readline().split()[-1]
        self.capture = os.path.join(self.folder, 'park.spcap')
        with open(self.capture, 'wb') as file:
            file.write(CAPTURE)

    def end(self):
        self.server.terminate()
        return self.server.communicate(timeout=30)[1]


class Client(Served):
    def test_has_each_operation_with_its_arguments(self):
        described = {}
        for path, methods in subpixel_client.Service(self.address).get_openapi()['paths'].items():
            for operation in methods.values():
                positional = [p['name'] for p in operation['parameters'] if p['in'] == 'path']
                if operation.get('requestBody'):
                    positional.append('path' if operation['operationId'] == 'upload_capture' else 'body')
                query = [p['name'] for p in operation['parameters'] if p['in'] == 'query']
                described[operation['operationId']] = (positional, query)
        offered = {}
        for name, method in inspect.getmembers(subpixel_client.Service, inspect.isfunction):
            if name.startswith('_'):
                continue
            parameters = list(inspect.signature(method).parameters.values())[1:]
            offered[name] = ([p.name for p in parameters if p.kind == p.POSITIONAL_OR_KEYWORD],
                             [p.name for p in parameters if p.kind == p.KEYWORD_ONLY])
        self.assertEqual(offered, described)

    def test_sends_a_capture_and_follows_its_run(self):
        service = subpixel_client.Service(self.address)
        capture = service.upload_capture(self.capture)
        self.assertEqual(capture['name'], 'park.spcap')
        self.assertEqual(service.download_capture(capture['hash']), CAPTURE)
        run = service.start_run({'capture': capture['hash'], 'techniques': ['noaa,msaa'], 'width': 32, 'height': 18})
        events = list(service.follow_run(run['id']))
        self.assertEqual([event for event, _ in events if event == 'result'], ['result'] * 4)
        self.assertEqual((events[-1][0], events[-1][1]['status']), ('end', 'done'))
        image = service.get_results(run['id'])['results'][0]['images']['image']
        self.assertEqual(service.download_blob(image)[:4], b'\x89PNG')
        self.assertEqual(service.start_run(service_request(capture), once=1)['id'], run['id'])
        self.assertIsNone(service.delete_run(run['id']))
        with self.assertRaises(subpixel_client.Refused) as refused:
            service.get_run(run['id'])
        self.assertEqual((refused.exception.status, refused.exception.where), (404, str(run['id'])))


def service_request(capture):
    return {'capture': capture['hash'], 'techniques': ['noaa,msaa'], 'width': 32, 'height': 18}


class Tokens(Served):
    arguments = ['--require-token', '--log-json', '--log-requests']

    def test_are_made_used_and_revoked(self):
        def token(*arguments):
            return subprocess.run([BINARY, 'token', *arguments, '--data', self.data], check=True, capture_output=True,
                                  text=True).stdout.strip()
        nobody = subpixel_client.Service(self.address, token='')
        with self.assertRaises(subpixel_client.Refused) as refused:
            nobody.list_runs()
        self.assertEqual(refused.exception.status, 401)
        secret = token('add', 'ci', '--rights', 'submit', '--days', '3')
        service = subpixel_client.Service(self.address, token=secret)
        capture = service.upload_capture(self.capture)
        sent = subprocess.run([BINARY, 'submit', self.capture, '--server', self.address, '--techniques', 'noaa', '--size',
                               '32x18', '--wait'], env={**os.environ, 'SUBPIXEL_TOKEN': secret}, check=True,
                              capture_output=True, text=True).stdout
        self.assertIn(capture['hash'], sent)
        self.assertIn('ci', token('list'))
        self.assertNotIn(secret[6:], token('list', '--json'))
        token('revoke', 'ci')
        with self.assertRaises(subpixel_client.Refused):
            service.list_runs()
        lines = self.end().splitlines()
        uploads = [line for line in map(parsed, lines) if line.get('operation') == 'upload_capture']
        self.assertEqual([(line['status'], line['caller'], line['level']) for line in uploads], [('201', 'ci', 'info')])
        self.assertTrue(uploads[0]['request'])
        begun = [line for line in map(parsed, lines) if line.get('operation') == 'start_run']
        ended = [line for line in map(parsed, lines) if line['message'].startswith('the run ended as done')]
        self.assertEqual(len(begun), 1)
        self.assertIn(begun[0]['run'], [line['run'] for line in ended])  # the capture's picture ends there, too
        self.assertNotIn(secret, '\n'.join(lines))


def parsed(line):
    import json
    return json.loads(line)


class Docs(Served):
    def test_commands_work_as_they_stand(self):
        with open(os.path.join(ROOT, 'docs/http_api.md'), encoding='utf-8') as file:
            examples = re.findall(r'^```sh\n(.*?)^```', file.read(), re.DOTALL | re.MULTILINE)
        self.assertGreaterEqual(len(examples), 3)
        script = 'set -euo pipefail\n' + ''.join(examples).replace('http://127.0.0.1:8080', self.address)
        done = subprocess.run(['bash', '-c', script], cwd=self.folder, capture_output=True, text=True, timeout=120)
        self.assertEqual(done.returncode, 0, done.stderr + done.stdout)
        self.assertIn('"status":"done"', done.stdout)


if __name__ == '__main__':
    unittest.main()
