//! The exemplars of a landmark database described, each by itself. With gradient signatures a description is kept on this
//! machine, and a later training takes it from there.

use std::sync::Arc;

use super::landmarks::name;
use crate::database::description::{decode, description_key, encode};
use crate::database::{DatabaseError, DescriptionsReport, ExemplarRow};
use crate::jobs::stop::Stop;
use crate::jobs::worker::Worker;
use crate::problem::Code;
use landmarkd_core::recognition::landmarks::{DescribedExemplar, LandmarkOptions, Signature, describe};

/// What `then` makes of each exemplar's description, in the exemplars' order; how many were computed, and the milliseconds that
/// all of it took. Descriptions are let go one by one: they are far larger than what is made of them.
pub(super) async fn described<T: Send + 'static>(
    worker: &Worker<'_>,
    stage: &str,
    exemplars: Vec<ExemplarRow>,
    options: &Arc<LandmarkOptions>,
    then: impl Fn(DescribedExemplar) -> T + Send + Sync + 'static,
) -> Result<(Vec<T>, DescriptionsReport, f64), Stop> {
    let keeps = options.signature == Signature::Gradient;
    let then = &Arc::new(then);
    let one = |place: usize, row: ExemplarRow| async move {
        let then = Arc::clone(then);
        match keeps {
            true => kept_or_computed(worker, place, row, options, then).await,
            false => Ok((
                computed(worker, place, &row, options, move |_, described| then(described)).await?,
                false,
            )),
        }
    };
    let (made, took_ms) = worker.in_parallel(stage, exemplars, one).await?;
    let (made, kept): (Vec<T>, Vec<bool>) = made.into_iter().unzip();
    let kept = kept.into_iter().filter(|kept| *kept).count() as u64;
    let report = DescriptionsReport { computed: made.len() as u64 - kept, kept };
    Ok((made, report, took_ms))
}

/// What `then` makes of the kept description of an exemplar, and true; or of the computed one, which is kept.
async fn kept_or_computed<T: Send + 'static>(
    worker: &Worker<'_>,
    place: usize,
    row: ExemplarRow,
    options: &Arc<LandmarkOptions>,
    then: Arc<impl Fn(DescribedExemplar) -> T + Send + Sync + 'static>,
) -> Result<(T, bool), Stop> {
    let descriptions = &worker.databases.descriptions;
    let key = description_key(&row, options).map_err(DatabaseError::from)?;
    if let Some(bytes) = descriptions.get(key).await {
        let (row, then) = (row.clone(), Arc::clone(&then));
        if let Some(made) = worker.run(0, move || decode(&bytes, &row).map(|kept| then(kept))).await? {
            return Ok((made, true));
        }
    }
    // Taken from its bytes, as the next training will: the same inputs give the same version.
    let both = move |row: &ExemplarRow, described| {
        let bytes = encode(&described);
        decode(&bytes, row).map(|described| (bytes, then(described)))
    };
    let both = computed(worker, place, &row, options, both).await?;
    let (bytes, made) =
        both.ok_or_else(|| Stop::failed(Code::Internal, "a description doesn't come back from its bytes"))?;
    descriptions.keep(key, &bytes).await;
    Ok((made, false))
}

/// An exemplar described, and what `then` makes of it.
async fn computed<T: Send + 'static>(
    worker: &Worker<'_>,
    place: usize,
    row: &ExemplarRow,
    options: &Arc<LandmarkOptions>,
    then: impl Fn(&ExemplarRow, DescribedExemplar) -> T + Send + Sync + 'static,
) -> Result<T, Stop> {
    let (with, longer_side_px) = (Arc::clone(options), options.working_size_px);
    let describe = move |_: usize, row: &ExemplarRow, frame: &_| {
        let mut described = describe(name(row), frame, &with);
        (described.exemplar.width_px, described.exemplar.height_px) = (row.width_px, row.height_px);
        Ok(then(row, described))
    };
    worker.one(place, row.clone(), longer_side_px, Arc::new(describe)).await
}
