//! Jobs: claimed once, leased, ended once, recorded as events.

use std::collections::HashSet;

use futures_util::future::join_all;
use uuid::Uuid;

use super::{LEASE, NO_LEASE, Shared, TRAINING, artifact, by, lab, numbers};
use crate::store::{AliasExpectation, CatalogueError, JobFilter, JobState, Progress, Renewal};

pub async fn eight_workers_claim_two_hundred_jobs_once_each(catalogue: Shared) {
    lab(&catalogue).await;
    let mut queued = HashSet::new();
    for _ in 0..200 {
        queued.insert(catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap().id);
    }
    let tasks = (0..8).map(|worker| {
        let catalogue = catalogue.clone();
        tokio::spawn(async move {
            let owner = format!("worker {worker}");
            let mut claimed = Vec::new();
            while let Some(job) = catalogue.claim_job(&owner, TRAINING, LEASE, 3).await.unwrap() {
                assert_eq!((job.token, job.attempts, job.owner.as_deref()), (1, 1, Some(owner.as_str())));
                claimed.push(job.id);
            }
            claimed
        })
    });
    let claimed: Vec<Uuid> = join_all(tasks).await.into_iter().flat_map(Result::unwrap).collect();
    assert_eq!(claimed.len(), 200);
    assert_eq!(claimed.into_iter().collect::<HashSet<_>>(), queued);
}

