-- Times are microseconds since 1970-01-01 UTC. Ids are UUIDs in their hyphenated lower-case form, whose text
-- order is their byte order. `options`, `counts`, `report`, `params` and `problem` hold JSON.

CREATE TABLE databases (
    name          TEXT    NOT NULL PRIMARY KEY,
    kind          TEXT    NOT NULL,
    options       TEXT    NOT NULL,
    -- The last number and the last revision given out: neither is ever given again.
    last_version  INTEGER NOT NULL DEFAULT 0,
    last_revision INTEGER NOT NULL DEFAULT 0,
    created_at    INTEGER NOT NULL
) STRICT, WITHOUT ROWID;

CREATE TABLE exemplars (
    database   TEXT    NOT NULL REFERENCES databases (name) ON DELETE CASCADE,
    id         TEXT    NOT NULL,
    label      TEXT    NOT NULL,
    pose_deg   REAL,
    width_px   INTEGER NOT NULL,
    height_px  INTEGER NOT NULL,
    bytes      INTEGER NOT NULL,
    sha256     TEXT    NOT NULL,
    blob       TEXT    NOT NULL,
    media_type TEXT    NOT NULL,
    robot_id   TEXT,
    frame_id   TEXT,
    stamp      TEXT,
    created_at INTEGER NOT NULL,
    PRIMARY KEY (database, id)
) STRICT, WITHOUT ROWID;

CREATE INDEX exemplars_by_label ON exemplars (database, label, id);
CREATE INDEX exemplars_by_blob ON exemplars (blob);

CREATE TABLE versions (
    database           TEXT    NOT NULL REFERENCES databases (name) ON DELETE CASCADE,
    version            INTEGER NOT NULL,
    digest             TEXT    NOT NULL,
    blob               TEXT    NOT NULL,
    bytes              INTEGER NOT NULL,
    kind               TEXT    NOT NULL,
    algorithm_revision INTEGER NOT NULL,
    options            TEXT    NOT NULL,
    counts             TEXT    NOT NULL,
    report             TEXT    NOT NULL,
    created_at         INTEGER NOT NULL,
    PRIMARY KEY (database, version),
    UNIQUE (database, digest)
) STRICT, WITHOUT ROWID;

CREATE INDEX versions_by_blob ON versions (blob);

CREATE TABLE aliases (
    database   TEXT    NOT NULL REFERENCES databases (name) ON DELETE CASCADE,
    alias      TEXT    NOT NULL,
    version    INTEGER NOT NULL,
    revision   INTEGER NOT NULL,
    updated_at INTEGER NOT NULL,
    PRIMARY KEY (database, alias),
    -- Checked at the end of a statement, so that deleting a database may delete its versions first.
    FOREIGN KEY (database, version) REFERENCES versions (database, version)
) STRICT, WITHOUT ROWID;

CREATE INDEX aliases_by_version ON aliases (database, version);

-- A job names its database without referring to it: the history outlives the database.
CREATE TABLE jobs (
    id               TEXT    NOT NULL PRIMARY KEY,
    kind             TEXT    NOT NULL,
    database         TEXT    NOT NULL,
    params           TEXT    NOT NULL,
    state            TEXT    NOT NULL CHECK (state IN ('queued', 'running', 'succeeded', 'failed', 'cancelled')),
    progress_stage   TEXT,
    progress_done    INTEGER,
    progress_total   INTEGER,
    token            INTEGER NOT NULL DEFAULT 0,
    owner            TEXT,
    lease_until      INTEGER,
    cancel_requested INTEGER NOT NULL DEFAULT 0,
    attempts         INTEGER NOT NULL DEFAULT 0,
    version          INTEGER,
    problem          TEXT,
    created_at       INTEGER NOT NULL,
    started_at       INTEGER,
    finished_at      INTEGER
) STRICT, WITHOUT ROWID;

CREATE INDEX jobs_by_state ON jobs (state, id);
CREATE INDEX jobs_by_database ON jobs (database, id);

-- The changing columns of a job as they were after each change; the others are read from the job.
CREATE TABLE job_events (
    job              TEXT    NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
    sequence         INTEGER NOT NULL,
    at               INTEGER NOT NULL,
    state            TEXT    NOT NULL,
    progress_stage   TEXT,
    progress_done    INTEGER,
    progress_total   INTEGER,
    token            INTEGER NOT NULL,
    owner            TEXT,
    lease_until      INTEGER,
    cancel_requested INTEGER NOT NULL,
    attempts         INTEGER NOT NULL,
    version          INTEGER,
    problem          TEXT,
    started_at       INTEGER,
    finished_at      INTEGER,
    PRIMARY KEY (job, sequence)
) STRICT, WITHOUT ROWID;
