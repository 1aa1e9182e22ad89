//! The messages of ROS 2 that bags are read for, and those that answers are written as.
//!
//! Their layout is fixed by ROS, so each is declared once, in the order of its fields. The bytes are CDR (OMG DDS-XTypes,
//! 7.4.1, plain CDR version 1): four bytes that say the byte order, then the fields, each aligned to its size.

use byteorder::{BigEndian, LittleEndian};
use cdr_encoding::CdrDeserializer;
use serde::{Deserialize, Serialize, Serializer};

use landmarkd_core::geometry::{DQuat, DVec3, RigidTransform};

/// `builtin_interfaces/Time`.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct Time {
    pub sec: i32,
    pub nanosec: u32,
}

impl Time {
    /// Nanoseconds since the epoch of the recording's clock.
    pub fn ns(self) -> i64 {
        i64::from(self.sec) * 1_000_000_000 + i64::from(self.nanosec)
    }

    /// The moment of so many nanoseconds; what doesn't fit 32 bits of seconds is the end of that range.
    pub fn of_ns(ns: i64) -> Time {
        let sec = ns.div_euclid(1_000_000_000).clamp(i64::from(i32::MIN), i64::from(i32::MAX));
        Time { sec: sec as i32, nanosec: ns.rem_euclid(1_000_000_000) as u32 }
    }
}

/// `std_msgs/Header`.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct Header {
    pub stamp: Time,
    pub frame_id: String,
}

/// `sensor_msgs/Image`.
#[derive(Debug, Deserialize, Serialize)]
pub struct Image<'a> {
    pub header: Header,
    pub height: u32,
    pub width: u32,
    pub encoding: String,
    pub is_bigendian: u8,
    /// Bytes of a row.
    pub step: u32,
    #[serde(borrow, serialize_with = "octets")]
    pub data: &'a [u8],
}

/// `sensor_msgs/CompressedImage`.
#[derive(Debug, Deserialize, Serialize)]
pub struct CompressedImage<'a> {
    pub header: Header,
    pub format: String,
    #[serde(borrow, serialize_with = "octets")]
    pub data: &'a [u8],
}

/// Serde takes a slice for a sequence of numbers, one by one.
fn octets<S: Serializer>(bytes: &&[u8], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_bytes(bytes)
}

/// `sensor_msgs/CameraInfo`, as far as it is read.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct CameraInfo {
    pub header: Header,
    pub height: u32,
    pub width: u32,
    pub distortion_model: String,
    pub d: Vec<f64>,
    /// Row-major.
    pub k: [f64; 9],
    pub r: [f64; 9],
    /// Row-major, 3×4: the camera of the rectified picture.
    pub p: [f64; 12],
}

/// `geometry_msgs/Point` and `geometry_msgs/Vector3`.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
pub struct Point {
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

/// `geometry_msgs/Quaternion`.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub struct Quaternion {
    pub x: f64,
    pub y: f64,
    pub z: f64,
    pub w: f64,
}

/// `geometry_msgs/Pose` and `geometry_msgs/Transform`: the same bytes.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub struct Pose {
    pub position: Point,
    pub orientation: Quaternion,
}

impl Pose {
    /// The rigid motion; `None` where the numbers are none, such as a quaternion of zeros.
    pub fn transform(&self) -> Option<RigidTransform> {
        let Pose { position: p, orientation: q } = self;
        let translation_m = DVec3::new(p.x, p.y, p.z);
        let rotation = DQuat::from_xyzw(q.x, q.y, q.z, q.w);
        let is_rotation = rotation.is_finite() && (rotation.length() - 1.0).abs() < 0.1;
        (is_rotation && translation_m.is_finite())
            .then(|| RigidTransform { rotation: rotation.normalize(), translation_m })
    }

    /// The pose of a rigid motion.
    pub fn of(transform: &RigidTransform) -> Pose {
        let (p, q) = (transform.translation_m, transform.rotation);
        Pose {
            position: Point { x: p.x, y: p.y, z: p.z },
            orientation: Quaternion { x: q.x, y: q.y, z: q.z, w: q.w },
        }
    }
}

/// `geometry_msgs/PoseStamped`, and the beginning of `PoseWithCovarianceStamped`.
#[derive(Debug, Deserialize, Serialize)]
pub struct PoseStamped {
    pub header: Header,
    pub pose: Pose,
}

/// `geometry_msgs/PoseWithCovarianceStamped`.
#[derive(Debug, Deserialize, Serialize)]
pub struct PoseWithCovarianceStamped {
    pub header: Header,
    pub pose: Pose,
    /// Row-major over x, y, z and the rotations about them; m and rad.
    pub covariance: [[f64; 6]; 6],
}

