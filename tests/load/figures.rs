//! What is counted, and how long it is counted for.

use std::fmt::Display;
use std::fs;
use std::str::FromStr;
use std::time::Duration;

use crate::client::Answer;

/// A number that the environment may change.
pub fn number<T: FromStr<Err: std::fmt::Debug>>(name: &str, otherwise: T) -> T {
    std::env::var(name).map_or(otherwise, |given| given.parse().unwrap())
}

/// How long a load lasts.
pub fn load_lasts() -> Duration {
    Duration::from_secs(number("LANDMARKD_LOAD_SECONDS", 60))
}

/// Times, in order.
pub struct Times(Vec<Duration>);

impl Times {
    pub fn of<'a>(answers: impl IntoIterator<Item = &'a Answer>) -> Self {
        let mut times: Vec<_> = answers.into_iter().map(|answer| answer.took).collect();
        times.sort_unstable();
        assert!(!times.is_empty(), "something was asked");
        Self(times)
    }

    /// The time that so many of a hundred don't exceed.
    pub fn percentile(&self, percent: usize) -> Duration {
        self.0[(self.0.len() * percent).div_ceil(100).max(1) - 1]
    }
}

impl Display for Times {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ms = |percent| self.percentile(percent).as_secs_f64() * 1e3;
        let (count, most) = (self.0.len(), ms(100));
        write!(formatter, "p50 {:.1} ms, p99 {:.1} ms, most {most:.1} ms of {count}", ms(50), ms(99))
    }
}

/// A figure of `/proc/<id>/status` in bytes, such as `VmHWM`; on Linux.
pub fn memory_bytes(process: u32, figure: &str) -> u64 {
    let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix(figure)?.strip_prefix(':')).unwrap();
    line.trim().strip_suffix(" kB").unwrap().parse::<u64>().unwrap() << 10
}

/// How many files and sockets a process has open; on Linux.
pub fn open_files(process: u32) -> usize {
    fs::read_dir(format!("/proc/{process}/fd")).unwrap().count()
}

/// What this process, the one that asks, has computed for, in seconds.
pub fn cpu_seconds() -> f64 {
    let told = std::fs::read_to_string("/proc/self/stat").unwrap();
    // Behind the name, which may hold anything: fields 14 and 15, in hundredths.
    let mut fields = told.rsplit(')').next().unwrap().split_whitespace().skip(11);
    let mut ticks = || fields.next().unwrap().parse::<f64>().unwrap();
    (ticks() + ticks()) / 100.0
}
