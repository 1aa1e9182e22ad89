-- What is known of a workcell: its document is JSON. Who writes last wins.
CREATE TABLE workcells (
    name       TEXT    NOT NULL PRIMARY KEY,
    document   TEXT    NOT NULL,
    created_at INTEGER NOT NULL,
    updated_at INTEGER NOT NULL
) STRICT, WITHOUT ROWID;
