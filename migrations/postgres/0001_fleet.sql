-- Times are microseconds since 1970-01-01 UTC by the database's clock. `options`, `counts`, `report`, `params`,
-- `document`, `problem` and `comparison` hold JSON as text: what was written is read back byte for byte. Text sorts
-- by its bytes, whatever the database's own collation.

-- The moment at which the present statement began: one value for all of the statement.
CREATE FUNCTION now_us() RETURNS BIGINT LANGUAGE SQL STABLE
    AS 'SELECT (extract(epoch FROM statement_timestamp()) * 1000000)::BIGINT';

CREATE TABLE databases (
    name          TEXT COLLATE "C" NOT NULL PRIMARY KEY,
    kind          TEXT             NOT NULL,
    options       TEXT             NOT NULL,
    -- The last number and the last revision given out: neither is ever given again.
    last_version  BIGINT           NOT NULL DEFAULT 0,
    last_revision BIGINT           NOT NULL DEFAULT 0,
    created_at    BIGINT           NOT NULL
);

CREATE TABLE exemplars (
    database   TEXT COLLATE "C" NOT NULL REFERENCES databases (name) ON DELETE CASCADE,
    id         UUID             NOT NULL,
    label      TEXT COLLATE "C" NOT NULL,
    pose_deg   DOUBLE PRECISION,
    width_px   BIGINT           NOT NULL,
    height_px  BIGINT           NOT NULL,
    bytes      BIGINT           NOT NULL,
    sha256     TEXT COLLATE "C" NOT NULL,
    blob       TEXT COLLATE "C" NOT NULL,
    media_type TEXT             NOT NULL,
    robot_id   TEXT COLLATE "C",
    frame_id   TEXT,
    stamp      TEXT,
    created_at BIGINT           NOT NULL,
    PRIMARY KEY (database, id)
);

CREATE INDEX exemplars_by_label ON exemplars (database, label, id);
CREATE INDEX exemplars_by_blob ON exemplars (blob);

CREATE TABLE versions (
    database           TEXT COLLATE "C" NOT NULL REFERENCES databases (name) ON DELETE CASCADE,
    version            BIGINT           NOT NULL,
    digest             TEXT COLLATE "C" NOT NULL,
    blob               TEXT COLLATE "C" NOT NULL,
    bytes              BIGINT           NOT NULL,
    kind               TEXT             NOT NULL,
    algorithm_revision BIGINT           NOT NULL,
    options            TEXT             NOT NULL,
    counts             TEXT             NOT NULL,
    report             TEXT             NOT NULL,
    created_at         BIGINT           NOT NULL,
    PRIMARY KEY (database, version),
    UNIQUE (database, digest)
);

CREATE INDEX versions_by_blob ON versions (blob);

CREATE TABLE aliases (
    database   TEXT COLLATE "C" NOT NULL REFERENCES databases (name) ON DELETE CASCADE,
    alias      TEXT COLLATE "C" NOT NULL,
    version    BIGINT           NOT NULL,
    revision   BIGINT           NOT NULL,
    updated_at BIGINT           NOT NULL,
    PRIMARY KEY (database, alias),
    -- Checked at the end of a statement, so that deleting a database may delete its versions first.
    FOREIGN KEY (database, version) REFERENCES versions (database, version)
);

CREATE INDEX aliases_by_version ON aliases (database, version);

-- What is known of a rig. The last revision given out stands by itself: none is ever given again, not even after a
-- deletion.
CREATE TABLE calibrations (
    name       TEXT COLLATE "C" NOT NULL PRIMARY KEY,
    document   TEXT             NOT NULL,
    revision   BIGINT           NOT NULL,
    created_at BIGINT           NOT NULL,
    updated_at BIGINT           NOT NULL
);

CREATE TABLE last_calibration_revision (
    revision BIGINT NOT NULL
);

INSERT INTO last_calibration_revision (revision) VALUES (0);

-- What is known of a workcell. Who writes last wins.
CREATE TABLE workcells (
    name       TEXT COLLATE "C" NOT NULL PRIMARY KEY,
    document   TEXT             NOT NULL,
    created_at BIGINT           NOT NULL,
    updated_at BIGINT           NOT NULL
);

-- A job is about a database or about a calibration. It names it without referring to it: the history outlives it.
CREATE TABLE jobs (
    id               UUID    NOT NULL PRIMARY KEY,
    kind             TEXT    NOT NULL,
    database         TEXT COLLATE "C",
    calibration      TEXT COLLATE "C",
    params           TEXT    NOT NULL,
    state            TEXT    COLLATE "C" NOT NULL
                             CHECK (state IN ('queued', 'running', 'succeeded', 'failed', 'cancelled')),
    progress_stage   TEXT,
    progress_done    BIGINT,
    progress_total   BIGINT,
    token            BIGINT  NOT NULL DEFAULT 0,
    owner            TEXT    COLLATE "C",
    lease_until      BIGINT,
    cancel_requested BOOLEAN NOT NULL DEFAULT FALSE,
    attempts         BIGINT  NOT NULL DEFAULT 0,
    version          BIGINT,
    problem          TEXT,
    -- How a training's version did beside the one in use; NULL where nothing was asked for.
    comparison       TEXT,
    created_at       BIGINT  NOT NULL,
    started_at       BIGINT,
    finished_at      BIGINT,
    CHECK (num_nonnulls(database, calibration) = 1)
);

-- What a claim walks along: never the history.
CREATE INDEX jobs_unfinished ON jobs (id) WHERE state IN ('queued', 'running');
CREATE INDEX jobs_by_state ON jobs (state, id);
CREATE INDEX jobs_by_database ON jobs (database, id);
CREATE INDEX jobs_by_calibration ON jobs (calibration, id);

-- The changing columns of a job as they were after each change; the others are read from the job.
CREATE TABLE job_events (
    job              UUID    NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
    sequence         BIGINT  NOT NULL,
    at               BIGINT  NOT NULL,
    state            TEXT    NOT NULL,
    progress_stage   TEXT,
    progress_done    BIGINT,
    progress_total   BIGINT,
    token            BIGINT  NOT NULL,
    owner            TEXT,
    lease_until      BIGINT,
    cancel_requested BOOLEAN NOT NULL,
    attempts         BIGINT  NOT NULL,
    version          BIGINT,
    problem          TEXT,
    comparison       TEXT,
    started_at       BIGINT,
    finished_at      BIGINT,
    PRIMARY KEY (job, sequence)
);

-- Blobs that a job reads. They are kept until it has ended.
CREATE TABLE job_blobs (
    job  UUID             NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
    blob TEXT COLLATE "C" NOT NULL,
    PRIMARY KEY (job, blob)
);

CREATE INDEX job_blobs_by_blob ON job_blobs (blob);

-- What each process told of itself last; who is silent for a day is forgotten.
CREATE TABLE processes (
    worker     TEXT COLLATE "C" NOT NULL PRIMARY KEY,
    role       TEXT             NOT NULL,
    serving    TEXT             NOT NULL,
    started_at BIGINT           NOT NULL,
    seen_at    BIGINT           NOT NULL
);

-- Which catalogue this is: its bucket is marked with it, so that no other catalogue takes its blobs for orphans.
CREATE TABLE identity (
    id UUID NOT NULL
);

INSERT INTO identity (id) VALUES (gen_random_uuid());
