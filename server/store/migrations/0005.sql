-- Version 5: what was measured in a night, and how quiet its machine was.

ALTER TABLE nights ADD COLUMN commit_id TEXT NOT NULL DEFAULT '';  -- of the build or of what it measured; empty: not known
ALTER TABLE nights ADD COLUMN facts TEXT NOT NULL DEFAULT '{}';    -- JSON: noise, load, rounds
