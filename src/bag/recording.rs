//! A recorded bag: one MCAP file, or the folder of files that `ros2 bag record` leaves.
//!
//! Files are read from their beginning to their end, whether or not they have an index, so that what a cut file still
//! holds is used; memory grows with the largest chunk alone.

use std::collections::BTreeMap;
use std::fmt;
use std::fs::{self, File};
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use mcap::io::MessageReader;
use mcap::sans_io::LinearReaderOptions;
use mcap::{McapError, Message};
use serde::Deserialize;

use super::BagError;
use super::messages::{self, MessageError};

/// Longest record: a picture of a hundred megapixels. What says it is longer is damaged.
const LONGEST_RECORD_BYTES: usize = 512 << 20;

/// The files of a bag.
#[derive(Debug)]
pub struct Recording {
    files: Vec<PathBuf>,
    bytes: u64,
}

/// A topic of a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topic {
    /// Such as `sensor_msgs/Image`; empty without a schema.
    pub type_name: String,
    /// How its messages are encoded; only `cdr` is read.
    pub encoding: String,
    /// Messages that were read.
    pub messages: usize,
}

/// The topics of a recording, by name.
#[derive(Clone, Debug, Default)]
pub struct Topics(pub BTreeMap<String, Topic>);

/// A file that doesn't end as it should.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Loss {
    /// The file.
    pub file: PathBuf,
    /// Where reading ended, and how long the file is, bytes.
    pub read_bytes: u64,
    /// The length of the file.
    pub file_bytes: u64,
    /// Why.
    pub reason: String,
}

impl Recording {
    /// The bag at a path.
    ///
    /// # Errors
    /// [`BagError`] for what can't be listed, and for bags of other kinds, saying how they are converted.
    pub fn open(path: &Path) -> Result<Recording, BagError> {
        let unreadable = |source| BagError::Read { path: path.to_path_buf(), source };
        let ending = |path: &Path| path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        let files = if fs::metadata(path).map_err(unreadable)?.is_dir() {
            let entries: Result<Vec<_>, _> =
                fs::read_dir(path).map_err(unreadable)?.map(|entry| entry.map(|e| e.path())).collect();
            let entries = entries.map_err(unreadable)?;
            let files = entries.iter().filter(|file| ending(file).as_deref() == Some("mcap"));
            let mut files: Vec<PathBuf> = files.cloned().collect();
            // run_2 comes before run_10
            files.sort_by_key(|file| (file.as_os_str().len(), file.clone()));
            if files.is_empty() {
                let other = entries.iter().find(|file| is_other_bag(ending(file).as_deref()));
                return Err(BagError::NoBag { path: other.map_or(path, |file| file).to_path_buf() });
            }
            files
        } else if is_other_bag(ending(path).as_deref()) {
            return Err(BagError::NoBag { path: path.to_path_buf() });
        } else {
            vec![path.to_path_buf()]
        };
        let mut bytes = 0;
        for file in &files {
            bytes += fs::metadata(file).map_err(unreadable)?.len();
        }
        Ok(Recording { files, bytes })
    }

