-- API keys. Of a key only the hash is kept. A revoked key stays: its name stands in the record, and a service that
-- ever had a key never opens again because the last one went.
CREATE TABLE keys (
    id             TEXT    NOT NULL PRIMARY KEY,
    name           TEXT    NOT NULL,
    -- SHA-256 of the whole key, hex.
    hash           TEXT    NOT NULL,
    scope          TEXT    NOT NULL,
    -- JSON array of name patterns; NULL: every database.
    databases      TEXT,
    requests_per_s INTEGER,
    created_at     INTEGER NOT NULL,
    last_used_at   INTEGER,
    revoked_at     INTEGER
);

-- Who changed what. Written in the transaction of the change, and never again.
CREATE TABLE audit (
    id         INTEGER PRIMARY KEY AUTOINCREMENT,
    at         INTEGER NOT NULL,
    -- The key that the call came with, and its name; or, without a key, who else it was.
    key        TEXT,
    actor      TEXT    NOT NULL,
    request_id TEXT,
    action     TEXT    NOT NULL,
    database   TEXT,
    -- What of it: an alias, a version's number, an exemplar's id, a key's id …
    subject    TEXT,
    -- JSON.
    detail     TEXT    NOT NULL
);

CREATE INDEX audit_by_database ON audit (database, id);
CREATE INDEX audit_by_key ON audit (key, id);

CREATE TRIGGER audit_is_not_rewritten BEFORE UPDATE ON audit
    BEGIN SELECT raise(ABORT, 'the audit record is append-only'); END;
CREATE TRIGGER audit_is_not_shortened BEFORE DELETE ON audit
    BEGIN SELECT raise(ABORT, 'the audit record is append-only'); END;
