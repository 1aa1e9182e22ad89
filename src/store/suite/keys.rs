//! Keys, and the record of who changed what.

use serde_json::Value;

use super::{Shared, artifact, by, exemplar, lab, label};
use crate::store::{Actor, AliasExpectation, AuditFilter, NewKey};

fn key(id: &str) -> NewKey {
    NewKey {
        id: id.to_owned(),
        name: "robot 7".to_owned(),
        hash: format!("{id:0>64}"),
        scope: "contribute".to_owned(),
        databases: Some(r#"["floor-*"]"#.to_owned()),
        requests_per_s: Some(30),
    }
}

pub async fn a_key_is_kept_and_ends_once(catalogue: Shared) {
    let made = catalogue.insert_key(&key("a"), by()).await.unwrap();
    catalogue.insert_key(&NewKey { databases: None, requests_per_s: None, ..key("b") }, by()).await.unwrap();
    assert_eq!((made.name.as_str(), made.scope.as_str()), ("robot 7", "contribute"));
    assert_eq!((made.last_used_at, made.revoked_at), (None, None));
    let used = made.created_at;
    catalogue.record_key_uses(&[("a".to_owned(), used), ("nobody".to_owned(), used)]).await.unwrap();
    // An older use is no news.
    let older = jiff::Timestamp::from_microsecond(used.as_microsecond() - 5).unwrap();
    catalogue.record_key_uses(&[("a".to_owned(), older)]).await.unwrap();
    assert_eq!(catalogue.revoke_key("b", by()).await.unwrap(), Some(true));
    assert_eq!(catalogue.revoke_key("b", by()).await.unwrap(), Some(false));
    assert_eq!(catalogue.revoke_key("c", by()).await.unwrap(), None);
    let keys = catalogue.keys().await.unwrap();
    assert_eq!(keys.iter().map(|key| key.id.as_str()).collect::<Vec<_>>(), ["a", "b"]);
    assert_eq!((keys[0].last_used_at, keys[0].revoked_at), (Some(used), None));
    assert_eq!((&keys[0].databases, keys[0].requests_per_s), (&key("a").databases, Some(30)));
    assert!(keys[1].revoked_at.is_some() && keys[1].databases.is_none());
    let mut record = catalogue.audit(&AuditFilter::default(), None, 9).await.unwrap();
    record.reverse();
    let recorded: Vec<_> = record.iter().map(|row| (row.action.as_str(), row.subject.as_deref())).collect();
    let [a, b] = ["a", "b"].map(Some);
    assert_eq!(recorded, [("key.create", a), ("key.create", b), ("key.revoke", b)]);
    assert!(record.iter().all(|row| !row.detail.contains(&key("a").hash)), "the record holds no hash");
}

pub async fn a_change_and_its_entry_are_one_transaction(catalogue: Shared) {
    let robot = Actor { key: Some("k1".into()), name: "robot 7".into(), request_id: Some("r-1".into()) };
    lab(&catalogue).await;
    catalogue.insert_exemplar(&exemplar("lab", 1, "cup")).await.unwrap();
    catalogue.insert_version(&artifact("lab", "d1"), by()).await.unwrap();
    catalogue.set_alias("lab", "current", 1, AliasExpectation::Any, &robot).await.unwrap();
    // What changes nothing, or fails, leaves no entry.
    lab(&catalogue).await;
    catalogue.set_alias("lab", "current", 7, AliasExpectation::Any, &robot).await.unwrap_err();
    catalogue.delete_version("lab", 1, &robot).await.unwrap_err();
    assert_eq!(catalogue.delete_exemplars("lab", &label("can"), &robot).await.unwrap(), 0);
    assert!(!catalogue.delete_database("hall", &robot).await.unwrap());
    assert_eq!(catalogue.delete_exemplars("lab", &label("cup"), &robot).await.unwrap(), 1);
    let job = catalogue.enqueue_job("training", "lab", "{}", &robot).await.unwrap();
    let claimed = catalogue.claim_job("w", &["training"], super::LEASE, 3).await.unwrap().unwrap();
    let new = artifact("lab", "d2");
    catalogue.publish(job.id, claimed.token, &new, Some("current"), None).await.unwrap();
    assert!(catalogue.delete_database("lab", &robot).await.unwrap());

    let every = AuditFilter::default();
    let record = catalogue.audit(&every, None, 100).await.unwrap();
    let recorded: Vec<_> =
        record.iter().rev().map(|row| (row.action.as_str(), row.actor.name.as_str())).collect();
    let worker = format!("job {}", job.id);
    assert_eq!(
        recorded,
        [
            ("database.create", "tester"),
            ("version.import", "tester"),
            ("alias.set", "robot 7"),
            ("exemplar.delete", "robot 7"),
            ("job.queue", "robot 7"),
            ("version.publish", worker.as_str()),
            ("alias.set", worker.as_str()),
            ("database.delete", "robot 7"),
        ]
    );
    assert!(record.iter().all(|row| row.database.as_deref() == Some("lab")));
    assert!(record.is_sorted_by(|newer, older| newer.id > older.id && newer.at >= older.at));
    let deleted = record.iter().find(|row| row.action == "exemplar.delete").unwrap();
    assert_eq!(deleted.actor, robot);
    let detail: Value = serde_json::from_str(&deleted.detail).unwrap();
    assert_eq!((&detail["label"], &detail["deleted"]), (&"cup".into(), &1.into()));

    let ids = async |filter: AuditFilter, before, limit| -> Vec<i64> {
        catalogue.audit(&filter, before, limit).await.unwrap().iter().map(|row| row.id).collect()
    };
    let all = ids(every.clone(), None, 100).await;
    assert_eq!(ids(every.clone(), Some(all[2]), 2).await, all[3..5]);
    assert_eq!(ids(AuditFilter { key: Some("k1".into()), ..every.clone() }, None, 100).await.len(), 4);
    assert_eq!(
        ids(AuditFilter { action: Some("alias.set".into()), ..every.clone() }, None, 9).await.len(),
        2
    );
    assert!(ids(AuditFilter { database: Some("hall".into()), ..every }, None, 9).await.is_empty());
}
