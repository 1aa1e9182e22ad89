-- Where an exemplar was taken, with which camera, and how large it is: JSON, or NULL.
ALTER TABLE exemplars ADD COLUMN survey TEXT;

-- Intrinsics of cameras: their document is JSON.
CREATE TABLE cameras (
    name       TEXT COLLATE "C" NOT NULL PRIMARY KEY,
    document   TEXT             NOT NULL,
    created_at BIGINT           NOT NULL,
    updated_at BIGINT           NOT NULL
);
