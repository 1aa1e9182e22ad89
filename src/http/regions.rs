//! A region of a picture on the wire.

use serde::Serialize;
use utoipa::ToSchema;

use landmarkd_core::vision::segmentation::Region;

/// A connected part of a picture that stands out from its background.
#[derive(Debug, Serialize, ToSchema)]
pub struct RegionBody {
    /// From 1, the largest first; its pixels have this value in the label image.
    #[schema(minimum = 1)]
    pub id: usize,
    /// Its pixels.
    pub area_px: usize,
    /// The mean of its pixels, x and y.
    pub centroid_px: [f64; 2],
    /// x, y, width and height of the smallest upright rectangle around it.
    pub bbox_px: [usize; 4],
    /// Direction of its principal axis, in [-90, 90), from x towards y; null for one that is as broad as long.
    pub orientation_deg: Option<f64>,
    /// Length over breadth, by its second moments.
    #[schema(minimum = 1)]
    pub elongation: f64,
    /// Whether the picture cuts it, so that a part of it may be outside.
    pub touches_border: bool,
}

impl From<&Region> for RegionBody {
    fn from(region: &Region) -> Self {
        let bbox = region.bbox_px;
        Self {
            id: region.id,
            area_px: region.area_px,
            centroid_px: region.centroid_px,
            bbox_px: [bbox.x, bbox.y, bbox.width, bbox.height],
            orientation_deg: region.orientation_deg,
            elongation: region.elongation,
            touches_border: region.touches_border,
        }
    }
}