pub async fn the_oldest_waiting_job_of_a_kind_is_claimed_first(catalogue: Shared) {
    let unknown = catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap_err();
    assert!(matches!(unknown, CatalogueError::NotFound { .. }), "{unknown:?}");
    lab(&catalogue).await;
    let sweep = catalogue.enqueue_job("sweep", "lab", r#"{"n":0}"#, by()).await.unwrap();
    let first = catalogue.enqueue_job("training", "lab", r#"{"n":1}"#, by()).await.unwrap();
    let second = catalogue.enqueue_job("training", "lab", r#"{"n":2}"#, by()).await.unwrap();
    assert_eq!((first.state, first.token, first.attempts), (JobState::Queued, 0, 0));

    let claim = async |kinds: &[&str]| {
        catalogue.claim_job("w", kinds, LEASE, 3).await.unwrap().map(|job| (job.id, job.params))
    };
    assert_eq!(claim(&[]).await, None);
    assert_eq!(claim(TRAINING).await, Some((first.id, r#"{"n":1}"#.to_owned())));
    assert_eq!(claim(TRAINING).await, Some((second.id, r#"{"n":2}"#.to_owned())));
    assert_eq!(claim(TRAINING).await, None);
    assert_eq!(claim(&["training", "sweep"]).await, Some((sweep.id, r#"{"n":0}"#.to_owned())));
}

pub async fn a_worker_that_lost_its_lease_can_finish_nothing(catalogue: Shared) {
    lab(&catalogue).await;
    let id = catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap().id;
    let slow = catalogue.claim_job("slow", TRAINING, NO_LEASE, 3).await.unwrap().unwrap();
    let quick = catalogue.claim_job("quick", TRAINING, LEASE, 3).await.unwrap().unwrap();
    assert_eq!((slow.id, quick.id), (id, id));
    assert_eq!((slow.token, quick.token, quick.attempts), (1, 2, 2));
    assert_eq!(quick.started_at, slow.started_at);
    let before = catalogue.job_events(id, 0).await.unwrap();

    let new = artifact("lab", "stale");
    let progress = Progress { stage: "eigen".to_owned(), done: 1, total: 2 };
    let lost = [
        catalogue.renew_job(id, slow.token, LEASE, Some(&progress)).await.map(drop),
        catalogue.publish(id, slow.token, &new, Some("current"), None).await.map(drop),
        catalogue.succeed_job(id, slow.token, None, None, None).await.map(drop),
        catalogue.fail_job(id, slow.token, "{}").await.map(drop),
        catalogue.cancelled_job(id, slow.token).await.map(drop),
    ];
    for result in lost {
        assert!(matches!(result, Err(CatalogueError::LeaseLost)), "{result:?}");
    }
    assert_eq!(catalogue.job(id).await.unwrap(), Some(quick.clone()));
    assert_eq!(catalogue.job_events(id, 0).await.unwrap(), before);
    assert_eq!(numbers(&catalogue).await, [0; 0]);
    assert_eq!(catalogue.aliases("lab").await.unwrap(), []);

    // The holder finishes; after that its token is worth nothing either.
    catalogue.publish(id, quick.token, &artifact("lab", "fresh"), None, None).await.unwrap();
    let late = catalogue.fail_job(id, quick.token, "{}").await.unwrap_err();
    assert!(matches!(late, CatalogueError::LeaseLost), "{late:?}");
    assert_eq!(catalogue.job(id).await.unwrap().unwrap().state, JobState::Succeeded);
}

pub async fn a_job_that_never_finishes_fails_with_the_reason(catalogue: Shared) {
    lab(&catalogue).await;
    let id = catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap().id;
    let next = catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap().id;
    for attempt in 1..=2 {
        let job = catalogue.claim_job("w", TRAINING, NO_LEASE, 2).await.unwrap().unwrap();
        assert_eq!((job.id, job.attempts), (id, attempt));
    }
    // The exhausted job doesn't stand in the way of the next one.
    assert_eq!(catalogue.claim_job("w", TRAINING, LEASE, 2).await.unwrap().unwrap().id, next);
    let job = catalogue.job(id).await.unwrap().unwrap();
    assert_eq!((job.state, job.attempts, job.lease_until), (JobState::Failed, 2, None));
    assert!(job.finished_at.is_some());
    let problem: serde_json::Value = serde_json::from_str(&job.problem.unwrap()).unwrap();
    assert_eq!(problem["code"], "attempts_exhausted");
    assert!(problem["detail"].as_str().unwrap().contains("2 times"), "{problem}");
}

pub async fn a_queued_job_is_cancelled_at_once_and_a_running_one_is_flagged(catalogue: Shared) {
    lab(&catalogue).await;
    assert_eq!(catalogue.request_cancel(Uuid::from_u128(1), by()).await.unwrap(), None);

    let queued = catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap().id;
    let cancelled = catalogue.request_cancel(queued, by()).await.unwrap().unwrap();
    assert_eq!(cancelled.state, JobState::Cancelled);
    assert!(cancelled.finished_at.is_some());
    assert_eq!(catalogue.request_cancel(queued, by()).await.unwrap(), Some(cancelled));

    let id = catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap().id;
    let job = catalogue.claim_job("w", TRAINING, LEASE, 3).await.unwrap().unwrap();
    assert_eq!(job.id, id);
    let renew = async || catalogue.renew_job(id, job.token, LEASE, None).await.unwrap();
    assert_eq!(renew().await, Renewal { cancel_requested: false });
    let flagged = catalogue.request_cancel(id, by()).await.unwrap().unwrap();
    assert_eq!((flagged.state, flagged.cancel_requested), (JobState::Running, true));
    assert_eq!(renew().await, Renewal { cancel_requested: true });
    let cancelled = catalogue.cancelled_job(id, job.token).await.unwrap();
    assert_eq!((cancelled.state, cancelled.problem), (JobState::Cancelled, None));
}

pub async fn a_cancelled_job_of_a_dead_worker_is_not_taken_up_again(catalogue: Shared) {
    lab(&catalogue).await;
    let id = catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap().id;
    catalogue.claim_job("dead", TRAINING, NO_LEASE, 3).await.unwrap().unwrap();
    catalogue.request_cancel(id, by()).await.unwrap();
    assert_eq!(catalogue.claim_job("w", TRAINING, LEASE, 3).await.unwrap(), None);
    assert_eq!(catalogue.job(id).await.unwrap().unwrap().state, JobState::Cancelled);
}

pub async fn publishing_moves_version_alias_and_job_together(catalogue: Shared) {
    lab(&catalogue).await;
    catalogue.insert_version(&artifact("lab", "d1"), by()).await.unwrap();
    catalogue.set_alias("lab", "current", 1, AliasExpectation::Any, by()).await.unwrap();
    let id = catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap().id;
    let job = catalogue.claim_job("w", TRAINING, LEASE, 3).await.unwrap().unwrap();
    let version =
        catalogue.publish(id, job.token, &artifact("lab", "d2"), Some("current"), None).await.unwrap();
    assert_eq!(version.version, 2);
    let aliases = catalogue.aliases("lab").await.unwrap();
    assert_eq!(aliases.iter().map(|row| row.version).collect::<Vec<_>>(), [2]);
    let done = catalogue.job(id).await.unwrap().unwrap();
    assert_eq!((done.state, done.version, done.lease_until), (JobState::Succeeded, Some(2), None));
    assert!(done.finished_at >= done.started_at);

    // Not promoted: the alias stays, and what came of comparing is kept with the job and its last event.
    for version in [None, Some(1)] {
        catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap();
        let job = catalogue.claim_job("w", TRAINING, LEASE, 3).await.unwrap().unwrap();
        let compared = Some(r#"{"trials":7}"#);
        match version {
            None => {
                catalogue.publish(job.id, job.token, &artifact("lab", "d3"), None, compared).await.map(drop)
            }
            found => catalogue.succeed_job(job.id, job.token, found, None, compared).await.map(drop),
        }
        .unwrap();
        assert_eq!(catalogue.aliases("lab").await.unwrap(), aliases);
        let job = catalogue.job(job.id).await.unwrap().unwrap();
        assert_eq!(job.comparison.as_deref(), compared);
        assert_eq!(catalogue.job_events(job.id, 0).await.unwrap().pop().unwrap().body, job);
    }
}

pub async fn a_version_published_early_stays_whatever_becomes_of_its_job(catalogue: Shared) {
    lab(&catalogue).await;
    let compared = Some(r#"{"trials":7}"#);
    for (number, digest) in [(1, "d1"), (2, "d2"), (3, "d3")] {
        let id = catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap().id;
        let job = catalogue.claim_job("w", TRAINING, LEASE, 3).await.unwrap().unwrap();
        let new = artifact("lab", digest);
        let published =
            catalogue.publish_early(id, job.token, &new, Some("current"), compared).await.unwrap();
        assert_eq!(published.version, number);
        let running = catalogue.job(id).await.unwrap().unwrap();
        assert_eq!((running.state, running.version), (JobState::Running, Some(number)));
        assert_eq!(catalogue.aliases("lab").await.unwrap()[0].version, number);
        let ended = match number {
            1 => catalogue.succeed_with_report(id, job.token, "lab", 1, r#"{"verdict":{}}"#).await,
            2 => catalogue.fail_job(id, job.token, "{}").await,
            _ => catalogue.cancelled_job(id, job.token).await,
        };
        let ended = ended.unwrap();
        assert_eq!((ended.version, ended.comparison.as_deref()), (Some(number), compared));
        let late = catalogue.succeed_with_report(id, job.token, "lab", number, "{}").await.unwrap_err();
        assert!(matches!(late, CatalogueError::LeaseLost), "{late:?}");
    }
    let report = async |version| catalogue.version("lab", version).await.unwrap().unwrap().report;
    assert_eq!(report(1).await, r#"{"verdict":{}}"#);
    assert_eq!(report(2).await, "{}");
}

pub async fn a_publish_that_fails_changes_nothing(catalogue: Shared) {
    lab(&catalogue).await;
    let id = catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap().id;
    let job = catalogue.claim_job("w", TRAINING, LEASE, 3).await.unwrap().unwrap();
    let refused =
        catalogue.publish(id, job.token, &artifact("gone", "d1"), Some("current"), None).await.unwrap_err();
    assert!(matches!(refused, CatalogueError::NotFound { .. }), "{refused:?}");
    // Here the job's end was already written when the version turned out to be missing.
    let refused = catalogue.succeed_job(id, job.token, Some(9), Some("current"), None).await.unwrap_err();
    assert!(matches!(refused, CatalogueError::NotFound { .. }), "{refused:?}");
    assert_eq!(catalogue.job(id).await.unwrap(), Some(job.clone()));
    assert_eq!(catalogue.job_events(id, 0).await.unwrap().len(), 2);
    // The lease is still good.
    assert_eq!(
        catalogue.publish(id, job.token, &artifact("lab", "d1"), None, None).await.unwrap().version,
        1
    );
}

pub async fn concurrent_publishes_of_one_digest_give_one_version(catalogue: Shared) {
    lab(&catalogue).await;
    let mut jobs = Vec::new();
    for _ in 0..4 {
        catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap();
        jobs.push(catalogue.claim_job("w", TRAINING, LEASE, 3).await.unwrap().unwrap());
    }
    let tasks = jobs.iter().map(|job| {
        let (catalogue, id, token) = (catalogue.clone(), job.id, job.token);
        tokio::spawn(async move {
            catalogue.publish(id, token, &artifact("lab", "same"), Some("current"), None).await
        })
    });
    for published in join_all(tasks).await {
        assert_eq!(published.unwrap().unwrap().version, 1);
    }
    assert_eq!(numbers(&catalogue).await, [1]);
    for job in jobs {
        let job = catalogue.job(job.id).await.unwrap().unwrap();
        assert_eq!((job.state, job.version), (JobState::Succeeded, Some(1)));
    }
}

pub async fn a_job_succeeds_with_a_version_that_was_there(catalogue: Shared) {
    lab(&catalogue).await;
    catalogue.insert_version(&artifact("lab", "d1"), by()).await.unwrap();
    catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap();
    let job = catalogue.claim_job("w", TRAINING, LEASE, 3).await.unwrap().unwrap();
    let done = catalogue.succeed_job(job.id, job.token, Some(1), Some("current"), None).await.unwrap();
    assert_eq!((done.state, done.version), (JobState::Succeeded, Some(1)));
    assert_eq!(catalogue.job(job.id).await.unwrap(), Some(done));
    assert_eq!(catalogue.aliases("lab").await.unwrap()[0].version, 1);
}

pub async fn a_job_handed_back_loses_no_attempt(catalogue: Shared) {
    lab(&catalogue).await;
    let back = catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap().id;
    let ended = catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap().id;
    let others = catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap().id;
    let job = catalogue.claim_job("leaving", TRAINING, LEASE, 1).await.unwrap().unwrap();
    catalogue.claim_job("leaving", TRAINING, LEASE, 1).await.unwrap().unwrap();
    catalogue.claim_job("staying", TRAINING, LEASE, 1).await.unwrap().unwrap();
    catalogue.request_cancel(ended, by()).await.unwrap();

    assert_eq!(catalogue.hand_back_jobs("leaving").await.unwrap(), 2);
    assert_eq!(catalogue.hand_back_jobs("leaving").await.unwrap(), 0);

    let waiting = catalogue.job(back).await.unwrap().unwrap();
    assert_eq!((waiting.state, waiting.attempts, waiting.owner), (JobState::Queued, 0, None));
    assert_eq!(catalogue.job(ended).await.unwrap().unwrap().state, JobState::Cancelled);
    assert_eq!(catalogue.job(others).await.unwrap().unwrap().state, JobState::Running);
    let late = catalogue.fail_job(back, job.token, "{}").await.unwrap_err();
    assert!(matches!(late, CatalogueError::LeaseLost), "{late:?}");

    // One attempt is allowed, and it is still to be had.
    let again = catalogue.claim_job("next", TRAINING, LEASE, 1).await.unwrap().unwrap();
    assert_eq!((again.id, again.attempts, again.token), (back, 1, 2));
}

pub async fn the_leases_of_dead_owners_end_now(catalogue: Shared) {
    lab(&catalogue).await;
    let dead = catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap().id;
    catalogue.claim_job("dead", TRAINING, LEASE, 3).await.unwrap().unwrap();
    let ours = catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap().id;
    let held = catalogue.claim_job("us", TRAINING, LEASE, 3).await.unwrap().unwrap();
    assert_eq!(held.id, ours);
    assert_eq!(catalogue.claim_job("us", TRAINING, LEASE, 3).await.unwrap(), None);

    assert_eq!(catalogue.release_dead_leases("us").await.unwrap(), 1);
    let taken = catalogue.claim_job("us", TRAINING, LEASE, 3).await.unwrap().unwrap();
    assert_eq!((taken.id, taken.attempts, taken.token), (dead, 2, 2));
    assert_eq!(catalogue.claim_job("us", TRAINING, LEASE, 3).await.unwrap(), None);
    assert_eq!(catalogue.job(ours).await.unwrap(), Some(held));
}

pub async fn every_change_of_state_or_progress_is_an_event(catalogue: Shared) {
    lab(&catalogue).await;
    let id = catalogue.enqueue_job("training", "lab", r#"{"top":1}"#, by()).await.unwrap().id;
    let job = catalogue.claim_job("w", TRAINING, LEASE, 3).await.unwrap().unwrap();
    let step = |done| Progress { stage: "signatures".to_owned(), done, total: 2 };
    for progress in [Some(step(1)), Some(step(1)), None, Some(step(2))] {
        let renewed_from = catalogue.job(id).await.unwrap().unwrap().lease_until;
        catalogue.renew_job(id, job.token, LEASE, progress.as_ref()).await.unwrap();
        assert!(catalogue.job(id).await.unwrap().unwrap().lease_until > renewed_from);
    }
    let published = catalogue.publish(id, job.token, &artifact("lab", "d1"), None, None).await.unwrap();

    let events = catalogue.job_events(id, 0).await.unwrap();
    let recorded: Vec<_> = events
        .iter()
        .map(|event| {
            let done = event.body.progress.as_ref().map(|progress| progress.done);
            (event.sequence, event.body.state, done, event.body.version)
        })
        .collect();
    assert_eq!(
        recorded,
        [
            (1, JobState::Queued, None, None),
            (2, JobState::Running, None, None),
            (3, JobState::Running, Some(1), None),
            (4, JobState::Running, Some(2), None),
            (5, JobState::Succeeded, Some(2), Some(published.version)),
        ]
    );
    assert_eq!(events[1].body, job);
    assert_eq!(Some(&events[4].body), catalogue.job(id).await.unwrap().as_ref());
    assert!(events.iter().all(|event| event.job == id && event.body.params == r#"{"top":1}"#));
    assert_eq!(catalogue.job_events(id, 3).await.unwrap(), events[3..]);
    assert_eq!(catalogue.job_events(Uuid::from_u128(1), 0).await.unwrap(), []);
}

pub async fn jobs_come_newest_first_and_are_counted_by_state(catalogue: Shared) {
    lab(&catalogue).await;
    catalogue.create_database("other", "landmarks", "{}", by()).await.unwrap();
    let mut ids = Vec::new();
    for database in ["lab", "other", "lab", "lab"] {
        ids.push(catalogue.enqueue_job("training", database, "{}", by()).await.unwrap().id);
    }
    let claimed = catalogue.claim_job("w", TRAINING, LEASE, 3).await.unwrap().unwrap();
    assert_eq!(claimed.id, ids[0]);

    let list = async |database: Option<&str>, state, after, limit| {
        let filter = JobFilter { database: database.map(str::to_owned), calibration: None, state };
        catalogue.jobs(&filter, after, limit).await.unwrap().iter().map(|job| job.id).collect::<Vec<_>>()
    };
    assert_eq!(list(None, None, None, 3).await, [ids[3], ids[2], ids[1]]);
    assert_eq!(list(None, None, Some(ids[1]), 3).await, [ids[0]]);
    assert_eq!(list(Some("lab"), None, None, 9).await, [ids[3], ids[2], ids[0]]);
    assert_eq!(list(Some("lab"), Some(JobState::Queued), None, 9).await, [ids[3], ids[2]]);
    assert!(list(None, Some(JobState::Failed), None, 9).await.is_empty());
    assert_eq!(catalogue.jobs_by_state().await.unwrap(), [(JobState::Queued, 3), (JobState::Running, 1)]);
}
