//! A bag of answers: the frames, and with the stamp of each what was said of it, as messages of ROS 2.
//!
//! | topic | type | what |
//! | --- | --- | --- |
//! | `/landmarkd/image/compressed` | `sensor_msgs/CompressedImage` | the frame, as it was sent |
//! | `/landmarkd/drawn/compressed` | `sensor_msgs/CompressedImage` | the frame with the evidence drawn on it |
//! | `/landmarkd/outlines` | `foxglove_msgs/ImageAnnotations` | where the training pictures lie in it, and the decision |
//! | `/landmarkd/detections` | `vision_msgs/Detection2DArray` | the votes, with their share and their box |
//! | `/landmarkd/decision` | `std_msgs/String` | the label; empty: unknown |
//! | `/landmarkd/pose` | `geometry_msgs/PoseWithCovarianceStamped` | where the camera's body is, by the answer |
//! | `/landmarkd/true_pose` | `geometry_msgs/PoseStamped` | the same by the bag |

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use mcap::records::MessageHeader;
use mcap::{WriteOptions, Writer};
use serde::Serialize;

use super::BagError;
use super::ask::{Answer, AnsweredPose, Vote};
use super::contents::BagPicture;
use super::definitions::definition;
use super::messages::{
    CompressedImage, Header, Point, Pose, PoseStamped, PoseWithCovarianceStamped, Quaternion, Text, Time,
    written,
};

/// Standard deviation of what an answer says nothing about (height, pitch and roll): larger than any robot's.
const UNSAID_M_OR_RAD: f64 = 1e3;

/// A bag that is being written.
pub struct AnswerBag {
    path: PathBuf,
    /// The frame of the bag's own poses.
    map: String,
    writer: Writer<BufWriter<File>>,
    /// Id and number of messages by topic.
    channels: BTreeMap<&'static str, (u16, u32)>,
}

impl AnswerBag {
    /// An empty bag; a file of that name is overwritten.
    ///
    /// # Errors
    /// [`BagError::Write`].
    pub fn create(path: &Path, map: String) -> Result<AnswerBag, BagError> {
        let failed = |source| BagError::Write { path: path.to_path_buf(), source };
        let file = File::create(path).map_err(|source| failed(source.into()))?;
        let options = WriteOptions::new().profile("ros2").library("landmarkd");
        let writer = options.create(BufWriter::new(file)).map_err(failed)?;
        Ok(AnswerBag { path: path.to_path_buf(), map, writer, channels: BTreeMap::new() })
    }

    /// Adds the answer about a picture, and the picture with the evidence drawn on it if there is one.
    ///
    /// # Errors
    /// [`BagError::Write`].
    pub fn add(
        &mut self,
        picture: &BagPicture,
        file: &[u8],
        answer: &Answer,
        drawn: Option<&[u8]>,
    ) -> Result<(), BagError> {
        let ns = picture.stamp_ns;
        let stamp = Time::of_ns(ns);
        let header = Header { stamp, frame_id: picture.header.frame_id.clone() };
        let image = |bytes| {
            let format = if is_png(bytes) { "png" } else { "jpeg" };
            CompressedImage { header: header.clone(), format: format.to_owned(), data: bytes }
        };
        self.write("/landmarkd/image/compressed", "sensor_msgs/CompressedImage", ns, &image(file))?;
        if let Some(drawn) = drawn {
            self.write("/landmarkd/drawn/compressed", "sensor_msgs/CompressedImage", ns, &image(drawn))?;
        }
        let outlines = annotations(stamp, answer);
        self.write("/landmarkd/outlines", "foxglove_msgs/ImageAnnotations", ns, &outlines)?;
        let detections = answer.votes.iter().map(|vote| detection(&header, vote)).collect();
        let detections = Detections { header: header.clone(), detections };
        self.write("/landmarkd/detections", "vision_msgs/Detection2DArray", ns, &detections)?;
        let label = answer.decision.as_ref().map_or_else(String::new, |decision| decision.label.clone());
        self.write("/landmarkd/decision", "std_msgs/String", ns, &Text { data: label })?;
        if let Some(pose) = &answer.pose {
            let header = Header { stamp, frame_id: pose.map.clone() };
            let pose = pose_message(header, pose);
            self.write("/landmarkd/pose", "geometry_msgs/PoseWithCovarianceStamped", ns, &pose)?;
        }
        if let Some(pose) = &picture.pose {
            let header = Header { stamp, frame_id: self.map.clone() };
            let pose = PoseStamped { header, pose: Pose::of(&pose.transform()) };
            self.write("/landmarkd/true_pose", "geometry_msgs/PoseStamped", ns, &pose)?;
        }
        Ok(())
    }

    /// Ends the file.
    ///
    /// # Errors
    /// [`BagError::Write`].
    pub fn finish(mut self) -> Result<(), BagError> {
        let finished = self.writer.finish();
        finished.map(drop).map_err(|source| BagError::Write { path: self.path, source })
    }

    fn write<T: Serialize>(
        &mut self,
        topic: &'static str,
        type_name: &str,
        stamp_ns: i64,
        message: &T,
    ) -> Result<(), BagError> {
        let written = self.try_write(topic, type_name, stamp_ns, message);
        written.map_err(|source| BagError::Write { path: self.path.clone(), source })
    }

