//! Blobs in an S3-compatible bucket, shared by the processes of a fleet.
//!
//! Everything about the bucket but its name comes from the usual AWS variables, which `object_store` reads itself:
//! `AWS_ENDPOINT_URL` (or `AWS_ENDPOINT`), `AWS_REGION`, `AWS_ACCESS_KEY_ID`, `AWS_SECRET_ACCESS_KEY`,
//! `AWS_SESSION_TOKEN`, and the roles of a container or a machine. The bucket is a part of the path unless
//! `AWS_VIRTUAL_HOSTED_STYLE_REQUEST=true`. An endpoint with `http://` is used without TLS:
//! `AWS_ALLOW_HTTP` isn't needed. Certificates are verified by the roots of the operating system.
//!
//! A call on a bucket that is away or hangs fails within about 5 s. No state is kept of the failure: the next call tries
//! again.

use std::path::Path as FilePath;
use std::sync::Arc;
use std::time::Duration;

use object_store::aws::{AmazonS3Builder, AmazonS3ConfigKey};
use object_store::path::Path;
use object_store::prefix::PrefixStore;
use object_store::{BackoffConfig, ClientOptions, RetryConfig};
use uuid::Uuid;

use super::blob_name::BlobName;
use super::blobs::Blobs;
use super::cache::Cache;

/// Longest time to connect, the look-up of the name included.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(2);
/// Longest time until an answer begins, the sending of a part included; and longest pause within an answer.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(4);
/// Longest time of one request: 512 MiB at 1 MB/s.
const REQUEST_TIMEOUT: Duration = Duration::from_secs(600);
/// A failure after this time isn't retried: so a refused connection is, and a missing answer isn't.
const RETRY_TIMEOUT: Duration = Duration::from_millis(500);
/// Why the bucket can't be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenBucketError {
    /// The location isn't one.
    #[error("{location:?} names no bucket: give s3://bucket or s3://bucket/prefix")]
    Location {
        /// The location, as it was given.
        location: String,
    },
    /// The AWS variables are not right.
    #[error("the settings for {location} are not right: check the AWS_… variables of the environment")]
    Settings {
        /// The location, as it was given.
        location: String,
        /// The error of the bucket.
        #[source]
        source: object_store::Error,
    },
    /// The bucket doesn't exist, or refuses the keys.
    #[error(
        "can't open {location}: does the bucket exist, and do AWS_ENDPOINT_URL, AWS_REGION and the keys fit it?"
    )]
    Refused {
        /// The location, as it was given.
        location: String,
        /// The error of the bucket.
        #[source]
        source: object_store::Error,
    },
    /// The blobs of another catalogue are there, of another fleet or of the one that this was restored from.
    #[error(
        "{location} holds the blobs of another catalogue, which this one would take for orphans: give another prefix, \
         or, where the catalogue was restored from a backup and the old one is gone, delete landmarkd-blobs from it"
    )]
    ForeignBlobs {
        /// The location, as it was given.
        location: String,
    },
    /// The bucket doesn't answer now: the only one that may heal by itself.
    #[error("{location} cannot be reached now: is AWS_ENDPOINT_URL right?")]
    Unavailable {
        /// The location, as it was given.
        location: String,
        /// The error of the bucket.
        #[source]
        source: object_store::Error,
    },
}

/// Opens the blobs at `s3://bucket/prefix`, and marks the place with the catalogue where it is new; the bucket must
/// exist.
///
/// What is read is cached in the folder `cache`, up to `cache_bytes`, for this process alone.
///
/// # Errors
/// `Unavailable` may heal by itself, no other does. `ForeignBlobs` when the place is marked with another catalogue.
pub async fn open_bucket(
    location: &str,
    catalogue: Uuid,
    cache: &FilePath,
    cache_bytes: u64,
) -> Result<Blobs, OpenBucketError> {
    open(AmazonS3Builder::from_env(), location, catalogue, Cache::open(cache, cache_bytes).await).await
}

