//! How a process learns soon that another one changed something: `pg_notify` and one connection that listens.
//!
//! A notification leaves with the commit of the transaction that sent it, and not without. What is sent while
//! nobody listens is lost, so each connection made anew counts as a hint too.

use std::time::Duration;

use sqlx::postgres::{PgConnectOptions, PgConnection, PgListener, PgPoolOptions};
use tokio::sync::watch;
use tokio::time::{sleep, timeout};

use super::TURN_TIMEOUT;
use crate::store::CatalogueError;

const CHANNEL: &str = "landmarkd";
/// Pauses between attempts to listen again: they double from the first to the longest.
const FIRST_PAUSE: Duration = Duration::from_millis(50);
const LONGEST_PAUSE: Duration = Duration::from_secs(2);
/// How long silence is taken for quiet, before the connection is asked whether it still is one.
const SILENCE: Duration = Duration::from_secs(15);

/// Tells every process, once the transaction has been committed.
pub async fn send(connection: &mut PgConnection) -> Result<(), CatalogueError> {
    sqlx::query("SELECT pg_notify($1, '')").bind(CHANNEL).execute(connection).await?;
    Ok(())
}

/// Listens until the last receiver is dropped.
pub fn listen(options: PgConnectOptions) -> watch::Receiver<u64> {
    let (hints, receiver) = watch::channel(0);
    tokio::spawn(async move {
        let mut pause = FIRST_PAUSE;
        loop {
            tokio::select! {
                () = hints.closed() => return,
                // Why it ended is what the catalogue's calls fail with too; they tell.
                _ = relay(&options, &hints, &mut pause) => {}
            }
            sleep(pause).await;
            pause = (pause * 2).min(LONGEST_PAUSE);
        }
    });
    receiver
}

/// Counts what is heard, until the connection is lost.
async fn relay(
    options: &PgConnectOptions,
    hints: &watch::Sender<u64>,
    pause: &mut Duration,
) -> Result<(), sqlx::Error> {
    let pool = PgPoolOptions::new()
        .max_connections(1)
        .acquire_timeout(TURN_TIMEOUT)
        .idle_timeout(None)
        .max_lifetime(None)
        .connect_lazy_with(options.clone());
    let mut listener = PgListener::connect_with(&pool).await?;
    listener.eager_reconnect(false);
    within(listener.listen(CHANNEL)).await?;
    *pause = FIRST_PAUSE;
    loop {
        hints.send_modify(|heard| *heard += 1);
        loop {
            match timeout(SILENCE, listener.try_recv()).await {
                Ok(Ok(Some(_))) => break,
                Ok(Ok(None)) => return Ok(()),
                Ok(Err(lost)) => return Err(lost),
                Err(_) => within(sqlx::query("SELECT 1").execute(&mut listener)).await.map(drop)?,
            }
        }
    }
}

/// A lost connection may be silent: then the answer doesn't come.
async fn within<T>(answer: impl Future<Output = Result<T, sqlx::Error>>) -> Result<T, sqlx::Error> {
    timeout(TURN_TIMEOUT, answer).await.map_err(|_| sqlx::Error::PoolTimedOut)?
}