/// The beginning of `nav_msgs/Odometry`.
#[derive(Debug, Deserialize, Serialize)]
pub struct Odometry {
    pub header: Header,
    pub child_frame_id: String,
    pub pose: Pose,
}

/// `geometry_msgs/TransformStamped`: `T_frame_child`.
#[derive(Debug, Deserialize, Serialize)]
pub struct TransformStamped {
    pub header: Header,
    pub child_frame_id: String,
    pub transform: Pose,
}

/// `tf2_msgs/TFMessage`.
#[derive(Debug, Deserialize, Serialize)]
pub struct TfMessage {
    pub transforms: Vec<TransformStamped>,
}

/// `std_msgs/String`.
#[derive(Debug, Deserialize, Serialize)]
pub struct Text {
    pub data: String,
}

/// Why the bytes are no message of the type that the schema names.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum MessageError {
    /// The first four bytes name another encoding.
    #[error(
        "its bytes begin with {0:02x?}, which is not plain CDR (00 00 or 00 01): a bag that is compressed message by message is \
         unpacked by `rosbags-convert --src BAG --dst FOLDER --dst-storage mcap` (pip install rosbags)"
    )]
    Encapsulation(Vec<u8>),
    /// The fields don't fit the bytes.
    #[error("its bytes are not of its type: {0}")]
    Fields(String),
}

/// The message in these bytes; further fields after those that the type declares are passed over.
///
/// # Errors
/// [`MessageError`].
pub fn read<'a, T: Deserialize<'a>>(bytes: &'a [u8]) -> Result<T, MessageError> {
    let fields = |error: cdr_encoding::Error| MessageError::Fields(error.to_string());
    match bytes {
        [0, 0, _, _, body @ ..] => {
            T::deserialize(&mut CdrDeserializer::<BigEndian>::new(body)).map_err(fields)
        }
        [0, 1, _, _, body @ ..] => {
            T::deserialize(&mut CdrDeserializer::<LittleEndian>::new(body)).map_err(fields)
        }
        _ => Err(MessageError::Encapsulation(bytes[..bytes.len().min(4)].to_vec())),
    }
}

/// The bytes of a message, little-endian.
pub fn written<T: Serialize>(message: &T) -> Vec<u8> {
    let mut bytes = vec![0, 1, 0, 0];
    cdr_encoding::to_writer::<T, LittleEndian, _>(&mut bytes, message).expect("memory takes every message");
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_aligned_from_behind_the_four_bytes_in_both_byte_orders() {
        // stamp, length 4, "map\0", then doubles at a multiple of eight: after 4 + 4 + 4 + 4 = 16 none is added
        let header = [&[1, 0, 0, 0, 2, 0, 0, 0, 4, 0, 0, 0][..], b"map\0"].concat();
        let one = 1.0_f64.to_le_bytes();
        let little = [&[0, 1, 0, 0][..], &header, &one.repeat(6), &one].concat();
        let read_back: PoseStamped = read(&little).unwrap();
        assert_eq!(read_back.header, Header { stamp: Time { sec: 1, nanosec: 2 }, frame_id: "map".into() });
        assert_eq!(read_back.pose.orientation.w, 1.0);
        let big_header = [&[0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 5][..], b"odom\0"].concat();
        // 4 + 4 + 4 + 5 = 17, so seven bytes are passed over
        let big = [&[0, 0, 0, 0][..], &big_header, &[9; 7], &1.0_f64.to_be_bytes().repeat(7)].concat();
        let read_back: PoseStamped = read(&big).unwrap();
        assert_eq!((read_back.header.frame_id.as_str(), read_back.pose.position.x), ("odom", 1.0));
    }

    #[test]
    fn what_is_written_is_read_and_pictures_are_borrowed() {
        let header = Header { stamp: Time::of_ns(5_000_000_007), frame_id: "camera".into() };
        let bytes =
            written(&CompressedImage { header: header.clone(), format: "jpeg".into(), data: &[7; 100] });
        let image: CompressedImage = read(&bytes).unwrap();
        assert_eq!((image.header, image.format.as_str(), image.data), (header, "jpeg", &[7_u8; 100][..]));
        assert_eq!(Time::of_ns(-1).ns(), -1);
    }

    #[test]
    fn bytes_that_are_no_such_message_are_errors() {
        assert_eq!(
            read::<Text>(&[0, 7, 0, 0, 1]).unwrap_err(),
            MessageError::Encapsulation(vec![0, 7, 0, 0])
        );
        assert!(matches!(read::<Text>(&[0, 1, 0, 0, 200, 0, 0, 0, 65]), Err(MessageError::Fields(_))));
        assert!(matches!(read::<TfMessage>(&[0, 1, 0, 0, 255, 255, 255, 255]), Err(MessageError::Fields(_))));
        let none =
            Pose { position: Point::default(), orientation: Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 0.0 } };
        assert!(none.transform().is_none());
    }
}
