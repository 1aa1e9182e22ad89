//! Exemplars: inserted once, filtered, deleted.

use jiff::Timestamp;
use uuid::Uuid;

use super::{Shared, by, exemplar, lab, label, robot};
use crate::store::{CatalogueError, DatabaseCounts, ExemplarFilter, ExemplarRow};

pub async fn an_exemplar_is_inserted_once_and_read_back_whole(catalogue: Shared) {
    let full = ExemplarRow {
        pose_deg: Some(359.75),
        survey: Some(r#"{"size_mm":210.0}"#.to_owned()),
        robot_id: Some("r2".to_owned()),
        frame_id: Some("head".to_owned()),
        stamp: Some("12.000000034".to_owned()),
        ..exemplar("lab", 7, "it's a \"kitchen\"; DROP TABLE exemplars")
    };
    let unknown = catalogue.insert_exemplar(&full).await.unwrap_err();
    assert!(matches!(unknown, CatalogueError::NotFound { .. }), "{unknown:?}");

    lab(&catalogue).await;
    let before = Timestamp::now().as_microsecond();
    let (stored, created) = catalogue.insert_exemplar(&full).await.unwrap();
    assert!(created);
    assert!(stored.created_at.as_microsecond() >= before);
    assert_eq!(stored, ExemplarRow { created_at: stored.created_at, ..full.clone() });
    assert_eq!(catalogue.exemplar("lab", full.id).await.unwrap(), Some(stored.clone()));

    let other = ExemplarRow { label: "hall".to_owned(), ..full.clone() };
    assert_eq!(catalogue.insert_exemplar(&other).await.unwrap(), (stored.clone(), false));
    let without = ExemplarRow { survey: None, ..full.clone() };
    assert_eq!(catalogue.insert_exemplar(&without).await.unwrap(), (stored.clone(), false));
    let before = full.survey.as_deref();
    let change = async |id, from: Option<&str>, to| {
        catalogue.change_exemplar_survey("lab", id, from, to).await.unwrap()
    };
    assert_eq!(change(full.id, None, Some("{}")).await, None, "somebody else has changed it");
    let cleared = change(full.id, before, None).await;
    assert_eq!(cleared, Some(ExemplarRow { survey: None, ..stored }));
    let again = change(full.id, None, before).await.unwrap();
    assert_eq!(again.survey.as_deref(), before);
    assert_eq!(change(Uuid::from_u128(8), None, None).await, None);
    assert_eq!(catalogue.exemplar("lab", Uuid::from_u128(8)).await.unwrap(), None);
}

pub async fn exemplars_are_filtered_and_paged_and_trained_in_one_order(catalogue: Shared) {
    lab(&catalogue).await;
    catalogue.create_database("other", "landmarks", "{}", by()).await.unwrap();
    for (number, label, robot_id) in [(4, "b", "r1"), (1, "b", "r2"), (3, "a", "r1"), (2, "c", "r1")] {
        let row = ExemplarRow { robot_id: Some(robot_id.to_owned()), ..exemplar("lab", number, label) };
        catalogue.insert_exemplar(&row).await.unwrap();
    }
    catalogue.insert_exemplar(&exemplar("other", 5, "b")).await.unwrap();

    let list = async |filter: &ExemplarFilter, after: Option<u128>, limit| {
        let rows = catalogue.exemplars("lab", filter, after.map(Uuid::from_u128), limit).await.unwrap();
        rows.iter().map(|row| row.id.as_u128()).collect::<Vec<_>>()
    };
    assert_eq!(list(&ExemplarFilter::default(), None, 3).await, [1, 2, 3]);
    assert_eq!(list(&ExemplarFilter::default(), Some(3), 3).await, [4]);
    assert_eq!(list(&label("b"), None, 9).await, [1, 4]);
    assert_eq!(list(&robot("r1"), None, 9).await, [2, 3, 4]);
    let both = ExemplarFilter { robot_id: robot("r1").robot_id, ..label("b") };
    assert_eq!(list(&both, None, 9).await, [4]);

    let trained = catalogue.training_set("lab").await.unwrap();
    let trained: Vec<_> = trained.iter().map(|row| (row.label.as_str(), row.id.as_u128())).collect();
    assert_eq!(trained, [("a", 3), ("b", 1), ("b", 4), ("c", 2)]);
    let counts = catalogue.database_counts("lab").await.unwrap();
    assert_eq!(counts, DatabaseCounts { exemplars: 4, labels: 3, versions: 0 });
}

pub async fn negative_exemplars_have_no_label_and_are_chosen_by_it(catalogue: Shared) {
    lab(&catalogue).await;
    for (number, label) in [(1, "a"), (2, ""), (3, ""), (4, "b")] {
        let (stored, _) = catalogue.insert_exemplar(&exemplar("lab", number, label)).await.unwrap();
        assert_eq!((stored.negative, stored.label.as_str()), (label.is_empty(), label));
    }
    let counts = catalogue.database_counts("lab").await.unwrap();
    assert_eq!(counts, DatabaseCounts { exemplars: 4, labels: 2, versions: 0 });
    let list = async |negative| {
        let filter = ExemplarFilter { negative, ..ExemplarFilter::default() };
        let rows = catalogue.exemplars("lab", &filter, None, 9).await.unwrap();
        rows.iter().map(|row| row.id.as_u128()).collect::<Vec<_>>()
    };
    assert_eq!(list(Some(true)).await, [2, 3]);
    assert_eq!(list(Some(false)).await, [1, 4]);
    let negative = ExemplarFilter { negative: Some(true), ..ExemplarFilter::default() };
    assert_eq!(catalogue.delete_exemplars("lab", &negative, by()).await.unwrap(), 2);
    assert_eq!(list(None).await, [1, 4]);
}

pub async fn exemplars_are_deleted_one_by_one_or_by_a_filter_that_names_something(catalogue: Shared) {
    lab(&catalogue).await;
    for (number, label) in [(1, "a"), (2, "b"), (3, "b"), (4, "c")] {
        catalogue.insert_exemplar(&exemplar("lab", number, label)).await.unwrap();
    }
    assert!(catalogue.delete_exemplar("lab", Uuid::from_u128(1), by()).await.unwrap());
    assert!(!catalogue.delete_exemplar("lab", Uuid::from_u128(1), by()).await.unwrap());
    let refused = catalogue.delete_exemplars("lab", &ExemplarFilter::default(), by()).await.unwrap_err();
    assert!(matches!(refused, CatalogueError::EmptyFilter), "{refused:?}");
    assert_eq!(catalogue.delete_exemplars("lab", &robot("r1"), by()).await.unwrap(), 0);
    assert_eq!(catalogue.delete_exemplars("lab", &label("b"), by()).await.unwrap(), 2);
    let left = catalogue.training_set("lab").await.unwrap();
    assert_eq!(left.iter().map(|row| row.id.as_u128()).collect::<Vec<_>>(), [4]);
}
