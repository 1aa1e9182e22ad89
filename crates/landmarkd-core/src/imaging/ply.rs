//! Point clouds: PLY, binary, little endian.

/// A PLY file of points, given in mm with the gray level, 0..=255, that each is seen in: `x`, `y`, `z` in metres,
/// and the gray level as `red`, `green` and `blue`.
pub fn ply_points(points_mm: impl IntoIterator<Item = ([f64; 3], f32)>) -> Vec<u8> {
    let mut count = 0_usize;
    let mut body = Vec::new();
    for (point_mm, level) in points_mm {
        count += 1;
        body.extend(point_mm.into_iter().flat_map(|mm| ((mm / 1000.0) as f32).to_le_bytes()));
        body.extend([level.round().clamp(0.0, 255.0) as u8; 3]);
    }
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\ncomment metres; x right, y down, z away from the lens\n\
         element vertex {count}\nproperty float x\nproperty float y\nproperty float z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n"
    )
    .into_bytes();
    bytes.append(&mut body);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_point_is_fifteen_bytes_after_the_header() {
        let bytes = ply_points([([1500.0, -250.0, 1000.0], 127.6), ([0.0; 3], 300.0)]);
        let head = b"end_header\n";
        let from = bytes.windows(head.len()).position(|part| part == head).unwrap() + head.len();
        let text = std::str::from_utf8(&bytes[..from]).unwrap();
        assert!(
            text.starts_with("ply\nformat binary_little_endian 1.0\n") && text.contains("element vertex 2\n")
        );
        let (points, rest) = bytes[from..].as_chunks::<15>();
        assert_eq!((points.len(), rest.len()), (2, 0));
        let metres: Vec<f32> = points[0][..12].as_chunks().0.iter().map(|v| f32::from_le_bytes(*v)).collect();
        assert_eq!(metres, [1.5, -0.25, 1.0]);
        assert_eq!((points[0][12..].to_vec(), points[1][12..].to_vec()), (vec![128; 3], vec![255; 3]));
    }

    #[test]
    fn no_point_is_a_cloud_too() {
        assert!(ply_points([]).ends_with(b"element vertex 0\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n"));
    }
}
