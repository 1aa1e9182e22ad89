//! Bags: what a robot recorded (MCAP, ROS 2), and the verbs that teach a service from it (`teach`) and ask one about it
//! (`ask`), both through the HTTP contract.
//!
//! [`Recording`] is the file, `messages` the types in it, [`TransformTree`] where its frames stand, [`Contents`] what its pictures
//! and poses are; `selection` leaves out the pictures that teach nothing; `answers` writes a bag of answers. Frames are
//! those of REP 103 and REP 105, times those of the messages' own stamps.

mod answers;
mod ask;
mod contents;
mod definitions;
mod evaluation;
mod labels;
mod messages;
mod raw_image;
mod recording;
mod selection;
mod teach;
mod transform_tree;

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use thiserror::Error;
use tokio::sync::mpsc;
use tokio::task::{JoinHandle, spawn_blocking};

use crate::client::{ClientError, Server};
use contents::{BagPicture, Contents};
use messages::MessageError;

pub use ask::{AskArgs, AskSummary, PositionErrors, ask};
pub use contents::BagArgs;
pub use evaluation::BagEvaluationArgs;
pub use labels::LabelArgs;
pub use recording::Recording;
pub use selection::SelectionArgs;
pub use teach::{TeachArgs, TeachSummary, teach};

/// Which service is called.
#[derive(Args, Clone, Debug)]
pub struct ServiceArgs {
    /// The service
    #[arg(long, value_name = "URL", default_value = "http://127.0.0.1:8080")]
    pub server: String,
    /// The key that calls come with
    #[arg(long, env = "LANDMARKD_KEY", hide_env_values = true, value_name = "KEY")]
    pub key: Option<String>,
    /// The certificates that a service with TLS is trusted by, as PEM
    #[arg(long, value_name = "FILE")]
    pub ca_cert: Option<PathBuf>,
}

impl ServiceArgs {
    /// The service.
    ///
    /// # Errors
    /// [`ClientError`] naming the argument that can't be used.
    pub fn connect(&self) -> Result<Server, ClientError> {
        let key = self.key.as_deref().filter(|key| !key.is_empty());
        Server::at(&self.server, key, self.ca_cert.as_deref())
    }
}

/// Why a bag could not be used.
#[derive(Debug, Error)]
pub enum BagError {
    /// A file or folder can't be read.
    #[error("can't read {}", .path.display())]
    Read {
        /// The file or folder.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// Something else than MCAP.
    #[error(
        "{} is no MCAP bag of ROS 2. A bag of ROS 1 (.bag) or of SQLite (.db3) is converted with `pip install rosbags` and \
         `rosbags-convert --src BAG --dst FOLDER --dst-storage mcap`; one that is compressed as a file (.zstd) is unpacked first",
        .path.display()
    )]
    NoBag {
        /// The file or folder.
        path: PathBuf,
    },
    /// A topic isn't there.
    #[error("there is no topic {wanted}: {option} names one of type {types}; {topics}")]
    NoTopic {
        /// The topic, and what for.
        wanted: String,
        /// The option that names it.
        option: &'static str,
        /// The types that would do.
        types: String,
        /// The topics that there are.
        topics: String,
    },
    /// Several topics have pictures.
    #[error("several topics have pictures: --image-topic names one of {topics}")]
    SeveralTopics {
        /// The topics, with how many pictures.
        topics: String,
    },
    /// A topic's messages have another type.
    #[error("{topic} has messages of type {type_name:?}, which isn't read here: {wanted} are")]
    Schema {
        /// The topic.
        topic: String,
        /// Its type.
        type_name: String,
        /// The types that are read.
        wanted: String,
    },
    /// A topic isn't encoded as ROS 2 does.
    #[error(
        "the messages of {topic} are encoded as {encoding:?}, only \"cdr\" of ROS 2 is read: a bag of ROS 1 is converted with \
         `rosbags-convert --src BAG --dst FOLDER --dst-storage mcap` (pip install rosbags)"
    )]
    Encoding {
        /// The topic.
        topic: String,
        /// Its encoding.
        encoding: String,
    },
    /// A message isn't what its schema says.
    #[error("a message of {topic} can't be read as {type_name}")]
    Message {
        /// The topic.
        topic: String,
        /// Its type.
        type_name: String,
        /// The cause.
        source: MessageError,
    },
    /// No picture can be used.
    #[error("no picture of {topic} can be used: {reason}")]
    NoPictures {
        /// The topic of the pictures.
        topic: String,
        /// Why.
        reason: String,
    },
    /// A name that can't be one.
    #[error("{what} {name:?} {reason}")]
    Name {
        /// What is called so.
        what: &'static str,
        /// The name.
        name: String,
        /// Why not.
        reason: String,
    },
    /// Neither a label nor poses to make some of.
    #[error(
        "nothing says what the pictures show: --label gives all of them one label, or poses (--pose-topic) give each the label of \
         its cell of the map"
    )]
    NoLabels,
    /// A call went wrong; what was sent before is kept, and isn't sent twice.
    #[error("a call to the service failed (what was sent before is kept, and isn't sent twice)")]
    Client {
        /// The cause.
        #[from]
        source: ClientError,
    },
    /// The bag of answers can't be written.
    #[error("can't write {}", .path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: mcap::McapError,
    },
    /// The output can't be written.
    #[error("can't print")]
    Print(#[from] io::Error),
}

