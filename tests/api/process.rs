//! The real binary as a process of its own, on a port that the system chooses.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use serde_json::Value;

/// Longer than a shutdown may take, on a busy machine.
const TERMINATION_PATIENCE: Duration = Duration::from_secs(60);

/// The binary with nothing of this process's own settings.
pub fn landmarkd() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_landmarkd"));
    for (name, _) in std::env::vars_os() {
        if name.to_string_lossy().starts_with("LANDMARKD_") {
            command.env_remove(name);
        }
    }
    command
}

/// A service that runs; killed when it is dropped.
pub struct Process {
    child: Child,
    /// Where it listens, as `http://address`.
    pub url: String,
    log: Option<JoinHandle<Vec<String>>>,
}

impl Process {
    /// Start the service over a folder, and wait until it listens.
    pub fn start(folder: &Path) -> Self {
        Self::start_with(folder, |_| ())
    }

    /// The same with more said on the command line or in the environment.
    pub fn start_with(folder: &Path, say: impl FnOnce(&mut Command)) -> Self {
        Self::try_start_with(folder, say).unwrap_or_else(|log| panic!("the service doesn't listen: {log:#?}"))
    }

    /// The same; the log of one that ended, or hasn't come as far as to listen after a while.
    pub fn try_start_with(folder: &Path, say: impl FnOnce(&mut Command)) -> Result<Self, Vec<String>> {
        let mut command = landmarkd();
        command
            .args(["serve", "--threads", "2", "--log-format", "json", "--data-dir"])
            .arg(folder)
            // Not a flag, so that one may say otherwise.
            .env("LANDMARKD_BIND", "127.0.0.1:0")
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        say(&mut command);
        let mut child = command.spawn().unwrap();
        let (found, address) = mpsc::channel();
        let stderr = BufReader::new(child.stderr.take().unwrap());
        let log = std::thread::spawn(move || {
            let mut lines = Vec::new();
            let mut stderr = stderr.lines().map_while(Result::ok);
            for line in stderr.by_ref() {
                let event: Value = serde_json::from_str(&line).unwrap_or_default();
                let address = event["address"].as_str().map(str::to_owned);
                lines.push(line);
                if let Some(address) = address {
                    // Nobody waits any more if it came late.
                    let _ = found.send(address);
                    break;
                }
            }
            lines.extend(stderr);
            lines
        });
        // The other end is dropped when the process ends.
        let Ok(address) = address.recv_timeout(Duration::from_secs(20)) else {
            let _ = child.kill();
            let _ = child.wait();
            return Err(log.join().unwrap());
        };
        Ok(Self { child, url: format!("http://{address}"), log: Some(log) })
    }

    /// The address without its scheme.
    pub fn address(&self) -> &str {
        self.url.strip_prefix("http://").unwrap()
    }

    /// Its number in the system.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Send it a signal by its name, such as `STOP`.
    pub fn signal(&self, name: &str) {
        let sent = Command::new("kill").arg(format!("-{name}")).arg(self.id().to_string()).status().unwrap();
        assert!(sent.success());
    }

    /// End it as a power cut would.
    pub fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// Ask it to end, as a supervisor does, and wait until it has; its exit status and its log.
    pub fn terminate(mut self) -> (ExitStatus, Vec<String>) {
        self.signal("TERM");
        let begun = Instant::now();
        let status = loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                break status;
            }
            assert!(begun.elapsed() < TERMINATION_PATIENCE, "the service doesn't end");
            std::thread::sleep(Duration::from_millis(5));
        };
        let log = self.log.take().unwrap().join().unwrap();
        (status, log)
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
