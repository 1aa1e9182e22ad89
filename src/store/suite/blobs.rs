//! The behaviour of the blobs, wherever they are.
//!
//! A folder or a bucket runs it with `blob_suite!(open, attribute)`, where `open` gives an empty store and the attribute goes to
//! every test.

use bytes::Bytes;

use super::super::{BlobError, BlobName, Blobs};

/// Blobs and what a test does behind their back.
pub struct Opened {
    pub blobs: Blobs,
    /// The same store as another user of it has it, with nothing in memory or in a cache.
    pub twin: Blobs,
    pub damage: Damage,
}

/// Replaces what stands under a name.
pub type Damage = Box<dyn Fn(BlobName, &[u8]) + Send + Sync>;

/// Makes a test of each function of the suite.
macro_rules! blob_suite {
    ($open:path, $attribute:meta) => {
        $crate::store::suite::blobs::blob_suite! { @each $open, $attribute:
            a_blob_comes_back_under_the_hash_of_its_content
            a_blob_put_by_many_at_once_is_one_blob
            a_damaged_blob_is_refused_and_putting_it_again_mends_it
            a_blob_larger_than_allowed_is_not_read
        }
    };
    (@each $open:path, $attribute:meta: $($promise:ident)+) => {
        $($crate::store::suite::blobs::blob_suite! { @one $open, $attribute: $promise })+
    };
    (@one $open:path, $attribute:meta: $promise:ident) => {
        #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
        #[$attribute]
        async fn $promise() {
            let (opened, _kept) = $open().await;
            $crate::store::suite::blobs::$promise(opened).await;
        }
    };
}
pub(in crate::store) use blob_suite;

pub async fn a_blob_comes_back_under_the_hash_of_its_content(opened: Opened) {
    opened.blobs.ping().await.unwrap();
    // The last is more than one part of an upload to a bucket.
    for content in [Bytes::new(), Bytes::from_static(b"picture"), Bytes::from(vec![7; 64 << 20])] {
        let name = BlobName::of(&content);
        let missing = opened.blobs.get(&name, u64::MAX).await.unwrap_err();
        assert!(matches!(missing, BlobError::NotFound { .. }), "{missing:?}");
        assert_eq!(opened.blobs.put(content.clone()).await.unwrap(), name);
        for blobs in [&opened.blobs, &opened.twin, &opened.blobs] {
            assert!(blobs.get(&name, content.len() as u64).await.unwrap() == content);
        }
        assert_eq!(opened.blobs.put(content).await.unwrap(), name);
    }
}

pub async fn a_blob_put_by_many_at_once_is_one_blob(opened: Opened) {
    let content = Bytes::from(vec![1; 100_000]);
    let puts = [&opened.blobs, &opened.twin].repeat(8).into_iter().map(|blobs| {
        let (blobs, content) = (blobs.clone(), content.clone());
        tokio::spawn(async move { blobs.put(content).await.unwrap() })
    });
    let names: Vec<_> = futures_util::future::join_all(puts).await.into_iter().map(Result::unwrap).collect();
    assert!(names.iter().all(|name| *name == BlobName::of(&content)));
    assert_eq!(opened.twin.get(&names[0], 100_000).await.unwrap(), content);
}

pub async fn a_damaged_blob_is_refused_and_putting_it_again_mends_it(opened: Opened) {
    let name = opened.blobs.put("picture".into()).await.unwrap();
    for damaged in ["pictvre", "pict", ""] {
        (opened.damage)(name, damaged.as_bytes());
        let refused = opened.blobs.get(&name, 100).await.unwrap_err();
        let found = BlobName::of(damaged.as_bytes());
        assert!(matches!(refused, BlobError::Corrupt { found: hash, .. } if hash == found), "{refused:?}");
    }
    opened.twin.put("picture".into()).await.unwrap();
    assert_eq!(opened.blobs.get(&name, 100).await.unwrap(), "picture");
}

pub async fn a_blob_larger_than_allowed_is_not_read(opened: Opened) {
    let name = opened.blobs.put("picture".into()).await.unwrap();
    // The second time it may stand in a cache.
    for _ in 0..2 {
        let refused = opened.blobs.get(&name, 6).await.unwrap_err();
        assert!(matches!(refused, BlobError::TooLarge { bytes: 7, max_bytes: 6, .. }), "{refused:?}");
        opened.blobs.get(&name, 7).await.unwrap();
    }
}