/// Reads a bag the first time, with a progress bar, and prints what it holds.
fn read_once(path: &Path, args: &BagArgs, out: &mut dyn io::Write) -> Result<Contents, BagError> {
    let bar = bar_of(0);
    let contents = Contents::of(path, args, &mut |done, all| {
        bar.set_length(all);
        bar.set_position(done);
    });
    bar.finish_and_clear();
    let contents = contents?;
    let [first_ns, last_ns] = contents.span_ns;
    writeln!(
        out,
        "{}: {} pictures on {} ({}), {:.1} s",
        path.display(),
        contents.pictures,
        contents.image_topic,
        contents.image_type,
        (last_ns - first_ns) as f64 / 1e9
    )?;
    for note in &contents.notes {
        writeln!(out, "  {note}")?;
    }
    for (count, what) in [
        (
            contents.late_pictures,
            "pictures came after one of a later stamp; each has the pose of its own stamp",
        ),
        (contents.late_poses, "poses came after one of a later stamp, and were brought into order"),
        (contents.unstamped, "pictures have no stamp of their own: the time of recording stands in"),
    ] {
        if count > 0 {
            writeln!(out, "  {count} {what}")?;
        }
    }
    for loss in &contents.losses {
        writeln!(out, "  damaged: {loss}")?;
    }
    Ok(contents)
}

/// A bar of so many bytes; hidden without a terminal, so that a log holds the result alone.
fn bar_of(bytes: u64) -> ProgressBar {
    let style =
        ProgressStyle::with_template("{bar:40} {bytes}/{total_bytes} {msg}").expect("the template is one");
    ProgressBar::new(bytes).with_style(style)
}

/// Pictures that wait for the service at most.
const PICTURES_AHEAD: usize = 4;

/// Reads the pictures of a bag on a thread of its own, while earlier ones are sent. `take` makes of each picture, and at last of the
/// bag's end (`None`), what is sent; `state` is its own, and comes back when the bag was read. Ends early when nobody
/// receives any more.
fn read_ahead<S: Send + 'static, T: Send + 'static>(
    contents: &Arc<Contents>,
    mut state: S,
    mut take: impl FnMut(&mut S, Option<BagPicture>, u64) -> Vec<T> + Send + 'static,
) -> (mpsc::Receiver<T>, JoinHandle<Result<S, BagError>>) {
    let (sender, receiver) = mpsc::channel(PICTURES_AHEAD);
    let contents = Arc::clone(contents);
    let reading = spawn_blocking(move || {
        let send_all = |taken: Vec<T>| taken.into_iter().all(|one| sender.blocking_send(one).is_ok());
        let mut received = true;
        contents.each_picture(|picture, read_bytes| {
            received = send_all(take(&mut state, Some(picture), read_bytes));
            received
        })?;
        if received {
            send_all(take(&mut state, None, contents.bytes()));
        }
        Ok(state)
    });
    (receiver, reading)
}
