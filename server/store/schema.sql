-- The whole store, version 1. The version lives in `PRAGMA user_version`.
--
-- Policy: this file always describes version 1, and migrations/NNNN.sql takes a store from version NNNN-1 to NNNN. A new
-- store runs all of them in order, an old one those it lacks, each in one transaction with its version number, so a store
-- is never between two versions. A store newer than the program is refused. Published steps are not edited.
--
-- Times are UTC in ISO 8601, sizes bytes, durations milliseconds, hashes XXH3-128 in 32 lowercase hex digits.

CREATE TABLE blobs (
  hash TEXT PRIMARY KEY CHECK (length(hash) = 32),
  media_type TEXT NOT NULL,
  bytes BLOB NOT NULL
) STRICT;

CREATE TABLE captures (
  hash TEXT PRIMARY KEY CHECK (length(hash) = 32),
  name TEXT NOT NULL,        -- as uploaded; shown to people, never a path
  size_bytes INTEGER NOT NULL,
  uploaded_utc TEXT NOT NULL,
  title TEXT NOT NULL,       -- of the capture's own metadata
  frame_count INTEGER NOT NULL,
  width INTEGER NOT NULL,    -- of the first frame, as recorded
  height INTEGER NOT NULL,
  triangles INTEGER NOT NULL,  -- of the frame that has most
  summary TEXT NOT NULL,     -- JSON: what `subpixel info --json` says
  thumbnail TEXT REFERENCES blobs (hash)
) STRICT;
CREATE INDEX captures_by_upload ON captures (uploaded_utc DESC, hash);
CREATE INDEX captures_by_thumbnail ON captures (thumbnail);

CREATE TABLE runs (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  kind TEXT NOT NULL CHECK (kind IN ('run', 'thumbnail')),
  capture TEXT NOT NULL REFERENCES captures (hash) ON DELETE CASCADE,
  status TEXT NOT NULL CHECK (status IN ('queued', 'running', 'done', 'failed', 'cancelled')),
  reason TEXT NOT NULL DEFAULT '',  -- why it failed
  created_utc TEXT NOT NULL,
  started_utc TEXT,
  finished_utc TEXT,
  request TEXT NOT NULL,            -- JSON: ReplayOptions without `skip`, as checked
  head TEXT,                        -- JSON: ResultsHead, once a worker has sent it
  expected_results INTEGER NOT NULL,
  -- Workers started since the last stored result. It bounds how often a run that takes the server down is resumed.
  starts_without_result INTEGER NOT NULL DEFAULT 0
) STRICT;
CREATE INDEX runs_by_status ON runs (status, kind, id);
CREATE INDEX runs_by_kind ON runs (kind, id);
CREATE INDEX runs_by_capture ON runs (capture, id);

-- What a run was asked for: one line for each technique with all its parameter values, in the order of the request.
CREATE TABLE run_techniques (
  run INTEGER NOT NULL REFERENCES runs (id) ON DELETE CASCADE,
  ordinal INTEGER NOT NULL,
  technique TEXT NOT NULL,
  parameters TEXT NOT NULL,  -- JSON object
  PRIMARY KEY (run, ordinal)
) STRICT, WITHOUT ROWID;
CREATE INDEX run_techniques_by_technique ON run_techniques (technique, run);

-- One measured frame of one technique. `document` is the FrameResult as JSON, its images named by blob hash; the columns
-- repeat what is searched and sorted by.
CREATE TABLE frame_results (
  id INTEGER PRIMARY KEY,
  run INTEGER NOT NULL REFERENCES runs (id) ON DELETE CASCADE,
  sequence INTEGER NOT NULL,  -- 1, 2, ... in the order of storing; the event id of the progress stream
  frame INTEGER NOT NULL,
  technique_ordinal INTEGER NOT NULL,
  technique TEXT NOT NULL,
  total_ms REAL NOT NULL,
  fitted_bytes_per_pixel REAL NOT NULL,
  executions INTEGER NOT NULL,
  mse REAL,
  flip_mean REAL,
  document TEXT NOT NULL,
  UNIQUE (run, sequence),
  UNIQUE (run, frame, technique_ordinal),
  FOREIGN KEY (run, technique_ordinal) REFERENCES run_techniques (run, ordinal) ON DELETE CASCADE
) STRICT;
CREATE INDEX frame_results_by_technique ON frame_results (technique, run);
CREATE INDEX frame_results_by_request ON frame_results (run, technique_ordinal);

CREATE TABLE pass_times (
  result INTEGER NOT NULL REFERENCES frame_results (id) ON DELETE CASCADE,
  ordinal INTEGER NOT NULL,
  name TEXT NOT NULL,
  median_ms REAL NOT NULL,
  PRIMARY KEY (result, ordinal)
) STRICT, WITHOUT ROWID;
CREATE INDEX pass_times_by_name ON pass_times (name, result);

CREATE TABLE images (
  result INTEGER NOT NULL REFERENCES frame_results (id) ON DELETE CASCADE,
  role TEXT NOT NULL,
  blob TEXT NOT NULL REFERENCES blobs (hash),
  PRIMARY KEY (result, role)
) STRICT, WITHOUT ROWID;
CREATE INDEX images_by_blob ON images (blob);
