//! A region of a picture on the wire.

use serde::Serialize;
use utoipa::ToSchema;

use landmarkd_core::vision::segmentation::{LeftOut, Noise, Piece, Region};

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
    /// Whether it is darker than the ground in the mean.
    #[schema(required = false)]
    pub darker: bool,
    /// Whether it may be several parts that touch: `pieces` says which. Where the shape is clear they are divided, and are
    /// regions of their own.
    #[schema(required = false)]
    pub touching: bool,
    /// With `touching`: the parts that it may consist of.
    #[schema(required = false)]
    pub pieces: Vec<PieceBody>,
}

/// What may be a part of its own within a region.
#[derive(Debug, Serialize, ToSchema)]
pub struct PieceBody {
    /// Its pixels.
    pub area_px: usize,
    /// The mean of its pixels, x and y.
    pub centroid_px: [f64; 2],
}

/// What differs from the ground and is no region.
#[derive(Debug, Serialize, ToSchema)]
pub struct LeftOutBody {
    /// The least area of a region: `min_area_px`, or chosen so that noise hardly reaches it.
    pub least_area_px: usize,
    /// How much was left out for being smaller.
    pub small: usize,
    /// The areas of the largest of that, descending, at most 20.
    pub small_areas_px: Vec<usize>,
    /// Straight thin lines that lead out of the picture on both sides.
    pub lines: usize,
    /// Parts whose shadow was left out.
    pub shadows: usize,
}

/// The ground, in gray levels of the luminance.
#[derive(Debug, Serialize, ToSchema)]
pub struct GroundBody {
    /// Standard deviation of its pixels about its level: noise and texture.
    pub deviation: f64,
    /// By how much a pixel has to differ from it.
    pub offset: f64,
    /// Part of the picture that is ground.
    #[schema(minimum = 0, maximum = 1)]
    pub part: f64,
    /// Side of the squares that were averaged because of its texture; 1: none.
    #[schema(minimum = 1)]
    pub averaged_px: usize,
}

impl From<&LeftOut> for LeftOutBody {
    fn from(left_out: &LeftOut) -> Self {
        Self {
            least_area_px: left_out.least_area_px,
            small: left_out.small,
            small_areas_px: left_out.small_areas_px.clone(),
            lines: left_out.lines,
            shadows: left_out.shadows.left_out,
        }
    }
}

impl From<Noise> for GroundBody {
    fn from(noise: Noise) -> Self {
        Self {
            deviation: noise.deviation.into(),
            offset: noise.offset.into(),
            part: noise.ground_part.into(),
            averaged_px: noise.averaged_px,
        }
    }
}

impl From<&Piece> for PieceBody {
    fn from(piece: &Piece) -> Self {
        Self { area_px: piece.area_px, centroid_px: piece.centroid_px }
    }
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
            darker: region.is_darker,
            touching: !region.pieces.is_empty(),
            pieces: region.pieces.iter().map(PieceBody::from).collect(),
        }
    }
}
