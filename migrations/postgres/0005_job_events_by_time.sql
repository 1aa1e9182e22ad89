-- For those who follow all jobs.
CREATE INDEX job_events_by_time ON job_events (at);
