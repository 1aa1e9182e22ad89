-- Exemplars that show nothing known: their label is empty.
ALTER TABLE exemplars ADD COLUMN negative BOOLEAN NOT NULL DEFAULT FALSE;
