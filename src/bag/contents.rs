//! What a bag holds, from a first reading of it: its topics, its frames and their motion, its camera; and then its pictures,
//! each with its pose, from a second.

use std::path::Path;

use clap::Args;
use landmarkd_core::geometry::{Camera, MapPose, RigidTransform};
use mcap::Message;

use super::BagError;
use super::messages::{
    CameraInfo, CompressedImage, Header, Image, Odometry, Pose, PoseStamped, TfMessage, Time,
};
use super::raw_image::png_of;
use super::recording::{Loss, Recording, Topics, read, type_name};
use super::transform_tree::{NoTransform, TransformTree};
use crate::database::Name;

const IMAGE: &str = "sensor_msgs/Image";
const COMPRESSED_IMAGE: &str = "sensor_msgs/CompressedImage";
const CAMERA_INFO: &str = "sensor_msgs/CameraInfo";
const ODOMETRY: &str = "nav_msgs/Odometry";
const POSE: &str = "geometry_msgs/PoseStamped";
const POSE_WITH_COVARIANCE: &str = "geometry_msgs/PoseWithCovarianceStamped";
const TF: &str = "tf2_msgs/TFMessage";
const IMAGES: [&str; 2] = [IMAGE, COMPRESSED_IMAGE];
const POSES: [&str; 3] = [POSE, POSE_WITH_COVARIANCE, ODOMETRY];

/// The robot's frame where nothing says another.
const BASE: &str = "base_link";

/// Where a bag's pictures and poses are.
#[derive(Args, Clone, Debug)]
pub struct BagArgs {
    /// The pictures, sensor_msgs Image or CompressedImage [default: the only topic of these types]
    #[arg(long, value_name = "TOPIC")]
    pub image_topic: Option<String>,
    /// Poses of the robot's base: PoseWithCovarianceStamped, PoseStamped or Odometry [default: what /tf has]
    #[arg(long, value_name = "TOPIC")]
    pub pose_topic: Option<String>,
    /// The camera's intrinsics [default: camera_info beside the pictures]
    #[arg(long, value_name = "TOPIC")]
    pub camera_info_topic: Option<String>,
    /// The frame that poses are to be in
    #[arg(long, value_name = "FRAME", default_value = "map")]
    pub map_frame: String,
    /// What the map is called, where there are several, such as floors [default: as its frame]
    #[arg(long, value_name = "NAME", value_parser = map_of_text)]
    pub map: Option<Name>,
    /// The frame whose poses --pose-topic has [default: the top of /tf_static above the camera, else base_link]
    #[arg(long, value_name = "FRAME")]
    pub base_frame: Option<String>,
    /// The camera's frame; optical if it has `optical` in its name, else x looks ahead [default: of the pictures]
    #[arg(long, value_name = "FRAME")]
    pub camera_frame: Option<String>,
    /// Where the camera stands on the base if /tf_static doesn't say: m and degrees, x looks ahead
    #[arg(long, value_name = "X,Y,Z,YAW,PITCH,ROLL", value_parser = mount_of_text, allow_hyphen_values = true)]
    pub camera_mount: Option<MapPose>,
    /// Poses farther apart in time are not interpolated between, in seconds
    #[arg(long, value_name = "S", default_value_t = 1.0, value_parser = positive)]
    pub max_gap_s: f64,
}

/// A finite number above zero.
pub fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number > 0.0);
    number.ok_or_else(|| "must be a number above 0".to_owned())
}

fn map_of_text(text: &str) -> Result<Name, String> {
    Name::parse(text).map_err(|error| error.to_string())
}

fn mount_of_text(text: &str) -> Result<MapPose, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[x_m, y_m, z_m, yaw_deg, pitch_deg, roll_deg]) => {
            Ok(MapPose { x_m, y_m, z_m, yaw_deg, pitch_deg, roll_deg })
        }
        _ => Err("must be six numbers, x,y,z,yaw,pitch,roll, such as 0.2,0,0.5,0,10,0".to_owned()),
    }
}

