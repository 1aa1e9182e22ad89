//! Uploads to a bucket, in parts where the content is large.

use bytes::Bytes;
use object_store::path::Path;
use object_store::{ObjectStore, ObjectStoreExt};

/// Content is sent in parts of this size (the least that S3 takes), each within the 4 s of
/// `bucket::ANSWER_TIMEOUT`: at 1.3 MB/s at least. S3 takes 10 000 parts, 48 GiB; what is sent at once would end at 5 GiB.
const PART_BYTES: usize = 5 << 20;

/// Writes an object whole or not at all, whatever stood there.
///
/// Parts of an upload that was cut off are never seen, but kept by S3: a life-cycle rule of the bucket
/// (`AbortIncompleteMultipartUpload`) removes them.
pub(super) async fn upload(
    store: &dyn ObjectStore,
    path: &Path,
    content: Bytes,
) -> Result<(), object_store::Error> {
    if content.len() <= PART_BYTES {
        store.put(path, content.into()).await?;
        return Ok(());
    }
    let mut upload = store.put_multipart(path).await?;
    let mut rest = content;
    while !rest.is_empty() {
        let part = rest.split_to(PART_BYTES.min(rest.len()));
        if let Err(error) = upload.put_part(part.into()).await {
            // Not awaited: it may take as long again as what failed.
            tokio::spawn(async move { upload.abort().await });
            return Err(error);
        }
    }
    upload.complete().await?;
    Ok(())
}
