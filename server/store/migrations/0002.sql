-- Version 2: tags of captures; nights, what they measured, and the nights approved as baselines.

CREATE TABLE capture_tags (
  capture TEXT NOT NULL REFERENCES captures (hash) ON DELETE CASCADE,
  tag TEXT NOT NULL,
  PRIMARY KEY (capture, tag)
) STRICT, WITHOUT ROWID;
CREATE INDEX capture_tags_by_tag ON capture_tags (tag, capture);

-- Nights are no runs: they replay captures the store need not hold, by a process of their own beside the service.
CREATE TABLE nights (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  name TEXT NOT NULL,        -- of the configuration
  status TEXT NOT NULL CHECK (status IN ('running', 'passed', 'failed', 'interrupted')),
  reason TEXT NOT NULL DEFAULT '',
  started_utc TEXT NOT NULL,
  finished_utc TEXT,
  build TEXT NOT NULL,
  config TEXT NOT NULL,      -- JSON: the configuration as read
  baseline TEXT,             -- the name asked for
  -- The night it named then. Not a reference: that night may be deleted when the name has moved on.
  baseline_night INTEGER
) STRICT;
CREATE INDEX nights_by_name ON nights (name, id);

CREATE TABLE night_captures (
  night INTEGER NOT NULL REFERENCES nights (id) ON DELETE CASCADE,
  ordinal INTEGER NOT NULL,
  name TEXT NOT NULL,
  source TEXT NOT NULL,      -- "scene grass, seed 1", a path, "tag nightly"
  hash TEXT NOT NULL,        -- empty when there was no capture
  problem TEXT NOT NULL,     -- why not all of it was replayed
  head TEXT,                 -- JSON: ResultsHead
  PRIMARY KEY (night, ordinal)
) STRICT, WITHOUT ROWID;

-- One capture by one technique: a cell of the night's grid.
CREATE TABLE night_cells (
  id INTEGER PRIMARY KEY,
  night INTEGER NOT NULL,
  capture INTEGER NOT NULL,
  technique TEXT NOT NULL,   -- with the parameters that are not the default, as on the command line
  status TEXT NOT NULL CHECK (status IN ('unjudged', 'passed', 'failed', 'new', 'missing')),
  gates TEXT NOT NULL,       -- JSON: [{gate, outcome, detail}]
  time TEXT NOT NULL,        -- JSON: {ms, spread, references: {technique: {ms, spread}}}
  UNIQUE (night, capture, technique),
  FOREIGN KEY (night, capture) REFERENCES night_captures (night, ordinal) ON DELETE CASCADE
) STRICT;

CREATE TABLE night_frames (
  id INTEGER PRIMARY KEY,
  cell INTEGER NOT NULL REFERENCES night_cells (id) ON DELETE CASCADE,
  frame INTEGER NOT NULL,
  document TEXT NOT NULL,    -- FrameResult as JSON, its images named by blob hash
  UNIQUE (cell, frame)
) STRICT;

CREATE TABLE night_images (
  frame INTEGER NOT NULL REFERENCES night_frames (id) ON DELETE CASCADE,
  role TEXT NOT NULL,        -- as in the document, and "difference" to the baseline's image
  blob TEXT NOT NULL REFERENCES blobs (hash),
  PRIMARY KEY (frame, role)
) STRICT, WITHOUT ROWID;
CREATE INDEX night_images_by_blob ON night_images (blob);

CREATE TABLE baselines (
  name TEXT PRIMARY KEY,
  night INTEGER NOT NULL REFERENCES nights (id),
  set_utc TEXT NOT NULL
) STRICT;
CREATE INDEX baselines_by_night ON baselines (night);
