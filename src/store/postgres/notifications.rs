//! Change notifications between processes: `pg_notify`, and one connection that listens.
//!
//! A notification leaves with the commit of the transaction that sent it, and not without. One that is sent while a
//! process doesn't listen is lost, so each new connection counts as a notification too.

use std::time::Duration;

use sqlx::postgres::{PgConnectOptions, PgConnection, PgListener, PgPoolOptions};
use tokio::sync::watch;
use tokio::time::{sleep, timeout};

use super::CONNECT_TIMEOUT;

const CHANNEL: &str = "landmarkd";
/// Pauses between attempts to listen again: they double from the first to the longest.
const FIRST_PAUSE: Duration = Duration::from_millis(50);
const LONGEST_PAUSE: Duration = Duration::from_secs(2);
/// How long the listening connection may be silent before it is pinged.
const SILENCE: Duration = Duration::from_secs(15);

/// Notifies every process, once the transaction has been committed.
pub async fn notify(connection: &mut PgConnection) -> Result<(), sqlx::Error> {
    sqlx::query("SELECT pg_notify($1, '')").bind(CHANNEL).execute(connection).await?;
    Ok(())
}

/// Listens until the last receiver is dropped.
pub fn listen(options: PgConnectOptions) -> watch::Receiver<u64> {
    let (changes, receiver) = watch::channel(0);
    tokio::spawn(async move {
        let mut pause = FIRST_PAUSE;
        loop {
            tokio::select! {
                () = changes.closed() => return,
                // The error is not logged: the catalogue's calls fail with the same one.
                _ = relay(&options, &changes, &mut pause) => {}
            }
            sleep(pause).await;
            pause = (pause * 2).min(LONGEST_PAUSE);
        }
    });
    receiver
}

/// Counts notifications, until the connection is lost.
async fn relay(
    options: &PgConnectOptions,
    changes: &watch::Sender<u64>,
    pause: &mut Duration,
) -> Result<(), sqlx::Error> {
    let pool = PgPoolOptions::new()
        .max_connections(1)
        .acquire_timeout(CONNECT_TIMEOUT)
        .idle_timeout(None)
        .max_lifetime(None)
        .connect_lazy_with(options.clone());
    let mut listener = PgListener::connect_with(&pool).await?;
    listener.eager_reconnect(false);
    within(listener.listen(CHANNEL)).await?;
    *pause = FIRST_PAUSE;
    loop {
        changes.send_modify(|count| *count += 1);
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

/// Bounds the wait for an answer: a lost connection may be silent.
async fn within<T>(answer: impl Future<Output = Result<T, sqlx::Error>>) -> Result<T, sqlx::Error> {
    timeout(CONNECT_TIMEOUT, answer).await.map_err(|_| sqlx::Error::PoolTimedOut)?
}