    /// Whether a path is that of a bag: an MCAP file, or a folder with some.
    pub fn is_at(path: &Path) -> bool {
        let is_mcap = |path: &Path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("mcap"));
        is_mcap(path)
            || fs::read_dir(path).is_ok_and(|entries| entries.flatten().any(|entry| is_mcap(&entry.path())))
    }

    /// The length of all files.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Gives every message to `visit`, with how many bytes were read so far, in the order of the files.
    /// Returns the files that end too soon.
    ///
    /// # Errors
    /// [`BagError`] for a file that can't be opened or is no MCAP at all, and what `visit` returns.
    pub fn each_message<E: From<BagError>>(
        &self,
        mut visit: impl FnMut(&Message<'static>, u64) -> Result<(), E>,
    ) -> Result<Vec<Loss>, E> {
        let mut losses = Vec::new();
        let mut before = 0;
        for path in &self.files {
            let unreadable = |source| BagError::Read { path: path.clone(), source };
            let file = File::open(path).map_err(unreadable)?;
            let file_bytes = file.metadata().map_err(unreadable)?.len();
            let count = Arc::new(AtomicU64::new(0));
            let source =
                Counted { source: BufReader::with_capacity(1 << 20, file), count: Arc::clone(&count) };
            let options = LinearReaderOptions::default().with_record_length_limit(LONGEST_RECORD_BYTES);
            for message in MessageReader::new_with_options(source, options) {
                let read_bytes = count.load(Ordering::Relaxed);
                match message {
                    Ok(message) => visit(&message, before + read_bytes)?,
                    Err(McapError::BadMagic) if read_bytes <= 8 => {
                        return Err(BagError::NoBag { path: path.clone() }.into());
                    }
                    Err(error) => losses.push(Loss {
                        file: path.clone(),
                        read_bytes,
                        file_bytes,
                        reason: error.to_string(),
                    }),
                }
            }
            before += file_bytes;
        }
        Ok(losses)
    }
}

/// Bags of ROS 1, and those of ROS 2 in SQLite.
fn is_other_bag(ending: Option<&str>) -> bool {
    matches!(ending, Some("bag" | "db3"))
}

struct Counted<R> {
    source: R,
    count: Arc<AtomicU64>,
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        let read = self.source.read(into)?;
        self.count.fetch_add(read as u64, Ordering::Relaxed);
        Ok(read)
    }
}

impl Topics {
    /// Counts a message; returns its type.
    pub fn count(&mut self, message: &Message<'_>) -> String {
        let type_name = type_name(message);
        match self.0.get_mut(&message.channel.topic) {
            Some(topic) => topic.messages += 1,
            None => {
                let encoding = message.channel.message_encoding.clone();
                let topic = Topic { type_name: type_name.clone(), encoding, messages: 1 };
                self.0.insert(message.channel.topic.clone(), topic);
            }
        }
        type_name
    }
}

impl fmt::Display for Topics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() {
            return write!(f, "it holds no messages");
        }
        write!(f, "its topics are")?;
        for (n, (name, topic)) in self.0.iter().enumerate() {
            let comma = if n == 0 { "" } else { "," };
            write!(f, "{comma} {name} ({}, {} messages)", topic.type_name, topic.messages)?;
        }
        Ok(())
    }
}

impl fmt::Display for Loss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Loss { file, read_bytes, file_bytes, reason } = self;
        let percent = 100.0 * *read_bytes as f64 / (*file_bytes).max(1) as f64;
        write!(
            f,
            "{} could be read up to byte {read_bytes} of {file_bytes} ({percent:.0} %): {reason}. What comes before is used; \
             `mcap recover` makes a whole file of it",
            file.display()
        )
    }
}

/// `package/Type` of a message: `sensor_msgs/msg/Image` and `sensor_msgs/Image` are one.
pub fn type_name(message: &Message<'_>) -> String {
    message.channel.schema.as_ref().map_or_else(String::new, |schema| schema.name.replacen("/msg/", "/", 1))
}

/// The message, if it is encoded as ROS 2 encodes.
///
/// # Errors
/// [`BagError::Encoding`] for others, [`BagError::Message`] for bytes that aren't of the type.
pub fn read<'a, T: Deserialize<'a>>(message: &'a Message<'_>) -> Result<T, BagError> {
    let channel = &message.channel;
    if channel.message_encoding != "cdr" {
        return Err(BagError::Encoding {
            topic: channel.topic.clone(),
            encoding: channel.message_encoding.clone(),
        });
    }
    messages::read(&message.data).map_err(|source: MessageError| BagError::Message {
        topic: channel.topic.clone(),
        type_name: type_name(message),
        source,
    })
}
