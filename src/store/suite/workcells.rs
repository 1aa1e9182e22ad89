//! Workcells: the last writer wins.

use super::{Shared, by};

pub async fn a_workcell_is_replaced_by_who_writes_last(catalogue: Shared) {
    let (first, created) = catalogue.put_workcell("bench", r#"{"a":1}"#, by()).await.unwrap();
    assert!(created);
    assert_eq!((first.name.as_str(), first.document.as_str()), ("bench", r#"{"a":1}"#));
    assert_eq!(first.created_at, first.updated_at);
    let (second, created) = catalogue.put_workcell("bench", r#"{"a":2}"#, by()).await.unwrap();
    assert!(!created);
    assert_eq!((second.document.as_str(), second.created_at), (r#"{"a":2}"#, first.created_at));
    assert!(second.updated_at >= first.updated_at);
    assert_eq!(catalogue.workcell("bench").await.unwrap(), Some(second));
    assert_eq!(catalogue.workcell("other").await.unwrap(), None);

    assert!(catalogue.delete_workcell("bench", by()).await.unwrap());
    assert!(!catalogue.delete_workcell("bench", by()).await.unwrap());
    assert_eq!(catalogue.workcell("bench").await.unwrap(), None);
}

pub async fn workcells_come_in_pages_by_name(catalogue: Shared) {
    for name in ["c", "a", "b"] {
        catalogue.put_workcell(name, "{}", by()).await.unwrap();
    }
    let names = async |after, limit| -> Vec<String> {
        catalogue.workcells(after, limit).await.unwrap().into_iter().map(|row| row.name).collect()
    };
    assert_eq!(names(None, 2).await, ["a", "b"]);
    assert_eq!(names(Some("b"), 2).await, ["c"]);
}
