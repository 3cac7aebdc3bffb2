-- Version 4: tokens of those who may call the service; who approved which night as a baseline, when and why.

CREATE TABLE tokens (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  name TEXT NOT NULL,
  -- SHA-256 of the token, which is not stored. It has 256 random bits, so a slow hash would add nothing.
  hash BLOB NOT NULL CHECK (length(hash) = 32),
  rights TEXT NOT NULL CHECK (rights IN ('read', 'submit', 'approve', 'admin')),
  quota_bytes INTEGER,       -- of all captures sent with it; NULL: no limit
  uploaded_bytes INTEGER NOT NULL DEFAULT 0,
  created_utc TEXT NOT NULL,
  expires_utc TEXT,
  revoked_utc TEXT
) STRICT;
CREATE UNIQUE INDEX tokens_by_name ON tokens (name) WHERE revoked_utc IS NULL;

-- Every approval there was; `baselines` has the last one of each name.
CREATE TABLE approvals (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  baseline TEXT NOT NULL,
  night INTEGER NOT NULL,    -- not a reference: the night may be deleted when the name has moved on
  who TEXT NOT NULL,         -- a token's or a user's name; empty: not known
  why TEXT NOT NULL,
  set_utc TEXT NOT NULL
) STRICT;
CREATE INDEX approvals_by_baseline ON approvals (baseline, id);
INSERT INTO approvals (baseline, night, who, why, set_utc) SELECT name, night, '', '', set_utc FROM baselines ORDER BY set_utc;
