-- How a training's version did beside the one in use, as JSON; NULL where nothing was asked for.
ALTER TABLE jobs ADD COLUMN comparison TEXT;
ALTER TABLE job_events ADD COLUMN comparison TEXT;
