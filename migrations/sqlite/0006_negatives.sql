-- Exemplars that show nothing known: 1, and the label is empty.
ALTER TABLE exemplars ADD COLUMN negative INTEGER NOT NULL DEFAULT 0;
