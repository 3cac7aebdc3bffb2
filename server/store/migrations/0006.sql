-- Version 6: large blobs may have their bytes in a file of their own, beside the store and by their hash.

ALTER TABLE blobs ADD COLUMN outside INTEGER;  -- bytes of that file; NULL: they are in `bytes`, which is empty otherwise

CREATE TABLE settings (
  name TEXT PRIMARY KEY,     -- "large_blob_bytes": blobs from this size on are stored outside; none is when it is absent
  value INTEGER NOT NULL
) STRICT, WITHOUT ROWID;

-- Of a capture over all nights, whose trends are asked for: without it every cell of every night was looked at.
CREATE INDEX night_captures_by_name ON night_captures (name, night);
