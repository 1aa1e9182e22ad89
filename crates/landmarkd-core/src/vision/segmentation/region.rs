//! What is known of a region: area, centroid, box, principal axis, whether the picture cuts it.

use std::ops::Range;

use super::components::Run;

/// Below this elongation no direction is called the principal one: the noise of a border decides it.
const LEAST_ELONGATION: f64 = 1.05;

/// A connected part of a picture that stands out from its background.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// From 1, the largest first.
    pub id: usize,
    /// Its pixels.
    pub area_px: usize,
    /// The mean of its pixels, x and y.
    pub centroid_px: [f64; 2],
    /// The smallest upright rectangle around it.
    pub bbox_px: BoundingBox,
    /// Direction of its principal axis, in [−90, 90), from x towards y; `None` if it is about as broad as long.
    pub orientation_deg: Option<f64>,
    /// Root of the ratio of its principal second moments: length by breadth of a bar or an ellipse.
    pub elongation: f64,
    /// Whether it reaches the picture's border, so that a part of it may be outside.
    pub touches_border: bool,
    /// Whether it is darker than the ground in the mean.
    pub is_darker: bool,
    /// If its shape doesn't say whether it is one part or several that touch: those.
    pub pieces: Vec<Piece>,
}

/// What may be a part of its own within a region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Its pixels.
    pub area_px: usize,
    /// The mean of its pixels, x and y.
    pub centroid_px: [f64; 2],
}

/// The smallest upright rectangle around a region, in whole pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoundingBox {
    /// Its left column.
    pub x: usize,
    /// Its upper row.
    pub y: usize,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

/// Sums over a region's pixels, run by run.
pub(super) struct Sums {
    area: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
    left: usize,
    right: usize,
    top: usize,
    bottom: usize,
}

impl Sums {
    const NONE: Sums = Sums {
        area: 0.0,
        x: 0.0,
        y: 0.0,
        xx: 0.0,
        xy: 0.0,
        yy: 0.0,
        left: usize::MAX,
        right: 0,
        top: usize::MAX,
        bottom: 0,
    };

    pub fn of(runs: &[Run]) -> Sums {
        let mut sums = Sums::NONE;
        runs.iter().for_each(|run| sums.add(run));
        sums
    }

    pub fn piece(&self) -> Piece {
        Piece { area_px: self.area as usize, centroid_px: [self.x / self.area, self.y / self.area] }
    }

    fn add(&mut self, run: &Run) {
        let Range { start, end } = run.columns();
        let (length, y) = ((end - start) as f64, run.row() as f64);
        let middle = (start + end - 1) as f64 / 2.0;
        let x = length * middle;
        self.area += length;
        self.x += x;
        self.y += length * y;
        // Of a run: its middle's square, and the second moment about it.
        self.xx += x * middle + length * (length * length - 1.0) / 12.0;
        self.xy += x * y;
        self.yy += length * y * y;
        self.left = self.left.min(start);
        self.right = self.right.max(end);
        self.top = self.top.min(run.row());
        self.bottom = self.bottom.max(run.row() + 1);
    }

    /// Length by breadth, by the principal second moments.
    pub fn elongation(&self) -> f64 {
        self.principal_axis().1
    }

    /// Direction of the principal axis in (−90, 90], and the elongation along it.
    fn principal_axis(&self) -> (f64, f64) {
        let [x, y] = [self.x / self.area, self.y / self.area];
        // A pixel is a square of second moment 1/12, not a point.
        let along_x = self.xx / self.area - x * x + 1.0 / 12.0;
        let along_y = self.yy / self.area - y * y + 1.0 / 12.0;
        let across = self.xy / self.area - x * y;
        let (mean, apart) = ((along_x + along_y) / 2.0, ((along_x - along_y) / 2.0).hypot(across));
        let elongation = ((mean + apart) / (mean - apart).max(f64::MIN_POSITIVE)).sqrt();
        (0.5 * (2.0 * across).atan2(along_x - along_y).to_degrees(), elongation)
    }

    /// The region of these sums in a picture of `width` × `height` pixels: lighter than the ground, and one part.
    pub fn region(&self, id: usize, width: usize, height: usize) -> Region {
        let (angle_deg, elongation) = self.principal_axis();
        Region {
            id,
            area_px: self.area as usize,
            centroid_px: [self.x / self.area, self.y / self.area],
            bbox_px: BoundingBox {
                x: self.left,
                y: self.top,
                width: self.right - self.left,
                height: self.bottom - self.top,
            },
            orientation_deg: (elongation >= LEAST_ELONGATION).then_some(if angle_deg >= 90.0 {
                angle_deg - 180.0
            } else {
                angle_deg
            }),
            elongation,
            touches_border: self.left == 0 || self.top == 0 || self.right == width || self.bottom == height,
            is_darker: false,
            pieces: vec![],
        }
    }
}