/// Opens a bucket with the builder's endpoint and keys.
pub(super) async fn open(
    builder: AmazonS3Builder,
    location: &str,
    catalogue: Uuid,
    cache: Cache<BlobName>,
) -> Result<Blobs, OpenBucketError> {
    // One provider for the whole process; it may be installed already.
    rustls::crypto::ring::default_provider().install_default().ok();

    let wrong = || OpenBucketError::Location { location: location.to_owned() };
    let (bucket, prefix) = parse(location).ok_or_else(wrong)?;
    let endpoint = [AmazonS3ConfigKey::S3Endpoint, AmazonS3ConfigKey::Endpoint]
        .iter()
        .find_map(|key| builder.get_config_value(key));
    let is_plain = endpoint.is_some_and(|endpoint| endpoint.starts_with("http://"));
    let client = ClientOptions::new()
        .with_allow_http(is_plain)
        .with_connect_timeout(CONNECT_TIMEOUT)
        .with_read_timeout(ANSWER_TIMEOUT)
        .with_timeout(REQUEST_TIMEOUT);
    let retry = RetryConfig {
        backoff: BackoffConfig { max_backoff: Duration::from_millis(500), ..BackoffConfig::default() },
        max_retries: 2,
        retry_timeout: RETRY_TIMEOUT,
    };
    let store = builder
        .with_bucket_name(bucket)
        .with_client_options(client)
        .with_retry(retry)
        // Deletes one at a time, which every store with S3's interface can do.
        .with_disable_bulk_delete(true)
        .build()
        .map_err(|source| OpenBucketError::Settings { location: location.to_owned(), source })?;
    let location = location.to_owned();
    match Blobs::in_bucket(Arc::new(PrefixStore::new(store, prefix)), cache, catalogue).await {
        Ok(Some(blobs)) => Ok(blobs),
        Ok(None) => Err(OpenBucketError::ForeignBlobs { location }),
        Err(
            source @ (object_store::Error::NotFound { .. }
            | object_store::Error::PermissionDenied { .. }
            | object_store::Error::Unauthenticated { .. }),
        ) => Err(OpenBucketError::Refused { location, source }),
        Err(source) => Err(OpenBucketError::Unavailable { location, source }),
    }
}

