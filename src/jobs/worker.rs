//! What a job needs to read pictures and to compute.

use std::sync::Arc;
use std::time::Instant;

use futures_util::{StreamExt, TryStreamExt, stream};

use super::lease::Lease;
use super::stop::Stop;
use crate::compute::{Compute, Lane};
use crate::database::{DatabaseError, Databases, ExemplarRow};
use crate::problem::Code;
use crate::telemetry::chain;
use landmarkd_core::imaging::{self, DecodeLimits, Frame};

/// Pictures of the exemplar's size, with what recognition needs, that a piece of a training's work holds at most.
const PICTURES_AT_ONCE: u64 = 4;

/// The lease of a job with the stores, the computing threads and the limits of pictures.
pub(super) struct Worker<'a> {
    pub(super) lease: &'a Lease,
    pub(super) databases: &'a Databases,
    pub(super) compute: &'a Compute,
    pub(super) decode: &'a DecodeLimits,
}

impl Worker<'_> {
    /// The value of `work`, done on the training lane; its pictures take `picture_bytes`.
    ///
    /// # Errors
    /// The computation panicked, or the lane is full.
    pub(super) async fn run<T: Send + 'static>(
        &self,
        picture_bytes: u64,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Stop> {
        let run = self.compute.run(Lane::Training, picture_bytes, work).await;
        Ok(run.map_err(DatabaseError::from)?.0)
    }

    /// Runs `work` on each exemplar, several at once on the training lane, and gives it the exemplar's index. Returns
    /// its values in the exemplars' order, and the milliseconds that all of it took. Pictures are brought down to
    /// `longer_side_px`.
    pub(super) async fn each<T, F>(
        &self,
        stage: &str,
        exemplars: Vec<ExemplarRow>,
        longer_side_px: Option<usize>,
        work: F,
    ) -> Result<(Vec<T>, f64), Stop>
    where
        T: Send + 'static,
        F: Fn(usize, &ExemplarRow, &Frame) -> Result<T, Stop> + Send + Sync + 'static,
    {
        let work = Arc::new(work);
        let one = |place, row| self.one(place, row, longer_side_px, Arc::clone(&work));
        self.in_parallel(stage, exemplars, one).await
    }

    /// Makes something of each exemplar, several at once. Returns what was made in the exemplars' order, and the
    /// milliseconds that all of it took.
    pub(super) async fn in_parallel<T, F: Future<Output = Result<T, Stop>>>(
        &self,
        stage: &str,
        exemplars: Vec<ExemplarRow>,
        make: impl Fn(usize, ExemplarRow) -> F,
    ) -> Result<(Vec<T>, f64), Stop> {
        let started = Instant::now();
        let total = exemplars.len() as u64;
        let made = stream::iter(exemplars.into_iter().enumerate())
            .map(|(place, row)| make(place, row))
            .buffered(self.compute.threads(Lane::Training))
            .enumerate()
            .then(|(done, made)| async move {
                self.lease.progress(stage, done as u64, total).await?;
                made
            })
            .try_collect()
            .await?;
        Ok((made, started.elapsed().as_secs_f64() * 1e3))
    }

    /// The value of `work` on one exemplar, its picture brought down to `longer_side_px`.
    pub(super) async fn one<T, F>(
        &self,
        place: usize,
        row: ExemplarRow,
        longer_side_px: Option<usize>,
        work: Arc<F>,
    ) -> Result<T, Stop>
    where
        T: Send + 'static,
        F: Fn(usize, &ExemplarRow, &Frame) -> Result<T, Stop> + Send + Sync + 'static,
    {
        let bytes = self.databases.exemplar_bytes(&row).await?;
        let limits = *self.decode;
        // Synthetic views are drawn beside the picture, some at a time.
        let memory = imaging::read_header(&bytes, &limits).map_or(0, |header| match longer_side_px {
            Some(side_px) => header.reduced_bytes(side_px),
            None => PICTURES_AT_ONCE * header.working_bytes(),
        });
        let work = move || {
            let decoded = match longer_side_px {
                Some(side_px) => imaging::decode_reduced(&bytes, &limits, side_px),
                None => imaging::decode(&bytes, &limits),
            };
            let frame = decoded.map_err(|error| {
                let (id, error) = (row.id, chain(&error));
                let text = format!("exemplar {id} can't be decoded: {error}; delete it and train again");
                Stop::failed(Code::UnreadableExemplar, text)
            })?;
            work(place, &row, &frame)
        };
        self.run(memory, work).await?
    }

    /// The value of `work`, done on one thread, and the milliseconds that it took.
    pub(super) async fn alone<T: Send + 'static>(
        &self,
        stage: &str,
        work: impl FnOnce() -> Result<T, Stop> + Send + 'static,
    ) -> Result<(T, f64), Stop> {
        self.lease.progress(stage, 0, 1).await?;
        let started = Instant::now();
        let made = self.run(0, work).await?;
        Ok((made?, started.elapsed().as_secs_f64() * 1e3))
    }
}