    fn try_write<T: Serialize>(
        &mut self,
        topic: &'static str,
        type_name: &str,
        stamp_ns: i64,
        message: &T,
    ) -> Result<(), mcap::McapError> {
        let (channel_id, sequence) = match self.channels.get(topic) {
            Some(channel) => *channel,
            None => {
                let schema_name = type_name.replacen('/', "/msg/", 1);
                let text = definition(type_name);
                let schema_id = self.writer.add_schema(&schema_name, "ros2msg", text.as_bytes())?;
                (self.writer.add_channel(schema_id, topic, "cdr", &BTreeMap::new())?, 0)
            }
        };
        self.channels.insert(topic, (channel_id, sequence + 1));
        let time = u64::try_from(stamp_ns).unwrap_or(0);
        let header = MessageHeader { channel_id, sequence, log_time: time, publish_time: time };
        self.writer.write_to_known_channel(&header, &written(message))
    }
}

fn is_png(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x89PNG")
}

/// The answered pose on the map's plane.
fn pose_message(header: Header, pose: &AnsweredPose) -> PoseWithCovarianceStamped {
    let mut covariance = [[0.0; 6]; 6];
    for (axis, row) in covariance.iter_mut().enumerate() {
        row[axis] = UNSAID_M_OR_RAD * UNSAID_M_OR_RAD;
    }
    // x, y and the rotation about z of x, y, z and the rotations about them
    let among_six = [0, 1, 5];
    for (n, &row) in among_six.iter().enumerate() {
        for (m, &column) in among_six.iter().enumerate() {
            covariance[row][column] = pose.covariance[3 * n + m];
        }
    }
    PoseWithCovarianceStamped { header, pose: Pose::of(&pose.on_the_plane().transform()), covariance }
}

#[derive(Serialize)]
struct Detections {
    header: Header,
    detections: Vec<Detection>,
}

#[derive(Serialize)]
struct Detection {
    header: Header,
    results: Vec<Hypothesis>,
    bbox: Box2,
    id: String,
}

#[derive(Serialize)]
struct Hypothesis {
    class_id: String,
    score: f64,
    pose: Pose,
    covariance: [[f64; 6]; 6],
}

#[derive(Serialize)]
struct Box2 {
    x: f64,
    y: f64,
    theta: f64,
    size_x: f64,
    size_y: f64,
}

/// A vote with the box around its outline, upright; a box of nothing where it has none.
fn detection(header: &Header, vote: &Vote) -> Detection {
    let placement = vote.placement.as_ref();
    let [[left, right], [top, bottom]] = placement.map_or([[0.0; 2]; 2], |placement| {
        [0, 1].map(|axis| {
            let along = placement.outline_px.map(|corner| corner[axis]);
            [
                along.into_iter().fold(f64::INFINITY, f64::min),
                along.into_iter().fold(f64::NEG_INFINITY, f64::max),
            ]
        })
    });
    let nowhere =
        Pose { position: Point::default(), orientation: Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 } };
    Detection {
        header: header.clone(),
        results: vec![Hypothesis {
            class_id: vote.label.clone(),
            score: vote.share,
            pose: nowhere,
            covariance: [[0.0; 6]; 6],
        }],
        bbox: Box2 {
            x: 0.5 * (left + right),
            y: 0.5 * (top + bottom),
            theta: 0.0,
            size_x: right - left,
            size_y: bottom - top,
        },
        id: placement.and_then(|placement| placement.exemplar.clone()).unwrap_or_default(),
    }
}

#[derive(Serialize)]
struct Annotations {
    /// None are drawn.
    circles: Vec<()>,
    points: Vec<Outline>,
    texts: Vec<Caption>,
}

#[derive(Serialize)]
struct Outline {
    timestamp: Time,
    kind: u8,
    points: Vec<[f64; 2]>,
    outline_color: Colour,
    outline_colors: Vec<Colour>,
    fill_color: Colour,
    thickness: f64,
}

#[derive(Serialize)]
struct Caption {
    timestamp: Time,
    position: [f64; 2],
    text: String,
    font_size: f64,
    text_color: Colour,
    background_color: Colour,
}

/// Red, green, blue, opacity; 0 to 1.
type Colour = [f64; 4];
const DECIDED: Colour = [0.1, 0.9, 0.2, 1.0];
const OTHER: Colour = [0.9, 0.6, 0.1, 0.6];
const NOTHING: Colour = [0.0; 4];
const DARK: Colour = [0.0, 0.0, 0.0, 0.6];
/// `PointsAnnotation.LINE_LOOP`.
const LINE_LOOP: u8 = 2;

/// The outlines of what votes placed, and the decision in the corner.
fn annotations(timestamp: Time, answer: &Answer) -> Annotations {
    let decided = answer.decision.as_ref();
    let is_decided = |vote: &Vote| decided.is_some_and(|decision| decision.label == vote.label);
    let outline = |vote: &Vote| {
        let placement = vote.placement.as_ref()?;
        Some(Outline {
            timestamp,
            kind: LINE_LOOP,
            points: placement.outline_px.to_vec(),
            outline_color: if is_decided(vote) { DECIDED } else { OTHER },
            outline_colors: Vec::new(),
            fill_color: NOTHING,
            thickness: if is_decided(vote) { 3.0 } else { 1.0 },
        })
    };
    let text = match decided {
        Some(decision) => match decision.confidence {
            Some(confidence) => format!("{} {confidence:.3}", decision.label),
            None => decision.label.clone(),
        },
        None => "unknown".to_owned(),
    };
    Annotations {
        circles: Vec::new(),
        points: answer.votes.iter().filter_map(outline).collect(),
        texts: vec![Caption {
            timestamp,
            position: [8.0, 24.0],
            text,
            font_size: 16.0,
            text_color: if decided.is_some() { DECIDED } else { OTHER },
            background_color: DARK,
        }],
    }
}