fn parse(location: &str) -> Option<(&str, Path)> {
    let rest = location.strip_prefix("s3://")?;
    let (bucket, prefix) = rest.split_once('/').unwrap_or((rest, ""));
    let is_name = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '.' | '_');
    let prefix = Path::parse(prefix).ok()?;
    (!bucket.is_empty() && bucket.chars().all(is_name)).then_some((bucket, prefix))
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use bytes::Bytes;

    use super::super::blob_error::BlobError;
    use super::*;
    use crate::store::suite::blobs::{Opened, blob_suite};
    use crate::store::suite::by;
    use crate::store::test_bucket::Bucket;
    use crate::store::{BlobName, Folder, NewVersion, collect_orphans, open_folder};

    /// What a call on a bucket that is away may take, on a busy machine.
    const SOON: Duration = Duration::from_secs(6);

    fn builder(endpoint: &str) -> AmazonS3Builder {
        AmazonS3Builder::new()
            .with_endpoint(endpoint)
            .with_access_key_id("test")
            .with_secret_access_key("test")
    }

    async fn open_at(bucket: &Bucket, cache: &FilePath, cache_bytes: u64) -> Result<Blobs, OpenBucketError> {
        let cache = Cache::open(cache, cache_bytes).await;
        open(builder(&bucket.endpoint()), &bucket.location(), Uuid::nil(), cache).await
    }

    /// A bucket and a folder for caches.
    async fn fixture() -> (Bucket, tempfile::TempDir) {
        let bucket = tokio::task::spawn_blocking(Bucket::new).await.unwrap();
        (bucket, tempfile::tempdir().unwrap())
    }

    fn key(name: BlobName) -> String {
        let digits = name.to_string();
        format!("{}/{digits}", &digits[..2])
    }

    async fn empty() -> (Opened, tempfile::TempDir) {
        let (bucket, directory) = fixture().await;
        let (cache, other_cache) = (directory.path().join("cache"), directory.path().join("other"));
        // Both find the place new, at the same moment.
        let (blobs, twin) =
            tokio::join!(open_at(&bucket, &cache, 100 << 20), open_at(&bucket, &other_cache, 100 << 20));
        let damage = Box::new(move |name, content: &[u8]| bucket.overwrite(&key(name), content));
        (Opened { blobs: blobs.unwrap(), twin: twin.unwrap(), damage }, directory)
    }

    mod a_bucket_keeps_every_promise {
        use super::{blob_suite, empty};

        blob_suite!(empty, ignore = "needs moto_server; run by .ci/run");
    }

    #[test]
    fn a_location_is_a_bucket_and_perhaps_a_prefix() {
        for (location, bucket, prefix) in [
            ("s3://robots", "robots", ""),
            ("s3://robots/", "robots", ""),
            ("s3://robots.example/site/blobs/", "robots.example", "site/blobs"),
        ] {
            assert_eq!(parse(location), Some((bucket, Path::from(prefix))), "{location}");
        }
        for location in
            ["", "robots", "s3://", "s3:///prefix", "https://robots/", "s3://ro?bots", "s3://a/b//c"]
        {
            assert_eq!(parse(location), None, "{location}");
        }
    }

    #[tokio::test]
    async fn an_endpoint_with_tls_can_be_asked() {
        let directory = tempfile::tempdir().unwrap();
        // Nobody listens: the call fails where it connects, with a client that has roots and a crypto provider.
        let cache = Cache::open(directory.path(), 0).await;
        let refused =
            open(builder("https://127.0.0.1:9"), "s3://robots", Uuid::nil(), cache).await.unwrap_err();
        assert!(matches!(refused, OpenBucketError::Unavailable { .. }), "{refused:?}");
        let text = format!("{refused:?}");
        assert!(text.contains("Connect") && !text.contains("certificate"), "{text}");
    }

    #[tokio::test]
    #[ignore = "needs moto_server; run by .ci/run"]
    async fn a_bucket_that_is_not_ours_is_refused_and_one_that_is_away_can_be_waited_for() {
        let (bucket, directory) = fixture().await;
        let cache = Cache::open(directory.path(), 0).await;
        let refused = open(builder(&bucket.endpoint()), "s3://nobody", Uuid::nil(), cache).await.unwrap_err();
        assert!(matches!(refused, OpenBucketError::Refused { .. }), "{refused:?}");
        open_at(&bucket, directory.path(), 0).await.unwrap();
        let cache = Cache::open(directory.path(), 0).await;
        let other = open(builder(&bucket.endpoint()), &bucket.location(), Uuid::max(), cache).await;
        assert!(matches!(other, Err(OpenBucketError::ForeignBlobs { .. })), "{other:?}");
        bucket.goes_away();
        let refused = open_at(&bucket, directory.path(), 0).await.unwrap_err();
        assert!(matches!(refused, OpenBucketError::Unavailable { .. }), "{refused:?}");
        bucket.comes_back();
        open_at(&bucket, directory.path(), 0).await.unwrap();
    }

    async fn fails_soon(call: &str, work: impl Future<Output = Result<(), BlobError>>) {
        let begun = Instant::now();
        let failed = work.await;
        eprintln!("{call}: fails after {:?}", begun.elapsed());
        assert!(matches!(failed, Err(BlobError::Unavailable { .. })), "{call}: {failed:?}");
        assert!(begun.elapsed() < SOON, "{call}: {:?}", begun.elapsed());
    }

    #[tokio::test]
    #[ignore = "needs moto_server; run by .ci/run"]
    async fn a_bucket_that_is_away_or_hangs_says_so_soon_and_heals() {
        let (bucket, directory) = fixture().await;
        let blobs = open_at(&bucket, directory.path(), 0).await.unwrap();
        let name = blobs.put("picture".into()).await.unwrap();
        let large = Bytes::from(vec![3; 12 << 20]);
        for go in [Bucket::goes_away, Bucket::hangs] {
            go(&bucket);
            tokio::join!(
                fails_soon("ping", blobs.ping()),
                fails_soon("get", async { blobs.get(&name, 100).await.map(drop) }),
                fails_soon("put", async { blobs.put("other".into()).await.map(drop) }),
                fails_soon("put in parts", async { blobs.put(large.clone()).await.map(drop) }),
            );
            bucket.comes_back();
            blobs.ping().await.unwrap();
            assert_eq!(blobs.get(&name, 100).await.unwrap(), "picture");
            blobs.put(large.clone()).await.unwrap();
        }
    }

    #[tokio::test]
    #[ignore = "needs moto_server; run by .ci/run"]
    async fn what_was_read_before_is_read_without_the_bucket() {
        let (bucket, directory) = fixture().await;
        let blobs = open_at(&bucket, directory.path(), 1 << 20).await.unwrap();
        let name = blobs.put("picture".into()).await.unwrap();
        let other = blobs.put("other".into()).await.unwrap();
        assert_eq!(blobs.get(&name, 100).await.unwrap(), "picture");
        let received = bucket.bytes_received();
        assert_eq!(blobs.get(&name, 100).await.unwrap(), "picture");
        assert_eq!(bucket.bytes_received(), received);

        bucket.goes_away();
        assert_eq!(blobs.get(&name, 100).await.unwrap(), "picture");
        let unread = blobs.get(&other, 100).await.unwrap_err();
        assert!(matches!(unread, BlobError::Unavailable { .. }), "{unread:?}");

        bucket.comes_back();
        std::fs::write(directory.path().join(name.to_string()), "pictvre").unwrap();
        assert_eq!(blobs.get(&name, 100).await.unwrap(), "picture");
        assert_eq!(std::fs::read(directory.path().join(name.to_string())).unwrap(), b"picture");
        // The next process finds what this one kept.
        bucket.goes_away();
        let received = bucket.bytes_received();
        drop(blobs);
        bucket.comes_back();
        let blobs = open_at(&bucket, directory.path(), 1 << 20).await.unwrap();
        bucket.goes_away();
        assert_eq!(blobs.get(&name, 100).await.unwrap(), "picture");
        assert!(bucket.bytes_received() - received < 2000, "only the marker is looked at");
    }

    fn version(blob: BlobName) -> NewVersion {
        NewVersion {
            database: "lab".to_owned(),
            digest: blob.to_string(),
            blob: blob.to_string(),
            bytes: 8,
            kind: "landmarks".to_owned(),
            algorithm_revision: 1,
            options: "{}".to_owned(),
            counts: "{}".to_owned(),
            report: "{}".to_owned(),
        }
    }

    #[tokio::test]
    #[ignore = "needs moto_server; run by .ci/run"]
    async fn orphans_are_set_aside_and_deleted_only_when_they_stay_orphans() {
        let (bucket, directory) = fixture().await;
        let blobs = open_at(&bucket, &directory.path().join("cache"), 0).await.unwrap();
        let Folder { catalogue, blobs: _ } = open_folder(&directory.path().join("data")).await.unwrap();
        catalogue.create_database("lab", "landmarks", "{}", by()).await.unwrap();
        let [used, orphan, late] = ["used", "orphan", "late"].map(Bytes::from);
        let used = blobs.put(used).await.unwrap();
        let orphan = blobs.put(orphan).await.unwrap();
        let late = blobs.put(late).await.unwrap();
        catalogue.insert_version(&version(used), by()).await.unwrap();
        bucket.overwrite("README", b"not ours");

        // Times of objects are whole seconds.
        let age = Duration::from_secs(2);
        let collect = async || collect_orphans(&blobs, age, &catalogue).await.unwrap().removed;
        let grow_old = || tokio::time::sleep(age + Duration::from_millis(1100));
        assert_eq!(collect().await, 0);
        grow_old().await;
        let young = blobs.put("young".into()).await.unwrap();
        assert_eq!(collect().await, 0);
        // The row of a put that the deletion overtook.
        catalogue.insert_version(&version(late), by()).await.unwrap();
        for name in [used, orphan, late, young] {
            blobs.get(&name, 100).await.unwrap();
        }
        grow_old().await;
        blobs.put("young".into()).await.unwrap();
        assert_eq!(collect().await, 1);
        for name in [used, late, young] {
            blobs.get(&name, 100).await.unwrap();
        }
        let gone = blobs.get(&orphan, 100).await.unwrap_err();
        assert!(matches!(gone, BlobError::NotFound { .. }), "{gone:?}");
        blobs.ping().await.unwrap();
    }
}
