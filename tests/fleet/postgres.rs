//! A private PostgreSQL cluster for tests, from the server programs of Debian's package `postgresql`.
//!
//! It lives in a temporary folder and listens only on a Unix socket there. As root its programs run as the user
//! `postgres`, since they refuse to run as root. A guard, a small shell, stops it and removes the folder when its
//! standard input closes: that is when the cluster is dropped, or when this process ends, in whatever way.

use std::io::{BufRead, BufReader};
use std::os::unix::fs::MetadataExt;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

/// Makes the folder and tells its name, waits for the end of its input, cleans up.
const GUARD: &str = r#"
folder=$(mktemp -d /tmp/landmarkd-postgres.XXXXXX) || exit
echo "$folder"
read -r _
"$1" -D "$folder/data" -m immediate stop >/dev/null 2>&1
rm -rf "$folder"
"#;

/// A running cluster, or one that was stopped for a while.
pub struct Cluster {
    programs: PathBuf,
    folder: PathBuf,
    guard: Child,
    databases: AtomicU32,
}

/// How a cluster is stopped.
#[derive(Clone, Copy)]
pub enum Stop {
    /// In order: every connection is told and closed.
    Fast,
    /// As if its machine had died.
    Immediate,
}

impl Cluster {
    /// Makes a cluster and starts it; panics with the reason where that fails.
    pub fn start_new() -> Self {
        let programs = programs();
        let mut guard = as_server_user(Path::new("sh"))
            .args(["-c", GUARD, "guard"])
            .arg(programs.join("pg_ctl"))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            // What ends the tests as a group of processes must leave it to clean up.
            .process_group(0)
            .spawn()
            .expect("the guard's shell must start");
        let mut folder = String::new();
        let told = BufReader::new(guard.stdout.take().unwrap()).read_line(&mut folder);
        told.expect("the guard must tell its folder");
        let folder = PathBuf::from(folder.trim_end());
        let cluster = Self { programs, folder, guard, databases: AtomicU32::new(0) };
        let data = cluster.data();
        cluster.run(
            "initdb",
            &["--no-sync", "--auth=trust", "--username=postgres", "--encoding=UTF8", "-D", &data],
        );
        cluster.start();
        cluster
    }

    /// Starts the cluster, and waits until it takes connections.
    pub fn start(&self) {
        let folder = self.folder.display();
        let settings = format!(
            "-c fsync=off -c max_connections=100 -c listen_addresses= -c unix_socket_directories={folder}"
        );
        let log = format!("{folder}/log");
        self.run("pg_ctl", &["-D", &self.data(), "-l", &log, "-o", &settings, "-w", "start"]);
    }

    /// Stops the cluster; its databases stay.
    pub fn stop(&self, how: Stop) {
        let mode = match how {
            Stop::Fast => "fast",
            Stop::Immediate => "immediate",
        };
        self.run("pg_ctl", &["-D", &self.data(), "-m", mode, "-w", "stop"]);
    }

    /// Makes an empty database, and gives its address.
    pub fn create_database(&self) -> String {
        let name = format!("test{}", self.databases.fetch_add(1, Ordering::Relaxed));
        let folder = self.folder.display().to_string();
        self.run("createdb", &["-h", &folder, "-U", "postgres", &name]);
        self.address("postgres", &name)
    }

    /// The address of a database for a user, there or not.
    pub fn address(&self, user: &str, database: &str) -> String {
        format!("postgres://{user}@localhost/{database}?host={}", self.folder.display())
    }

    /// Connections of clients that it has now.
    pub fn connections(&self) -> usize {
        let asked = "SELECT count(*) FROM pg_stat_activity WHERE application_name = 'landmarkd'";
        self.sql(&self.address("postgres", "postgres"), asked).parse().expect("a number")
    }

    /// Runs statements in the database at an address, past the service; what they give.
    pub fn sql(&self, address: &str, statements: &str) -> String {
        let mut psql = as_server_user(&self.programs.join("psql"));
        let output = psql.args(["-Atqc", statements, address]).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).trim().to_owned()
    }

    fn data(&self) -> String {
        format!("{}/data", self.folder.display())
    }

    #[track_caller]
    fn run(&self, program: &str, arguments: &[&str]) {
        let output = as_server_user(&self.programs.join(program)).args(arguments).output().unwrap();
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{program} {arguments:?}: {}: {error}", output.status);
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        drop(self.guard.stdin.take());
        self.guard.wait().ok();
    }
}

/// The folder of the newest server's programs.
fn programs() -> PathBuf {
    let versions = std::fs::read_dir("/usr/lib/postgresql").expect("install Debian's package postgresql");
    let newest = versions.filter_map(|version| version.ok()?.file_name().to_str()?.parse::<u32>().ok()).max();
    Path::new("/usr/lib/postgresql").join(newest.expect("a server's version").to_string()).join("bin")
}

/// A command as a user that the server's programs are willing to run as.
fn as_server_user(program: &Path) -> Command {
    let is_root = std::fs::metadata("/proc/self").is_ok_and(|process| process.uid() == 0);
    let mut command = if is_root {
        let mut command = Command::new("runuser");
        command.args(["-u", "postgres", "--"]).arg(program);
        command
    } else {
        Command::new(program)
    };
    command.current_dir("/");
    command
}