/// A bag that was read once.
#[derive(Debug)]
pub struct Contents {
    recording: Recording,
    /// The name of the map that poses are in.
    pub map: Name,
    /// The topic of the pictures.
    pub image_topic: String,
    /// Its type.
    pub image_type: String,
    /// Pictures on it.
    pub pictures: usize,
    /// Of the pictures that came after one with a later stamp.
    pub late_pictures: usize,
    /// Samples of poses that did.
    pub late_poses: usize,
    /// Pictures without a stamp of their own: the time of recording stands in.
    pub unstamped: usize,
    /// From the first picture to the last, nanoseconds.
    pub span_ns: [i64; 2],
    /// `None`: no topic says, or not in a way that is read.
    pub camera: Option<Camera>,
    /// How the poses came about, or why there are none.
    pub notes: Vec<String>,
    /// Files that end too soon.
    pub losses: Vec<Loss>,
    track: Option<CameraTrack>,
}

/// The camera's motion.
#[derive(Debug)]
struct CameraTrack {
    tree: TransformTree,
    map_frame: String,
    /// What moves as the camera does.
    frame: String,
    is_optical: bool,
}

/// A picture of the bag.
#[derive(Clone, Debug)]
pub struct BagPicture {
    pub header: Header,
    /// `header.stamp`, or the time of recording where that is zero.
    pub stamp_ns: i64,
    /// A JPEG or PNG, as far as the bag says so; or why the message has no picture.
    pub file: Result<Vec<u8>, String>,
    /// Of the camera's body: it looks along x. `None` where nothing says.
    pub pose: Option<MapPose>,
}

/// What the first reading gathers.
#[derive(Default)]
struct Gathered {
    topics: Topics,
    /// Stamps and frame of the pictures of each topic.
    images: Vec<(String, Stamps)>,
    cameras: Vec<(String, CameraInfo)>,
    poses: Vec<(PoseSample, RigidTransform)>,
    /// Of any topic: poses without numbers.
    broken_poses: usize,
}

#[derive(Default)]
struct Stamps {
    frame: String,
    other_frame: Option<String>,
    count: usize,
    late: usize,
    unstamped: usize,
    first_ns: i64,
    latest_ns: i64,
}

struct PoseSample {
    frame: String,
    child: Option<String>,
    stamp_ns: i64,
}

impl Stamps {
    fn add(&mut self, header: &Header, log_time: u64) {
        let stamp_ns = stamp_of(header, log_time);
        if self.count == 0 {
            (self.first_ns, self.latest_ns) = (stamp_ns, stamp_ns);
            self.frame.clone_from(&header.frame_id);
        } else if self.frame != header.frame_id {
            self.other_frame = Some(header.frame_id.clone());
        }
        self.count += 1;
        self.unstamped += usize::from(header.stamp == Time::default());
        self.late += usize::from(stamp_ns < self.latest_ns);
        self.first_ns = self.first_ns.min(stamp_ns);
        self.latest_ns = self.latest_ns.max(stamp_ns);
    }
}

fn stamp_of(header: &Header, log_time: u64) -> i64 {
    if header.stamp == Time::default() {
        i64::try_from(log_time).unwrap_or(i64::MAX)
    } else {
        header.stamp.ns()
    }
}

/// Frames have had a leading slash.
fn frame_name(frame: &str) -> &str {
    frame.trim_start_matches('/')
}

