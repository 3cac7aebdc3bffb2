"""A client of the service (`subpixel serve`), in one file without dependencies: copy it where it is needed.

    service = Service('http://127.0.0.1:8080', token='spx_...')
    capture = service.upload_capture('park.spcap')
    run = service.start_run({'capture': capture['hash'], 'techniques': ['noaa,msaa:samples=4|8']})
    for event, data in service.follow_run(run['id']):
        print(event, data)
    print(service.get_results(run['id'])['results'][0]['ms']['total'])

One method for each operation of /api/openapi.json, with its name, the path's parts as arguments in their order and the
query as keywords; tests/python/client_test.py holds it to that. Documents come as dictionaries, everything else as
bytes. What the service refuses is raised as Refused.
"""
import http.client
import json
import os
import urllib.error
import urllib.parse
import urllib.request


class Refused(Exception):
    """An answer other than success: `status`, `what`, `why`, `where`, as docs/http_api.md has them."""

    def __init__(self, status, what, why, where):
        super().__init__(f'{what}: {why}: {where}')
        self.status, self.what, self.why, self.where = status, what, why, where


class Service:
    def __init__(self, address, token=None, timeout=360):
        """`token`: where the service wants one; without it the environment's SUBPIXEL_TOKEN, if any. `timeout`: seconds
        without a byte; a service reads a large capture before it answers."""
        self._address = address.rstrip('/')
        self._token = token if token is not None else os.environ.get('SUBPIXEL_TOKEN')
        self._timeout = timeout

    # Captures and blobs.

    def upload_capture(self, path, *, name=None):
        """Sends the file `path`."""
        with open(path, 'rb') as file:
            headers = {'Content-Type': 'application/octet-stream', 'Content-Length': str(os.path.getsize(path))}
            return self._ask('POST', '/api/captures', {'name': name or os.path.basename(path)}, file, headers)

    def list_captures(self, *, limit=None, offset=None):
        return self._ask('GET', '/api/captures', {'limit': limit, 'offset': offset})

    def get_capture(self, hash):
        return self._ask('GET', f'/api/captures/{_part(hash)}')

    def download_capture(self, hash):
        return self._ask('GET', f'/api/captures/{_part(hash)}/file')

    def tell_story(self, hash, *, technique=None, x=None, y=None, frame=None, width=None, height=None, samples=None,
                   reference_samples=None, point_lights=None):
        """What happens in a pixel; `technique` as the command line has it."""
        return self._ask('GET', f'/api/captures/{_part(hash)}/pixel', {
            'technique': technique, 'x': x, 'y': y, 'frame': frame, 'width': width, 'height': height,
            'samples': samples, 'reference_samples': reference_samples, 'point_lights': point_lights})

    def show_frame(self, hash, *, frame=None, width=None, height=None):
        """A frame's draws, its picture, and which draw each pixel shows."""
        return self._ask('GET', f'/api/captures/{_part(hash)}/frame',
                         {'frame': frame, 'width': width, 'height': height})

    def set_tags(self, hash, body):
        """`body`: {'tags': [...]}, which replace those it has."""
        return self._ask('POST', f'/api/captures/{_part(hash)}/tags', body=body)

    def delete_capture(self, hash):
        return self._ask('DELETE', f'/api/captures/{_part(hash)}')

    def download_blob(self, hash):
        return self._ask('GET', f'/api/blobs/{_part(hash)}')

    # Runs.

    def start_run(self, body, *, once=None):
        return self._ask('POST', '/api/runs', {'once': once}, body)

    def list_runs(self, *, limit=None, before=None, capture=None):
        return self._ask('GET', '/api/runs', {'limit': limit, 'before': before, 'capture': capture})

    def get_run(self, run):
        return self._ask('GET', f'/api/runs/{_part(run)}')

    def cancel_run(self, run):
        return self._ask('POST', f'/api/runs/{_part(run)}/cancel')

    def delete_run(self, run):
        return self._ask('DELETE', f'/api/runs/{_part(run)}')

    def follow_run(self, run, *, after=None):
        """Yields (event, data) of the progress until its "end": 'result', 'status' and 'end'."""
        with self._open('GET', f'/api/runs/{_part(run)}/events', {'after': after}, None, {}) as answer:
            event = None
            for line in answer:
                name, _, value = line.decode().rstrip('\n').partition(': ')
                if name == 'event':
                    event = value
                elif name == 'data':
                    yield event, json.loads(value)

    def get_results(self, run):
        return self._ask('GET', f'/api/runs/{_part(run)}/results.json')

    def get_results_csv(self, run):
        return self._ask('GET', f'/api/runs/{_part(run)}/results.csv')

    def get_plot(self, run, *, cost=None, error=None):
        return self._ask('GET', f'/api/runs/{_part(run)}/plot.svg', {'cost': cost, 'error': error})

    def get_points_csv(self, run):
        return self._ask('GET', f'/api/runs/{_part(run)}/points.csv')

    def get_points_markdown(self, run):
        return self._ask('GET', f'/api/runs/{_part(run)}/points.md')

    def get_advice(self, run, *, max_flip=None, max_mse=None):
        return self._ask('GET', f'/api/runs/{_part(run)}/advice', {'max_flip': max_flip, 'max_mse': max_mse})

    # Nights and baselines.

    def list_nights(self, *, limit=None, before=None, name=None):
        return self._ask('GET', '/api/nights', {'limit': limit, 'before': before, 'name': name})

    def get_night(self, night):
        return self._ask('GET', f'/api/nights/{_part(night)}')

    def get_night_markdown(self, night):
        return self._ask('GET', f'/api/nights/{_part(night)}/summary.md')

    def get_night_junit(self, night):
        return self._ask('GET', f'/api/nights/{_part(night)}/summary.xml')

    def get_cell(self, night, cell):
        return self._ask('GET', f'/api/nights/{_part(night)}/cells/{_part(cell)}')

    def get_trends(self, *, name=None, capture=None, technique=None, limit=None):
        return self._ask('GET', '/api/nights/trends', {
            'name': name, 'capture': capture, 'technique': technique, 'limit': limit})

    def get_trends_csv(self, *, name=None, capture=None, technique=None, limit=None):
        return self._ask('GET', '/api/nights/trends.csv', {
            'name': name, 'capture': capture, 'technique': technique, 'limit': limit})

    def list_baselines(self):
        return self._ask('GET', '/api/baselines')

    def list_approvals(self, *, name=None):
        return self._ask('GET', '/api/approvals', {'name': name})

    def approve_night(self, body):
        """`body`: {'name': ..., 'night': ..., 'why': ...}."""
        return self._ask('POST', '/api/baselines', body=body)

    # The service itself.

    def get_techniques(self):
        return self._ask('GET', '/api/techniques')

    def get_limits(self):
        return self._ask('GET', '/api/limits')

    def get_palettes(self):
        return self._ask('GET', '/api/palettes')

    def get_health(self):
        return self._ask('GET', '/api/health')

    def get_openapi(self):
        return self._ask('GET', '/api/openapi.json')

    def get_metrics(self):
        return self._ask('GET', '/metrics')

    def is_alive(self):
        return self._ask('GET', '/healthz')

    def is_ready(self):
        return self._ask('GET', '/readyz')

    def get_caller(self):
        return self._ask('GET', '/api/caller')

    def sign_in(self, body):
        return self._ask('POST', '/api/sign-in', body=body)

    def sign_out(self):
        return self._ask('POST', '/api/sign-out')

    def _ask(self, method, path, query=None, body=None, headers=None):
        with self._open(method, path, query or {}, body, dict(headers or {})) as answer:
            content = answer.read()
            if answer.headers.get('Content-Type') == 'application/json':
                return json.loads(content)
            return content or None

    def _open(self, method, path, query, body, headers):
        given = {name: value for name, value in query.items() if value is not None}
        address = self._address + path + ('?' + urllib.parse.urlencode(given) if given else '')
        if isinstance(body, dict):
            body = json.dumps(body).encode()
            headers['Content-Type'] = 'application/json'
        elif body is None and method == 'POST':
            body = b''
        if self._token:
            headers['Authorization'] = f'Bearer {self._token}'
        request = urllib.request.Request(address, data=body, headers=headers, method=method)
        try:
            return urllib.request.urlopen(request, timeout=self._timeout)
        except urllib.error.HTTPError as error:
            with error:
                raise _refusal(error.code, error.read(), address) from None
        except (urllib.error.URLError, http.client.HTTPException) as error:
            raise Refused(0, 'no answer', str(error), address) from error


def _part(value):
    return urllib.parse.quote(str(value), safe='')


def _refusal(status, content, address):
    try:
        error = json.loads(content)['error']
        return Refused(status, error['what'], error['why'], error['where'])
    except (ValueError, KeyError, TypeError):
        return Refused(status, 'the request failed', f'status {status}', address)
