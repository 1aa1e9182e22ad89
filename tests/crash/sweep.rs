//! A fault at every call by which the service changes a file, one scenario a call.
//!
//! The calls of a scenario aren't the same from run to run: a renewed lease is one more. So the calls of one whole
//! scenario are counted, and a little more than that is swept; a call that isn't reached any more is a round without a
//! fault, and is checked all the same.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use futures_util::StreamExt;

use crate::client::Client;
use crate::faults::{Fault, Faults};
use crate::pictures::Numbers;
use crate::process::Process;
use crate::scenario::{Known, Robot};

/// Rounds at the same time: most of a round is waiting.
const AT_ONCE: usize = 4;

fn process(folder: &std::path::Path, faults: &Faults) -> Option<Process> {
    Process::try_start_with(folder, |command| faults.load(command, folder)).ok()
}

/// The calls of one scenario without a fault, and the answers that go with its digests.
async fn counted() -> (u64, Known) {
    let (folder, faults) = (tempfile::tempdir().unwrap(), Faults::new());
    let process = process(folder.path(), &faults).unwrap();
    let mut robot = Robot::new(Client::new(&process), Known::default(), None);
    robot.client.ready("nothing failed").await;
    robot.run().await.unwrap();
    let calls = faults.calls();
    robot.check(folder.path(), "nothing failed").await;
    (calls, Known { answers: robot.known.answers, ..Known::default() })
}

/// The process dies at that call; what it acknowledged is there when it is started again.
async fn dies(call: u64, fault: Fault, known: Known) -> (bool, Duration) {
    let context = format!("{fault:?} at call {call}");
    let (folder, faults) = (tempfile::tempdir().unwrap(), Faults::new());
    faults.at(call, fault, false);
    let mut robot = None;
    if let Some(process) = process(folder.path(), &faults) {
        let mut alive = Robot::new(Client::new(&process), known.clone(), None);
        // Not ready, or not done: it died there.
        if alive.client.get("/readyz").await.is_ok() {
            let died = alive.run().await.is_err();
            assert_eq!(died, faults.failed() > 0, "{context}");
        }
        robot = Some(alive);
        drop(process);
    }
    let process = Process::start(folder.path());
    let client = Client::new(&process);
    let ready = client.ready(&context).await;
    let known = robot.map_or(known, |robot| robot.known);
    let mut robot = Robot::new(client, known, None);
    robot.check(folder.path(), &context).await;
    (faults.failed() > 0, ready)
}

/// That call fails, or all do from there until somebody heals the disk; the service stays up, refuses what it can't do,
/// and heals by itself.
async fn fails(call: u64, fault: Fault, lasting: bool, known: Known) -> (bool, u64) {
    let context = format!("{fault:?} at call {call}{}", if lasting { " and after" } else { "" });
    let (folder, faults) = (tempfile::tempdir().unwrap(), Faults::new());
    faults.at(call, fault, lasting);
    let process = match process(folder.path(), &faults) {
        Some(process) => process,
        // It may refuse to start on such a disk, and says why; on a whole one it starts.
        None => {
            faults.heal();
            Process::start_with(folder.path(), |command| faults.load(command, folder.path()))
        }
    };
    let refusals = AtomicU64::new(0);
    let refused = || {
        // Long enough to see that it stays up, then the disk is well again.
        if refusals.fetch_add(1, Ordering::Relaxed) >= 4 {
            faults.heal();
        }
    };
    let client = Client::new(&process);
    client.ready(&context).await;
    let mut robot = Robot::new(client, known, Some(&refused));
    robot.run().await.unwrap_or_else(|died| panic!("{died:?}: {context}"));
    let failed = faults.failed();
    faults.heal();
    robot.refused = None;
    robot.check(folder.path(), &context).await;
    // And it is all there for the next process too.
    drop(process);
    let process = Process::start(folder.path());
    robot.client = Client::new(&process);
    robot.client.ready(&context).await;
    robot.check(folder.path(), &context).await;
    (failed > 0, refusals.into_inner())
}

/// Some calls of all, by a fixed seed.
fn sampled(calls: u64, rounds: u64) -> Vec<u64> {
    let mut numbers = Numbers::seeded(7);
    // One of every stretch, so that no part of the scenario is left out for long.
    (0..rounds).map(|round| 1 + (calls * round + numbers.below(calls)) / rounds).collect()
}

async fn die_at(calls: Vec<u64>, known: &Known) {
    let started = Instant::now();
    let rounds = calls.into_iter().enumerate().map(|(round, call)| {
        let fault = Fault::DEATHS[round % Fault::DEATHS.len()];
        let known = known.clone();
        async move { tokio::spawn(dies(call, fault, known)).await.unwrap() }
    });
    let ended: Vec<(bool, Duration)> =
        futures_util::stream::iter(rounds).buffer_unordered(AT_ONCE).collect().await;
    let died = ended.iter().filter(|(died, _)| *died).count();
    let slowest = ended.iter().map(|(_, ready)| *ready).max().unwrap_or_default();
    println!(
        "{} rounds, {died} deaths at a call; ready again within {slowest:?}; {:?} in all",
        ended.len(),
        started.elapsed()
    );
    assert!(died * 2 > ended.len(), "most rounds must have died to show anything");
}

async fn fail_at(calls: Vec<u64>, faults: &'static [Fault], known: &Known) {
    let started = Instant::now();
    let rounds = calls.into_iter().enumerate().map(|(round, call)| {
        let fault = faults[round % faults.len()];
        let (lasting, known) = (round % 2 == 0, known.clone());
        async move { tokio::spawn(fails(call, fault, lasting, known)).await.unwrap() }
    });
    let ended: Vec<(bool, u64)> =
        futures_util::stream::iter(rounds).buffer_unordered(AT_ONCE).collect().await;
    let failed = ended.iter().filter(|(failed, _)| *failed).count();
    let refused: u64 = ended.iter().map(|(_, refused)| refused).sum();
    println!(
        "{} rounds, {failed} with failed calls, {refused} requests refused; {:?}",
        ended.len(),
        started.elapsed()
    );
    assert!(failed * 2 > ended.len(), "most rounds must have failed to show anything");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_death_at_a_call_loses_nothing_that_was_acknowledged() {
    let (calls, known) = counted().await;
    die_at(sampled(calls, 9), &known).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_call_that_fails_is_refused_and_the_service_heals() {
    let (calls, known) = counted().await;
    fail_at(sampled(calls, 6), &Fault::FAILURES, &known).await;
}

#[tokio::test(flavor = "multi_thread")]
#[ignore = "some minutes: every call, in release"]
async fn a_death_at_every_call_loses_nothing_that_was_acknowledged() {
    let (calls, known) = counted().await;
    println!("{calls} calls in the scenario");
    for first in 0..Fault::DEATHS.len() as u64 {
        // Every call by every death: they take turns from another beginning.
        println!("from {:?} on", Fault::DEATHS[first as usize]);
        let all = (1 + first..=calls + calls / 20).collect();
        die_at(all, &known).await;
    }
}

#[tokio::test(flavor = "multi_thread")]
#[ignore = "many minutes: every call, in release"]
async fn every_call_that_fails_is_refused_and_the_service_heals() {
    let (calls, known) = counted().await;
    println!("{calls} calls in the scenario");
    fail_at((1..=calls).collect(), &Fault::FAILURES, &known).await;
}