impl Gathered {
    fn add(
        &mut self,
        message: &Message<'_>,
        args: &BagArgs,
        tree: &mut TransformTree,
    ) -> Result<(), BagError> {
        let type_name = self.topics.count(message);
        let topic = &message.channel.topic;
        match type_name.as_str() {
            IMAGE | COMPRESSED_IMAGE if args.image_topic.as_ref().is_none_or(|wanted| wanted == topic) => {
                let header: Header = read(message)?;
                let at = match self.images.iter().position(|(name, _)| name == topic) {
                    Some(at) => at,
                    None => {
                        self.images.push((topic.clone(), Stamps::default()));
                        self.images.len() - 1
                    }
                };
                self.images[at].1.add(&header, message.log_time);
            }
            CAMERA_INFO if !self.cameras.iter().any(|(name, _)| name == topic) => {
                let info: CameraInfo = read(message)?;
                if info.k[0] > 0.0 {
                    self.cameras.push((topic.clone(), info));
                }
            }
            TF => {
                let is_static = topic.ends_with("tf_static");
                for link in read::<TfMessage>(message)?.transforms {
                    let (parent, child) =
                        (frame_name(&link.header.frame_id), frame_name(&link.child_frame_id));
                    match link.transform.transform() {
                        None => self.broken_poses += 1,
                        Some(transform) if is_static => tree.fix(parent, child, transform),
                        Some(transform) => tree.add(parent, child, link.header.stamp.ns(), transform),
                    }
                }
            }
            _ if Some(topic) == args.pose_topic.as_ref() => {
                let (header, child, pose) = pose_of(message, &type_name)?;
                match pose.transform() {
                    None => self.broken_poses += 1,
                    Some(transform) => {
                        let frame = match frame_name(&header.frame_id) {
                            "" => frame_name(&args.map_frame).to_owned(),
                            frame => frame.to_owned(),
                        };
                        let stamp_ns = stamp_of(&header, message.log_time);
                        self.poses.push((PoseSample { frame, child, stamp_ns }, transform));
                    }
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// The topic of the pictures, among those that there are.
    fn image_topic(&self, args: &BagArgs) -> Result<(String, &Stamps), BagError> {
        let none = |wanted: Option<&String>| BagError::NoTopic {
            wanted: wanted.map_or_else(|| "of pictures".to_owned(), |topic| format!("{topic} of pictures")),
            option: "--image-topic",
            types: IMAGES.join(" or "),
            topics: self.topics.to_string(),
        };
        match &self.images[..] {
            [(topic, stamps)] => Ok((topic.clone(), stamps)),
            [] => Err(none(args.image_topic.as_ref())),
            several => {
                let topics: Vec<String> =
                    several.iter().map(|(topic, stamps)| format!("{topic} ({})", stamps.count)).collect();
                Err(BagError::SeveralTopics { topics: topics.join(", ") })
            }
        }
    }

    /// The intrinsics that belong to the pictures.
    fn camera(
        &self,
        args: &BagArgs,
        image_topic: &str,
        notes: &mut Vec<String>,
    ) -> Result<Option<Camera>, BagError> {
        let of_topic = |topic: &str| self.cameras.iter().find(|(name, _)| name == topic);
        let found = match &args.camera_info_topic {
            Some(topic) => Some(of_topic(topic).ok_or_else(|| BagError::NoTopic {
                wanted: format!("{topic} with intrinsics"),
                option: "--camera-info-topic",
                types: CAMERA_INFO.to_owned(),
                topics: self.topics.to_string(),
            })?),
            None => {
                let folders = image_topic.match_indices('/').map(|(at, _)| &image_topic[..at]).rev();
                let beside = folders.filter_map(|folder| of_topic(&format!("{folder}/camera_info"))).next();
                beside.or(match &self.cameras[..] {
                    [only] => Some(only),
                    _ => None,
                })
            }
        };
        let Some((topic, info)) = found else {
            notes.push("camera: no topic has its intrinsics".to_owned());
            return Ok(None);
        };
        let rectified = image_topic.split('/').any(|part| part.starts_with("image_rect"));
        Ok(match camera_of(info, rectified) {
            Ok(camera) => {
                notes.push(format!(
                    "camera: {topic}, {}×{}, fx {:.1}",
                    camera.width_px, camera.height_px, camera.fx
                ));
                Some(camera)
            }
            Err(reason) => {
                notes.push(format!("camera: {topic} isn't used: {reason}"));
                None
            }
        })
    }
}

/// Header, the frame that moves if it is named, and the pose.
fn pose_of(message: &Message<'_>, type_name: &str) -> Result<(Header, Option<String>, Pose), BagError> {
    if type_name == ODOMETRY {
        let Odometry { header, child_frame_id, pose } = read(message)?;
        let child = frame_name(&child_frame_id);
        return Ok((header, (!child.is_empty()).then(|| child.to_owned()), pose));
    }
    if !POSES.contains(&type_name) {
        return Err(BagError::Schema {
            topic: message.channel.topic.clone(),
            type_name: type_name.to_owned(),
            wanted: POSES.join(", "),
        });
    }
    let PoseStamped { header, pose } = read(message)?;
    Ok((header, None, pose))
}

/// The camera of the pictures as they are, or of rectified ones.
fn camera_of(info: &CameraInfo, rectified: bool) -> Result<Camera, String> {
    let CameraInfo { width: width_px, height: height_px, distortion_model, d, k, p, .. } = info;
    let (width_px, height_px) = (*width_px, *height_px);
    let camera = if rectified {
        Camera { fx: p[0], fy: p[5], cx: p[2], cy: p[6], distortion: [0.0; 5], width_px, height_px }
    } else {
        let known = match distortion_model.as_str() {
            "plumb_bob" | "" => d.len() <= 5,
            "rational_polynomial" => d.iter().skip(5).all(|further| *further == 0.0),
            _ => d.iter().all(|coefficient| *coefficient == 0.0),
        };
        if !known {
            return Err(format!(
                "the distortion {distortion_model:?} isn't known; record the rectified pictures (image_rect)"
            ));
        }
        let distortion = [0, 1, 2, 3, 4].map(|n| d.get(n).copied().unwrap_or(0.0));
        Camera { fx: k[0], fy: k[4], cx: k[2], cy: k[5], distortion, width_px, height_px }
    };
    let faults: Vec<String> =
        camera.faults().iter().map(|fault| format!("{} {}", fault.field, fault.fault)).collect();
    if faults.is_empty() { Ok(camera) } else { Err(faults.join(", ")) }
}

impl Contents {
    /// Reads the bag at a path; calls `progress` with the bytes read and all.
    ///
    /// # Errors
    /// [`BagError`] for what is no bag, for topics that aren't there, and for messages that can't be read.
    pub fn of(path: &Path, args: &BagArgs, progress: &mut dyn FnMut(u64, u64)) -> Result<Contents, BagError> {
        let recording = Recording::open(path)?;
        let mut tree = TransformTree::new((args.max_gap_s * 1e9) as i64);
        let mut gathered = Gathered::default();
        let losses = recording.each_message(|message, read_bytes| {
            progress(read_bytes, recording.bytes());
            gathered.add(message, args, &mut tree)
        })?;
        let (image_topic, stamps) = gathered.image_topic(args)?;
        let image_type =
            gathered.topics.0.get(&image_topic).map_or_else(String::new, |topic| topic.type_name.clone());
        let mut notes = Vec::new();
        let camera = gathered.camera(args, &image_topic, &mut notes)?;
        if let Some(other) = &stamps.other_frame {
            notes.push(format!(
                "pictures: of the frames {:?} and {other:?}; the first is taken for all, --camera-frame names another",
                stamps.frame
            ));
        }
        if gathered.broken_poses > 0 {
            notes.push(format!(
                "poses: {} have no numbers, or no rotation; they are left out",
                gathered.broken_poses
            ));
        }
        let Stamps { count: pictures, late: late_pictures, unstamped, first_ns, latest_ns, .. } = *stamps;
        let camera_frame = args.camera_frame.as_deref().unwrap_or(&stamps.frame);
        let camera_frame = frame_name(camera_frame).to_owned();
        let mut track = match (&args.pose_topic, gathered.poses.is_empty()) {
            (Some(topic), true) => {
                return Err(BagError::NoTopic {
                    wanted: format!("{topic} of poses"),
                    option: "--pose-topic",
                    types: POSES.join(", "),
                    topics: gathered.topics.to_string(),
                });
            }
            (Some(_), false) => Some(track_of_poses(args, tree, gathered.poses, &camera_frame, &mut notes)),
            (None, _) => track_of_tf(args, tree, &camera_frame, &mut notes),
        };
        let map_frame = track.as_ref().map_or("map", |track| &track.map_frame);
        let map = args.map.clone().unwrap_or_else(|| name_of_frame(map_frame));
        let late_poses = track.as_mut().map_or(0, |track| track.tree.sort());
        Ok(Contents {
            recording,
            map,
            image_topic,
            image_type,
            pictures,
            late_pictures,
            late_poses,
            unstamped,
            span_ns: [first_ns, latest_ns],
            camera,
            notes,
            losses,
            track,
        })
    }

    /// Whether anything says where the camera was.
    pub fn has_poses(&self) -> bool {
        self.track.is_some()
    }

    /// The length of the bag.
    pub fn bytes(&self) -> u64 {
        self.recording.bytes()
    }

    /// The camera's body at a moment.
    pub fn pose_at(&self, stamp_ns: i64) -> Option<MapPose> {
        let CameraTrack { tree, map_frame, frame, is_optical } = self.track.as_ref()?;
        let transform = tree.lookup(map_frame, frame, stamp_ns).ok()?;
        Some(if *is_optical { MapPose::of_optical(&transform) } else { MapPose::of(&transform) })
    }

    /// Why so many pictures have no pose, as far as time tells.
    pub fn pose_trouble(&self) -> Option<String> {
        let track = self.track.as_ref()?;
        let [first_ns, last_ns] = self.span_ns;
        let at = |stamp_ns| track.tree.lookup(&track.map_frame, &track.frame, stamp_ns);
        let never = [first_ns, last_ns].into_iter().all(|ns| at(ns) == Err(NoTransform::NotThen));
        never.then(|| {
            format!(
                "the pictures' stamps run from {:.3} to {:.3} s; poses must be before and after each, no more than --max-gap-s \
                 apart, by the same clock",
                first_ns as f64 / 1e9,
                last_ns as f64 / 1e9
            )
        })
    }

    /// Gives every picture to `visit`, with how many bytes were read so far, in the order of recording; ends when it
    /// returns false.
    ///
    /// # Errors
    /// [`BagError`].
    pub fn each_picture(&self, mut visit: impl FnMut(BagPicture, u64) -> bool) -> Result<(), BagError> {
        let ended = self.recording.each_message(|message, read_bytes| {
            if message.channel.topic != self.image_topic || !IMAGES.contains(&type_name(message).as_str()) {
                return Ok(());
            }
            let (header, file) = match self.image_type == IMAGE {
                true => {
                    let image: Image = read(message)?;
                    let file = png_of(&image).map_err(|error| error.to_string());
                    (image.header, file)
                }
                false => {
                    let image: CompressedImage = read(message)?;
                    (image.header, Ok(image.data.to_vec()))
                }
            };
            let stamp_ns = stamp_of(&header, message.log_time);
            let pose = self.pose_at(stamp_ns);
            if visit(BagPicture { header, stamp_ns, file, pose }, read_bytes) {
                Ok(())
            } else {
                Err(Ended::Enough)
            }
        });
        match ended {
            Err(Ended::Failed(error)) => Err(error),
            Ok(_) | Err(Ended::Enough) => Ok(()),
        }
    }
}

/// Frames may have other characters than names.
fn name_of_frame(frame: &str) -> Name {
    let fits = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '.' | '-');
    let name: String = frame.chars().map(|c| if fits(c) { c } else { '_' }).take(64).collect();
    Name::parse(&name).unwrap_or_else(|_| Name::parse("map").expect("it is a name"))
}

/// Why a reading ended before the bag did.
enum Ended {
    Enough,
    Failed(BagError),
}

impl From<BagError> for Ended {
    fn from(error: BagError) -> Ended {
        Ended::Failed(error)
    }
}

/// The camera as the base moves that a topic has the poses of.
fn track_of_poses(
    args: &BagArgs,
    mut tree: TransformTree,
    poses: Vec<(PoseSample, RigidTransform)>,
    camera_frame: &str,
    notes: &mut Vec<String>,
) -> CameraTrack {
    let above_camera = tree.fixed_root(camera_frame);
    let named = poses.first().and_then(|(sample, _)| sample.child.clone());
    let base = match (&args.base_frame, named) {
        (Some(base), _) => frame_name(base).to_owned(),
        (None, Some(child)) => child,
        (None, None) if above_camera != camera_frame => above_camera.to_owned(),
        (None, None) => BASE.to_owned(),
    };
    let mut pose_frame = String::new();
    tree.cut(&base);
    for (sample, transform) in poses {
        tree.add(&sample.frame, &base, sample.stamp_ns, transform);
        pose_frame = sample.frame;
    }
    let mut map_frame = frame_name(&args.map_frame).to_owned();
    if !tree.is_above(&map_frame, &base) {
        notes.push(format!(
            "poses: in {pose_frame:?}, because nothing links it to {map_frame:?}; if it is odometry, it drifts"
        ));
        map_frame = pose_frame;
    }
    mounted(args, tree, map_frame, &base, camera_frame, notes)
}

/// The camera as /tf has it, if that links it to the map.
fn track_of_tf(
    args: &BagArgs,
    tree: TransformTree,
    camera_frame: &str,
    notes: &mut Vec<String>,
) -> Option<CameraTrack> {
    let map_frame = frame_name(&args.map_frame).to_owned();
    let base = args.base_frame.as_deref().map_or(BASE, frame_name);
    if tree.is_above(&map_frame, camera_frame) || tree.is_above(&map_frame, base) {
        return Some(mounted(args, tree, map_frame, base, camera_frame, notes));
    }
    notes.push(format!(
        "poses: none: /tf has no way from {map_frame:?} to {camera_frame:?}; --pose-topic names a topic with them"
    ));
    None
}

/// The camera on the base: as the arguments say, else as the tree does, else at the base's origin, looking ahead.
fn mounted(
    args: &BagArgs,
    mut tree: TransformTree,
    map_frame: String,
    base: &str,
    camera_frame: &str,
    notes: &mut Vec<String>,
) -> CameraTrack {
    /// No frame of ROS has a space in its name.
    const MOUNTED: &str = "mounted camera";
    if let Some(mount) = &args.camera_mount {
        tree.fix(base, MOUNTED, mount.transform());
        notes.push(format!("poses: of {base:?} in {map_frame:?}, the camera on it as --camera-mount says"));
        return CameraTrack { tree, map_frame, frame: MOUNTED.to_owned(), is_optical: false };
    }
    if tree.is_above(&map_frame, camera_frame) {
        notes.push(format!("poses: of {camera_frame:?} in {map_frame:?}, by way of /tf"));
        let is_optical = camera_frame.contains("optical");
        return CameraTrack { tree, map_frame, frame: camera_frame.to_owned(), is_optical };
    }
    notes.push(format!(
        "poses: of {base:?} in {map_frame:?}; nothing says where the camera {camera_frame:?} is on it, so it is taken to look \
         ahead from there: give --camera-mount if it doesn't"
    ));
    CameraTrack { tree, map_frame, frame: base.to_owned(), is_optical: false }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::fs;

    use super::super::messages::{Point, Quaternion, TransformStamped, written};
    use super::*;
    use landmarkd_core::geometry::optical_in_body;
    use serde::Serialize;

    const SECOND: i64 = 1_000_000_000;

    /// A bag in the making.
    struct Bag(Vec<(&'static str, &'static str, &'static str, Vec<u8>)>);

    impl Bag {
        fn add<T: Serialize>(&mut self, topic: &'static str, type_name: &'static str, message: &T) {
            self.0.push((topic, type_name, "cdr", written(message)));
        }

        fn picture(&mut self, topic: &'static str, stamp_ns: i64) {
            let image = Image {
                header: header(stamp_ns, "camera_optical_frame"),
                height: 2,
                width: 2,
                encoding: "mono8".into(),
                is_bigendian: 0,
                step: 2,
                data: &[1, 2, 3, 4],
            };
            self.add(topic, "sensor_msgs/msg/Image", &image);
        }

        fn pose(&mut self, stamp_ns: i64, x_m: f64) {
            let pose = Pose::of(&MapPose { x_m, ..MapPose::default() }.transform());
            self.add(
                "/pose",
                "geometry_msgs/msg/PoseStamped",
                &PoseStamped { header: header(stamp_ns, "map"), pose },
            );
        }

        fn bytes(&self) -> Vec<u8> {
            let mut writer = mcap::Writer::new(std::io::Cursor::new(Vec::new())).unwrap();
            for (n, (topic, type_name, encoding, data)) in self.0.iter().enumerate() {
                let schema = writer.add_schema(type_name, "ros2msg", b"").unwrap();
                let channel_id = writer.add_channel(schema, topic, encoding, &BTreeMap::new()).unwrap();
                let time = n as u64;
                let header = mcap::records::MessageHeader {
                    channel_id,
                    sequence: 0,
                    log_time: time,
                    publish_time: time,
                };
                writer.write_to_known_channel(&header, data).unwrap();
                // a chunk each, so that a cut file loses the last ones alone
                writer.flush().unwrap();
            }
            writer.finish().unwrap();
            writer.into_inner().into_inner()
        }
    }

    fn header(stamp_ns: i64, frame: &str) -> Header {
        Header { stamp: Time::of_ns(stamp_ns), frame_id: frame.into() }
    }

    fn args() -> BagArgs {
        BagArgs {
            image_topic: None,
            pose_topic: Some("/pose".into()),
            camera_info_topic: None,
            map_frame: "map".into(),
            map: None,
            base_frame: None,
            camera_frame: None,
            camera_mount: None,
            max_gap_s: 1.0,
        }
    }

    fn read_once(bytes: &[u8], args: &BagArgs) -> Result<Contents, BagError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.mcap");
        fs::write(&path, bytes).unwrap();
        Contents::of(&path, args, &mut |_, _| ())
    }

    /// Pictures at 1.5 and 9 s, poses from 1 to 3 s, and a camera that looks to the left.
    fn run() -> Bag {
        let mut bag = Bag(Vec::new());
        let left =
            MapPose { x_m: 0.2, yaw_deg: 90.0, ..MapPose::default() }.transform().then(&optical_in_body());
        let link = TransformStamped {
            header: header(0, "base_link"),
            child_frame_id: "camera_optical_frame".into(),
            transform: Pose::of(&left),
        };
        bag.add("/tf_static", "tf2_msgs/msg/TFMessage", &TfMessage { transforms: vec![link] });
        bag.picture("/image", 3 * SECOND / 2);
        for (stamp_ns, x_m) in [(2 * SECOND, 2.0), (SECOND, 1.0), (3 * SECOND, 3.0)] {
            bag.pose(stamp_ns, x_m);
        }
        bag.picture("/image", 9 * SECOND);
        bag
    }

    #[test]
    fn the_camera_stands_on_the_base_as_tf_static_says_at_the_pictures_own_stamp() {
        let contents = read_once(&run().bytes(), &args()).unwrap();
        assert_eq!((contents.pictures, contents.late_poses, contents.map.as_str()), (2, 1, "map"));
        let pose = contents.pose_at(3 * SECOND / 2).unwrap();
        assert!((pose.x_m - 1.7).abs() < 1e-9 && (pose.yaw_deg - 90.0).abs() < 1e-6, "{pose:?}");
        assert!(pose.pitch_deg.abs() < 1e-6 && pose.roll_deg.abs() < 1e-6, "{pose:?}");
        assert_eq!(contents.pose_at(9 * SECOND), None);
    }

    #[test]
    fn a_mount_that_is_given_wins_and_without_any_it_is_said_that_the_base_stands_in() {
        let mount = mount_of_text("0.1,0,0.5,-90,0,0").unwrap();
        let contents = read_once(&run().bytes(), &BagArgs { camera_mount: Some(mount), ..args() }).unwrap();
        let pose = contents.pose_at(SECOND).unwrap();
        assert!((pose.x_m - 1.1).abs() < 1e-9 && (pose.yaw_deg + 90.0).abs() < 1e-6, "{pose:?}");
        let mut bare = run();
        bare.0.remove(0);
        let contents = read_once(&bare.bytes(), &args()).unwrap();
        assert!(contents.notes.iter().any(|note| note.contains("--camera-mount")), "{:?}", contents.notes);
        assert_eq!(contents.pose_at(SECOND).unwrap().x_m, 1.0);
        assert!(mount_of_text("1,2,3").is_err());
    }

    #[test]
    fn a_cut_file_gives_what_it_holds_and_says_what_is_lost() {
        let bytes = run().bytes();
        // behind the third message's chunk, in the middle of the next
        let contents =
            read_once(&bytes[..bytes.len() * 2 / 5], &BagArgs { pose_topic: None, ..args() }).unwrap();
        assert_eq!((contents.pictures, contents.losses.len()), (1, 1));
        assert!(contents.losses[0].to_string().contains("mcap recover"), "{}", contents.losses[0]);
        assert!(read_once(&bytes, &args()).unwrap().losses.is_empty());
    }

    #[test]
    fn what_is_not_there_or_of_another_kind_is_refused_with_what_to_do() {
        let refused = |bag: &Bag, args: &BagArgs| read_once(&bag.bytes(), args).unwrap_err().to_string();
        let topic = |topic: &str| Some(topic.to_owned());
        let error = refused(&run(), &BagArgs { pose_topic: topic("/amcl_pose"), ..args() });
        assert!(error.contains("/pose (geometry_msgs/PoseStamped, 3 messages)"), "{error}");
        let error = refused(&run(), &BagArgs { pose_topic: topic("/image"), ..args() });
        assert!(error.contains("--pose-topic"), "{error}");
        let error = refused(&run(), &BagArgs { image_topic: topic("/pose"), ..args() });
        assert!(error.contains("--image-topic"), "{error}");
        let mut two = run();
        two.picture("/other", SECOND);
        assert!(refused(&two, &args()).contains("/image (2), /other (1)"));
        let mut old = run();
        old.0[1].2 = "ros1";
        assert!(refused(&old, &args()).contains("rosbags-convert"));
        let mut broken = run();
        broken.0[1].3.truncate(9);
        assert!(refused(&broken, &args()).contains("/image"));
        let none = read_once(b"SQLite format 3", &args()).unwrap_err();
        assert!(none.to_string().contains("no MCAP bag"), "{none}");
    }

    #[test]
    fn intrinsics_are_those_of_the_pictures_and_unknown_distortions_are_not_guessed() {
        let info = CameraInfo {
            header: header(0, "camera_optical_frame"),
            height: 480,
            width: 640,
            distortion_model: "plumb_bob".into(),
            d: vec![-0.1, 0.02, 0.0, 0.0, 0.0],
            k: [400.0, 0.0, 320.0, 0.0, 401.0, 240.0, 0.0, 0.0, 1.0],
            r: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            p: [380.0, 0.0, 319.0, 0.0, 0.0, 381.0, 239.0, 0.0, 0.0, 0.0, 1.0, 0.0],
        };
        let camera = camera_of(&info, false).unwrap();
        assert_eq!((camera.fx, camera.fy, camera.distortion[0]), (400.0, 401.0, -0.1));
        let rectified = camera_of(&info, true).unwrap();
        assert_eq!((rectified.fx, rectified.cy, rectified.distortion), (380.0, 239.0, [0.0; 5]));
        let fisheye = CameraInfo { distortion_model: "equidistant".into(), ..info };
        assert!(camera_of(&fisheye, false).unwrap_err().contains("image_rect"));
        let unset = CameraInfo { k: [0.0; 9], distortion_model: String::new(), d: Vec::new(), ..fisheye };
        assert!(camera_of(&unset, false).is_err());
    }

    #[test]
    fn frames_have_one_way_of_being_written() {
        let zero = Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 };
        assert!(Pose { position: Point::default(), orientation: zero }.transform().is_some());
        assert_eq!((frame_name("/map"), name_of_frame("a map/2").as_str()), ("map", "a_map_2"));
        assert!(map_of_text("floor 2").is_err());
        assert!(positive("0").is_err() && positive("NaN").is_err() && positive("0.5").is_ok());
    }
}
