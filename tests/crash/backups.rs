//! Backups while the service runs: taken one after another beside uploads and trainings, each opens and holds
//! everything that was acknowledged before it began.

use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use serde_json::json;

use crate::client::{Client, verify};
use crate::faults::{Fault, Faults};
use crate::process::{Process, landmarkd};
use crate::scenario::{Known, Robot};

fn back_up(folder: &Path, to: &Path) -> Result<String, String> {
    let mut command = landmarkd();
    let ended = command.arg("backup").arg("--data-dir").arg(folder).arg("--to").arg(to).output().unwrap();
    let (said, refused) = (ended.stdout, ended.stderr);
    match ended.status.success() {
        true => Ok(String::from_utf8(said).unwrap()),
        false => Err(String::from_utf8(said).unwrap() + &String::from_utf8(refused).unwrap()),
    }
}

async fn backups(count: usize) {
    let (folder, copies) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let process = Process::start(folder.path());
    let client = Client::new(&process);
    client.ready("").await;
    let options = json!({"kind": "landmarks", "options": {"method": "paper", "interest_points": 8}});
    client.put("/v1/databases/lab", options).await.unwrap().expect(201);

    let (acknowledged, done) = (Mutex::new(Known::default()), AtomicBool::new(false));
    let working = async {
        let mut robot = Robot::new(client.clone(), Known::default(), None);
        for number in 1.. {
            if done.load(Ordering::Relaxed) {
                break;
            }
            robot.upload("lab", number).await.unwrap();
            // A few labels are enough, or trainings would take ever longer.
            if number % 5 == 0 {
                robot.train("lab").await.unwrap();
                robot.recognise("lab").await.unwrap();
            }
            *acknowledged.lock().unwrap() = robot.known.clone();
        }
    };
    let copying = async {
        let mut longest = Duration::ZERO;
        for number in 0..count {
            tokio::time::sleep(Duration::from_millis(200)).await;
            let before = acknowledged.lock().unwrap().clone();
            let (from, to) = (folder.path().to_owned(), copies.path().join(format!("copy-{number}")));
            let begun = Instant::now();
            let at = to.clone();
            tokio::task::spawn_blocking(move || back_up(&from, &at)).await.unwrap().unwrap();
            longest = longest.max(begun.elapsed());
            let context = format!("backup {number}");
            verify(&to).unwrap_or_else(|said| panic!("{said} {context}"));
            let copy = Process::start(&to);
            let client = Client::new(&copy);
            client.ready(&context).await;
            // What changed since is another truth there.
            let mut known = before;
            known.facts.retain(|path, _| !path.ends_with("/aliases/current"));
            println!("{context}: {} facts", known.facts.len());
            Robot::new(client, known, None).check(&to, &context).await;
        }
        done.store(true, Ordering::Relaxed);
        println!("{count} backups beside uploads and trainings; the longest took {longest:?}");
    };
    tokio::join!(working, copying);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_backup_beside_uploads_and_trainings_is_whole() {
    backups(2).await;
}

#[tokio::test(flavor = "multi_thread")]
#[ignore = "a minute: 20 backups, in release"]
async fn twenty_backups_beside_uploads_and_trainings_are_whole() {
    backups(20).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn half_a_backup_is_never_taken_for_a_whole_one() {
    let (folder, copies) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let process = Process::start(folder.path());
    let mut robot = Robot::new(Client::new(&process), Known::default(), None);
    robot.client.ready("").await;
    robot.run().await.unwrap();
    let to = copies.path().join("copy");
    let faults = Faults::new();
    let attempt = |call: Option<u64>| {
        let mut command = landmarkd();
        command.arg("backup").arg("--data-dir").arg(folder.path()).arg("--to").arg(&to);
        faults.load(&mut command, copies.path());
        let before = faults.calls();
        match call {
            Some(call) => faults.at(before + call, Fault::DEATHS[call as usize % 3], false),
            None => faults.heal(),
        }
        let ended = command.output().unwrap();
        (ended.status.success(), faults.calls() - before)
    };
    let (is_done, calls) = attempt(None);
    assert!(is_done);
    std::fs::remove_dir_all(&to).unwrap();
    let mut died = 0;
    for call in (1..calls).step_by(3) {
        let (is_done, _) = attempt(Some(call));
        assert_eq!(to.exists(), is_done, "cut off at call {call} of {calls}");
        died += usize::from(!is_done);
        if is_done {
            verify(&to).unwrap();
            std::fs::remove_dir_all(&to).unwrap();
        }
    }
    println!("{calls} calls, cut off at {died}");
    // The next one cleans up and goes through.
    assert!(attempt(None).0 && died > 5);
    verify(&to).unwrap();
    let again = back_up(folder.path(), &to).unwrap_err();
    assert!(again.contains("is there already"), "{again}");
    drop(process);
    // And where nothing runs.
    back_up(folder.path(), &copies.path().join("still")).unwrap();
    let copy = Process::start(&copies.path().join("still"));
    robot.client = Client::new(&copy);
    robot.client.ready("").await;
    robot.check(&copies.path().join("still"), "the copy of a folder at rest").await;
}
