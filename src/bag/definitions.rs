//! Definitions of the ROS 2 messages that answers are written as: the text that a bag carries, so that a reader needs no ROS.

/// The types, each with its fields. A type that another names stands here too.
const DEFINITIONS: &[(&str, &str)] = &[
    ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"),
    ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"),
    ("std_msgs/String", "string data\n"),
    ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"),
    ("geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"),
    ("geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"),
    ("geometry_msgs/PoseWithCovariance", "geometry_msgs/Pose pose\nfloat64[36] covariance\n"),
    ("geometry_msgs/PoseStamped", "std_msgs/Header header\ngeometry_msgs/Pose pose\n"),
    (
        "geometry_msgs/PoseWithCovarianceStamped",
        "std_msgs/Header header\ngeometry_msgs/PoseWithCovariance pose\n",
    ),
    ("sensor_msgs/CompressedImage", "std_msgs/Header header\nstring format\nuint8[] data\n"),
    ("vision_msgs/Point2D", "float64 x\nfloat64 y\n"),
    ("vision_msgs/Pose2D", "vision_msgs/Point2D position\nfloat64 theta\n"),
    ("vision_msgs/BoundingBox2D", "vision_msgs/Pose2D center\nfloat64 size_x\nfloat64 size_y\n"),
    ("vision_msgs/ObjectHypothesis", "string class_id\nfloat64 score\n"),
    (
        "vision_msgs/ObjectHypothesisWithPose",
        "vision_msgs/ObjectHypothesis hypothesis\ngeometry_msgs/PoseWithCovariance pose\n",
    ),
    (
        "vision_msgs/Detection2D",
        "std_msgs/Header header\nvision_msgs/ObjectHypothesisWithPose[] results\nvision_msgs/BoundingBox2D bbox\nstring id\n",
    ),
    ("vision_msgs/Detection2DArray", "std_msgs/Header header\nvision_msgs/Detection2D[] detections\n"),
    ("foxglove_msgs/Point2", "float64 x\nfloat64 y\n"),
    ("foxglove_msgs/Color", "float64 r\nfloat64 g\nfloat64 b\nfloat64 a\n"),
    (
        "foxglove_msgs/CircleAnnotation",
        "builtin_interfaces/Time timestamp\nfoxglove_msgs/Point2 position\nfloat64 diameter\nfloat64 thickness\n\
         foxglove_msgs/Color fill_color\nfoxglove_msgs/Color outline_color\n",
    ),
    (
        "foxglove_msgs/PointsAnnotation",
        "uint8 UNKNOWN=0\nuint8 POINTS=1\nuint8 LINE_LOOP=2\nuint8 LINE_STRIP=3\nuint8 LINE_LIST=4\n\
         builtin_interfaces/Time timestamp\nuint8 type\nfoxglove_msgs/Point2[] points\nfoxglove_msgs/Color outline_color\n\
         foxglove_msgs/Color[] outline_colors\nfoxglove_msgs/Color fill_color\nfloat64 thickness\n",
    ),
    (
        "foxglove_msgs/TextAnnotation",
        "builtin_interfaces/Time timestamp\nfoxglove_msgs/Point2 position\nstring text\nfloat64 font_size\n\
         foxglove_msgs/Color text_color\nfoxglove_msgs/Color background_color\n",
    ),
    (
        "foxglove_msgs/ImageAnnotations",
        "foxglove_msgs/CircleAnnotation[] circles\nfoxglove_msgs/PointsAnnotation[] points\nfoxglove_msgs/TextAnnotation[] texts\n",
    ),
];

/// The whole definition of a type: its fields, and then those of every type that they name, as `ros2msg` has it.
pub fn definition(type_name: &str) -> String {
    let fields =
        |name: &str| DEFINITIONS.iter().find(|(defined, _)| *defined == name).map(|(_, fields)| *fields);
    let mut text = fields(type_name).unwrap_or_default().to_owned();
    let mut named = vec![type_name];
    let mut at = 0;
    while at < named.len() {
        let lines = fields(named[at]).unwrap_or_default().lines();
        for word in lines.filter_map(|line| line.split(['[', ' ']).next()).filter(|word| word.contains('/')) {
            let defined = DEFINITIONS.iter().find(|(name, _)| *name == word);
            if let Some((name, fields)) = defined.filter(|(name, _)| !named.contains(name)) {
                named.push(name);
                text += &format!("{}\nMSG: {name}\n{fields}", "=".repeat(80));
            }
        }
        at += 1;
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_definition_holds_every_type_that_it_names_once() {
        let text = definition("geometry_msgs/PoseWithCovarianceStamped");
        assert!(text.starts_with("std_msgs/Header header\n"), "{text}");
        for named in ["std_msgs/Header", "builtin_interfaces/Time", "geometry_msgs/Quaternion"] {
            assert_eq!(text.matches(&format!("MSG: {named}\n")).count(), 1, "{text}");
        }
        for (name, fields) in DEFINITIONS {
            let types = fields.lines().filter_map(|line| line.split(['[', ' ']).next());
            for word in types.filter(|word| word.contains('/')) {
                assert!(DEFINITIONS.iter().any(|(defined, _)| *defined == word), "{name} names {word}");
            }
        }
    }
}
