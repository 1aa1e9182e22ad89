//! The distance of a part: the depth map within its region.

use crate::depth::DepthMap;
use crate::statistics::median;
use crate::vision::segmentation::{Region, Segmentation};

/// The distance of a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartDistance {
    /// Median of the depths within the region.
    pub distance_mm: f64,
    /// Standard deviation to be expected, by the median of that of single depths. `None` if the method gives none.
    pub sigma_mm: Option<f64>,
    /// Part of the region's pixels that have a depth, above 0.
    pub coverage: f64,
}

impl PartDistance {
    /// The distance of a region; `None` if none of its pixels has a depth.
    ///
    /// # Panics
    /// If map and segmentation are of different size.
    pub fn of(region: &Region, segmentation: &Segmentation, map: &DepthMap) -> Option<PartDistance> {
        let size = (segmentation.width(), segmentation.height());
        assert_eq!((map.width(), map.height()), size, "a map of the picture's size");
        let inside = segmentation
            .runs(region)
            .flat_map(|(row, columns)| columns.map(move |x| row * map.width() + x))
            .filter(|&at| map.depth_mm()[at].is_finite());
        let (mut depths, mut sigmas): (Vec<f32>, Vec<f32>) =
            inside.map(|at| (map.depth_mm()[at], map.sigma_mm()[at])).unzip();
        sigmas.retain(|sigma| sigma.is_finite());
        let coverage = depths.len() as f64 / region.area_px as f64;
        let median = |values: &mut [f32]| median(values, f32::total_cmp).map(f64::from);
        let sigma_mm = median(&mut sigmas).map(|sigma_mm| map.sigma_of_median_mm(sigma_mm, depths.len()));
        Some(PartDistance { distance_mm: median(&mut depths)?, sigma_mm, coverage })
    }
}
