-- Version 3: how runs share the workers.

ALTER TABLE runs ADD COLUMN priority INTEGER NOT NULL DEFAULT 5;   -- 0 to 9, the highest first
ALTER TABLE runs ADD COLUMN submitter TEXT NOT NULL DEFAULT '';    -- whose it is: among equal ones they take turns
ALTER TABLE runs ADD COLUMN retries INTEGER NOT NULL DEFAULT 2;    -- further starts in a row without a new result

-- When each submitter was last served: a number that counts starts.
CREATE TABLE submitters (
  name TEXT PRIMARY KEY,
  last_turn INTEGER NOT NULL
) STRICT, WITHOUT ROWID;
