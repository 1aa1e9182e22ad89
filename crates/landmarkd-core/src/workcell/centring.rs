//! Centring with the camera at the gripper: the offset of the part nearest the picture's middle.

use super::Workcell;
use crate::vision::segmentation::{Picture, Region, segmented_from_near};

/// The camera at the gripper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalCamera {
    /// Scale on the table, above 0.
    pub mm_per_px: f64,
    /// Direction of the image's x axis in the robot's plane, from X towards Y.
    pub rotation_deg: f64,
}

/// The offset of a part from the picture's middle.
#[derive(Clone, Debug, PartialEq)]
pub struct Centring {
    /// The part's.
    pub region: Region,
    /// The region's centroid less the picture's middle, x and y.
    pub move_px: [f64; 2],
    /// By how much the gripper must move to have it in the middle, X and Y; `None` if the local camera isn't known.
    pub move_mm: Option<[f64; 2]>,
    /// Length of `move_px`.
    pub distance_px: f64,
    /// Whether it is within the tolerance.
    pub centred: bool,
}

impl LocalCamera {
    /// A displacement in the image as one in the robot's plane, X and Y in mm.
    fn move_mm(&self, [x, y]: [f64; 2], flip_y: bool) -> [f64; 2] {
        let (sin, cos) = self.rotation_deg.to_radians().sin_cos();
        let y = if flip_y { -y } else { y };
        [cos * x - sin * y, sin * x + cos * y].map(|v| v * self.mm_per_px)
    }
}

/// The region of a local picture that is nearest its middle; `None` without a region.
pub fn centring<'a>(picture: impl Into<Picture<'a>>, workcell: &Workcell) -> Option<Centring> {
    let segmentation = segmented_from_near(picture, &workcell.segmentation);
    let region = segmentation.central()?.clone();
    let middle = segmentation.middle_px();
    let move_px = [0, 1].map(|axis| region.centroid_px[axis] - middle[axis]);
    let distance_px = move_px[0].hypot(move_px[1]);
    Some(Centring {
        move_px,
        // Both cameras have one handedness: that of the correspondences.
        move_mm: workcell
            .local
            .map(|camera| camera.move_mm(move_px, workcell.flip_y != workcell.mapping.mirrored)),
        distance_px,
        centred: distance_px <= workcell.tolerance_px,
        region,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::imaging::Image;
    use crate::vision::segmentation::SegmentationOptions;
    use crate::workcell::{Correspondence, Mapping};

    fn workcell(local: Option<LocalCamera>) -> Workcell {
        let pair = |x: f64, y: f64| Correspondence { image_px: [x, y], robot_mm: [0.5 * x, -0.5 * y] };
        Workcell {
            mapping: Mapping::fit(&[pair(0.0, 0.0), pair(100.0, 50.0)], None, true).unwrap(),
            flip_y: true,
            local,
            tolerance_px: 1.0,
            segmentation: SegmentationOptions::default(),
        }
    }

    /// Two discs, the larger one farther from the middle.
    fn picture(x: f64, y: f64) -> Image {
        Image::from_fn(161, 121, |column, row| {
            let (column, row) = (column as f64, row as f64);
            let near = (column - x).hypot(row - y) <= 10.0;
            let far = (column - 25.0).hypot(row - 30.0) <= 15.0;
            if near || far { 180.0 } else { 20.0 }
        })
    }

    #[test]
    fn the_part_nearest_the_middle_is_centred() {
        let camera = LocalCamera { mm_per_px: 0.2, rotation_deg: 90.0 };
        let seen = centring(&picture(92.0, 55.0), &workcell(Some(camera))).unwrap();
        assert!((seen.move_px[0] - 12.0).abs() < 0.1 && (seen.move_px[1] + 5.0).abs() < 0.1, "{seen:?}");
        // x points along Y; y falls where Y grows before the turn, so it points along X.
        let [x, y] = seen.move_mm.unwrap();
        assert!((x + 1.0).abs() < 0.02 && (y - 2.4).abs() < 0.02, "{seen:?}");
        assert!(!seen.centred);
    }

    #[test]
    fn within_the_tolerance_it_is_centred() {
        let seen = centring(&picture(80.5, 60.2), &workcell(None)).unwrap();
        assert!(seen.centred && seen.move_mm.is_none(), "{seen:?}");
        assert_eq!(centring(&Image::from_fn(64, 64, |_, _| 20.0), &workcell(None)), None);
    }
}
