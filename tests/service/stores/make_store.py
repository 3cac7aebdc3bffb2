#!/usr/bin/env python3
"""Makes versionN.sqlite beside this file: a small store of version N, with a capture, a run and its result, and from
version 2 on a night that a baseline names. To be run once, when the schema gets its version N: `make_store.py N`."""
import ctypes
import glob
import json
import os
import sqlite3
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
STORE = os.path.join(HERE, '../../../server/store')


def content_hash(data):
    class Hash(ctypes.Structure):
        _fields_ = [('low', ctypes.c_uint64), ('high', ctypes.c_uint64)]
    function = ctypes.CDLL('libxxhash.so.0').XXH3_128bits
    function.restype, function.argtypes = Hash, [ctypes.c_char_p, ctypes.c_size_t]
    found = function(data, len(data))
    return f'{found.high:016x}{found.low:016x}'


def main():
    version = int(sys.argv[1])
    path = os.path.join(HERE, f'version{version}.sqlite')
    if os.path.exists(path):
        os.remove(path)
    store = sqlite3.connect(path, isolation_level=None)
    store.execute('PRAGMA page_size = 512')
    steps = [os.path.join(STORE, 'schema.sql')] + sorted(glob.glob(os.path.join(STORE, 'migrations/*.sql')))
    for step in steps[:version]:
        with open(step, encoding='utf-8') as file:
            store.executescript(file.read())
    store.execute(f'PRAGMA user_version = {version}')

    capture, image = b'FAKE {}\n', b'pixels'
    capture_hash, image_hash = content_hash(capture), content_hash(image)
    then = '2025-01-31T12:00:00.123Z'
    parameters = {'samples': 1}
    options = {'techniques': [{'technique': 'noaa', 'parameters': parameters}], 'samples': 8, 'frames': [0, 0],
               'width': 32, 'height': 18, 'repeat': 1, 'reference_samples': 0, 'point_lights': None, 'skip': []}
    request = {'capture': '', 'out_dir': '', 'cache_dir': '', 'options': options}
    result = {'frame': 0, 'technique': 'noaa', 'parameters': parameters, 'samples': 1, 'width': 32, 'height': 18,
              'ms': {'total': 4, 'passes': {'shade': 4}, 'pass_order': ['shade'], 'cold': 5}, 'spread': 1,
              'memory': {'paper_bytes_per_pixel': 8, 'fitted_bytes_per_pixel': 8, 'paper_bytes': 4608,
                         'fitted_bytes': 4608, 'allocated_bytes': 4608},
              'shading': {'executions': 576, 'per_pixel_mean': 1, 'histogram': [0, 576], 'group_executions': 576,
                          'fragments': {}},
              'error': dict.fromkeys(['mse', 'psnr', 'flip_mean', 'flip_p99', 'flip_max', 'hdr_rel_mse', 'flicker']),
              'counters': {}, 'images': {'image': image_hash}}
    store.execute('PRAGMA foreign_keys = ON')
    store.execute('INSERT INTO blobs (hash, media_type, bytes) VALUES (?, ?, ?)', (image_hash, 'image/png', image))
    store.execute('INSERT INTO captures (hash, name, size_bytes, uploaded_utc, title, frame_count, width, height, '
                  'triangles, summary, thumbnail) VALUES (?, ?, ?, ?, ?, 1, 32, 18, 1234, ?, ?)',
                  (capture_hash, 'kept.spcap', len(capture), then, 'Kept', '{"features":[]}', image_hash))
    store.execute("INSERT INTO runs (id, kind, capture, status, created_utc, started_utc, finished_utc, request, "
                  "expected_results) VALUES (1, 'run', ?, 'done', ?, ?, ?, ?, 1)",
                  (capture_hash, then, then, then, json.dumps(request)))
    store.execute("INSERT INTO run_techniques VALUES (1, 0, 'noaa', ?)", (json.dumps(parameters),))
    store.execute('INSERT INTO frame_results (id, run, sequence, frame, technique_ordinal, technique, total_ms, '
                  "fitted_bytes_per_pixel, executions, document) VALUES (1, 1, 1, 0, 0, 'noaa', 4, 8, 576, ?)",
                  (json.dumps(result),))
    store.execute("INSERT INTO pass_times VALUES (1, 0, 'shade', 4)")
    store.execute("INSERT INTO images VALUES (1, 'image', ?)", (image_hash,))
    if version >= 2:
        store.execute("INSERT INTO capture_tags VALUES (?, 'nightly')", (capture_hash,))
        store.execute("INSERT INTO nights (id, name, status, started_utc, finished_utc, build, config) "
                      "VALUES (1, 'quick', 'passed', ?, ?, '0.1.0', '{}')", (then, then))
        store.execute("INSERT INTO night_captures VALUES (1, 0, 'kept', 'tag nightly', ?, '', NULL)", (capture_hash,))
        store.execute("INSERT INTO night_cells VALUES (1, 1, 0, 'noaa', 'passed', '[]', ?)",
                      (json.dumps({'ms': 4, 'spread': 1, 'references': {}}),))
        store.execute('INSERT INTO night_frames VALUES (1, 1, 0, ?)', (json.dumps(result),))
        store.execute("INSERT INTO night_images VALUES (1, 'image', ?)", (image_hash,))
        store.execute("INSERT INTO baselines (name, night, set_utc) VALUES ('quick', 1, ?)", (then,))
    store.execute('VACUUM')
    store.execute('PRAGMA journal_mode = WAL')
    store.close()
    print(path, os.path.getsize(path), 'bytes; the capture is', capture_hash)


main()
