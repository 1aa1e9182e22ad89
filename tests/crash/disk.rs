//! A disk that is full, read-only or broken while the service runs: a real one of a few megabytes, where mounting is
//! allowed, and one made so by the fault points.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use serde_json::json;

use crate::client::{Client, verify};
use crate::faults::{Fault, Faults};
use crate::pictures::scene_png;
use crate::process::Process;

/// A file system of its own in memory; gone when it is dropped.
struct SmallDisk {
    path: PathBuf,
    _folder: tempfile::TempDir,
}

impl SmallDisk {
    /// None where mounting isn't allowed.
    fn new(bytes: u64) -> Option<Self> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("disk");
        std::fs::create_dir(&path).unwrap();
        let mounted = Command::new("mount")
            .args(["-t", "tmpfs", "-o", &format!("size={bytes}"), "tmpfs"])
            .arg(&path)
            .output()
            .is_ok_and(|mount| mount.status.success());
        mounted.then_some(Self { path, _folder: folder })
    }

    /// Takes what is free, down to the last byte.
    fn fill(&self) {
        let filler = std::fs::File::create(self.path.join("filler")).unwrap();
        let mut filler = std::io::BufWriter::with_capacity(4096, filler);
        while std::io::Write::write_all(&mut filler, &[0; 4096]).is_ok() {}
        // What is left in the buffer has no room.
        drop(filler.into_parts());
    }

    fn make_room(&self) {
        std::fs::remove_file(self.path.join("filler")).unwrap();
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(&self.path).status();
    }
}

/// A process with a trained database.
async fn trained(folder: &Path, faults: Option<&Faults>) -> (Process, Client) {
    let process = Process::start_with(folder, |command| {
        if let Some(faults) = faults {
            faults.load(command, folder);
        }
    });
    let client = Client::new(&process);
    client.ready("").await;
    let options = json!({"kind": "landmarks", "options": {"method": "paper", "interest_points": 8}});
    client.put("/v1/databases/lab", options).await.unwrap().expect(201);
    for number in 1..=2 {
        let path = format!("/v1/databases/lab/exemplars?label=place-{number}");
        client.post_picture(&path, scene_png(number)).await.unwrap().expect(201);
    }
    let job = client.post("/v1/databases/lab/trainings", json!({})).await.unwrap().expect(202);
    let job = client.ended(job["id"].as_str().unwrap()).await.unwrap();
    assert_eq!(job["state"], "succeeded", "{job:#}");
    (process, client)
}

/// While the disk takes nothing: writes are refused with what to do, recognition goes on.
async fn refuses(client: &Client, advice: &str) {
    for round in 0..20 {
        let upload = "/v1/databases/lab/exemplars?label=late";
        let answer = client.post_picture(upload, scene_png(100 + round)).await.unwrap();
        assert!(answer.retry_after.is_some());
        let problem = answer.expect(503);
        assert_eq!(problem["code"], "blobs_unavailable");
        assert!(problem["detail"].as_str().unwrap().contains(advice), "{problem:#}");

        let answer =
            client.put(&format!("/v1/databases/late-{round}"), json!({"kind": "objects"})).await.unwrap();
        // A row may have found room in what the log has already.
        if !answer.is_well() {
            assert!(answer.retry_after.is_some());
            let problem = answer.expect(503);
            assert_eq!(problem["code"], "catalogue_unavailable", "{problem:#}");
        }
        let lists = client.get("/v1/databases/lab/exemplars").await.unwrap();
        assert!([200, 503].contains(&lists.status));
        client.post_picture("/v1/databases/lab/recognitions", scene_png(1)).await.unwrap().expect(200);
        client.get("/livez").await.unwrap().expect(200);
    }
}

async fn heals(client: &Client, folder: &Path) {
    let started = Instant::now();
    loop {
        let late =
            client.post_picture("/v1/databases/lab/exemplars?label=late", scene_png(100)).await.unwrap();
        if late.is_well() {
            break;
        }
        assert!(late.status == 503 && started.elapsed() < Duration::from_secs(10), "{:#}", late.json());
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    println!("writes are taken again {:?} after the disk takes them", started.elapsed());
    let job = client.post("/v1/databases/lab/trainings", json!({})).await.unwrap().expect(202);
    let job = client.ended(job["id"].as_str().unwrap()).await.unwrap();
    assert_eq!((&job["state"], &job["version"]), (&json!("succeeded"), &json!(2)), "{job:#}");
    assert_eq!(client.get("/readyz").await.unwrap().expect(200)["status"], "ready");
    verify(folder).unwrap();
    let leftover = unfinished(&folder.join("blobs"));
    assert!(leftover.is_empty(), "what wasn't written whole is left: {leftover:?}");
}

/// Files of writes that were not ended.
fn unfinished(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(unfinished(&path));
        } else if path.to_string_lossy().contains('#') {
            found.push(path);
        }
    }
    found
}

#[tokio::test(flavor = "multi_thread")]
async fn a_full_disk_refuses_writes_with_what_to_do_and_heals_when_there_is_room() {
    let Some(disk) = SmallDisk::new(16 << 20) else {
        println!("skipped: mounting isn't allowed here; the fault points show the same");
        return;
    };
    let folder = disk.path.join("data");
    let (_process, client) = trained(&folder, None).await;
    disk.fill();
    refuses(&client, "full").await;
    disk.make_room();
    heals(&client, &folder).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_disk_that_fails_every_write_is_refused_until_it_is_well() {
    for (fault, advice) in [(Fault::Full, "full"), (Fault::ReadOnly, "no writes"), (Fault::Broken, "disk")] {
        let (folder, faults) = (tempfile::tempdir().unwrap(), Faults::new());
        let (_process, client) = trained(folder.path(), Some(&faults)).await;
        faults.always(fault);
        refuses(&client, advice).await;
        assert!(faults.failed() > 0);
        faults.heal();
        heals(&client, folder.path()).await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn the_write_ahead_log_stays_small_under_writes_without_end() {
    let folder = tempfile::tempdir().unwrap();
    let process = Process::start(folder.path());
    let client = Client::new(&process);
    client.ready("").await;
    let log = folder.path().join("catalogue.sqlite-wal");
    let mut largest = 0;
    for round in 0..1500 {
        let options =
            json!({"kind": "landmarks", "options": {"method": "paper", "interest_points": 1 + round % 50}});
        let answer = client.put(&format!("/v1/databases/lab-{}", round % 100), options).await.unwrap();
        assert!(answer.is_well(), "{:#}", answer.json());
        largest = largest.max(std::fs::metadata(&log).map_or(0, |file| file.len()));
    }
    println!("largest log of 1500 writes: {} KiB", largest >> 10);
    // A thousand pages, where it begins anew, and what a transaction may add.
    assert!(largest < 8 << 20, "{largest} bytes");
}
