-- What is known of a rig: its document is JSON. The last revision given out stands by itself: none is ever given
-- again, not even after a deletion.
CREATE TABLE calibrations (
    name       TEXT    NOT NULL PRIMARY KEY,
    document   TEXT    NOT NULL,
    revision   INTEGER NOT NULL,
    created_at INTEGER NOT NULL,
    updated_at INTEGER NOT NULL
) STRICT, WITHOUT ROWID;

CREATE TABLE last_calibration_revision (
    revision INTEGER NOT NULL
) STRICT;

INSERT INTO last_calibration_revision (revision) VALUES (0);

-- A job is about a database or about a calibration; the other name is empty: '' in `database`, NULL in `calibration`.
ALTER TABLE jobs ADD COLUMN calibration TEXT;

CREATE INDEX jobs_by_calibration ON jobs (calibration, id);

-- Blobs that a job reads. They are kept until it has ended.
CREATE TABLE job_blobs (
    job  TEXT NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
    blob TEXT NOT NULL,
    PRIMARY KEY (job, blob)
) STRICT, WITHOUT ROWID;

CREATE INDEX job_blobs_by_blob ON job_blobs (blob);
