//! The fault points: a library that is loaded into the real binary and counts, fails or cuts short every call by which it
//! changes a file below its data folder. The product has no code for it.

use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

/// What happens at a fault point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// The process dies before the call.
    Die,
    /// It dies when half of the bytes are written.
    Tear,
    /// It dies before the call, and what it appended to files and hasn't synced is gone.
    Lose,
    Full,
    Broken,
    ReadOnly,
}

impl Fault {
    pub const DEATHS: [Self; 3] = [Self::Die, Self::Tear, Self::Lose];
    pub const FAILURES: [Self; 3] = [Self::Full, Self::Broken, Self::ReadOnly];

    /// The number that `faults.c` has for it: an errno, or a death.
    fn number(self) -> u64 {
        match self {
            Self::Die => 1000,
            Self::Tear => 1001,
            Self::Lose => 1002,
            Self::Full => 28,
            Self::Broken => 5,
            Self::ReadOnly => 30,
        }
    }
}

/// The fault points of one process.
pub struct Faults {
    control: File,
    path: PathBuf,
}

/// Places of the numbers in `struct control`.
const CALLS: u64 = 0;
const AT: u64 = 8;
const LASTING: u64 = 16;
const HOW: u64 = 24;
const FAULTS: u64 = 32;

impl Faults {
    /// Fault points that only count, until more is asked of them.
    pub fn new() -> Self {
        static NUMBER: AtomicU64 = AtomicU64::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let path =
            Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("faults-{}-{number}", std::process::id()));
        let control = File::options().read(true).write(true).create(true).truncate(true).open(&path).unwrap();
        control.set_len(40).unwrap();
        Self { control, path }
    }

    /// Load the library into a process over that folder, which must be there.
    pub fn load(&self, command: &mut Command, folder: &Path) {
        command
            .env("LD_PRELOAD", library())
            .env("FAULTS_FOLDER", folder.canonicalize().unwrap())
            .env("FAULTS_CONTROL", &self.path);
    }

    /// The call of that number from the process's first one on; `lasting`, and all after it.
    pub fn at(&self, call: u64, fault: Fault, lasting: bool) {
        self.set(HOW, fault.number());
        self.set(LASTING, lasting.into());
        self.set(AT, call);
    }

    /// Every call from now on.
    pub fn always(&self, fault: Fault) {
        self.at(self.calls() + 1, fault, true);
    }

    pub fn heal(&self) {
        self.set(AT, 0);
    }

    /// Calls until now.
    pub fn calls(&self) -> u64 {
        self.number(CALLS)
    }

    /// Calls that failed until now.
    pub fn failed(&self) -> u64 {
        self.number(FAULTS)
    }

    fn number(&self, place: u64) -> u64 {
        let mut bytes = [0; 8];
        self.control.read_exact_at(&mut bytes, place).unwrap();
        u64::from_ne_bytes(bytes)
    }

    fn set(&self, place: u64, number: u64) {
        self.control.write_all_at(&number.to_ne_bytes(), place).unwrap();
    }
}

impl Drop for Faults {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.path);
    }
}

/// The library, built once.
fn library() -> &'static Path {
    static LIBRARY: OnceLock<PathBuf> = OnceLock::new();
    LIBRARY.get_or_init(|| {
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/crash/faults.c");
        let built = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("faults-{}.so", std::process::id()));
        let mut compiler = Command::new("cc");
        compiler.args(["-shared", "-fPIC", "-O1", "-o"]).arg(&built).arg(source).arg("-ldl");
        assert!(compiler.status().expect("a C compiler, cc").success());
        built
    })
}
