//! A table of 640 × 480 pixels with five parts: its segmentation by each threshold, in colour, on a texture; its
//! inspection against ten objects of 36 views, and the stages of that. One smoothing of the picture is the baseline.

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use landmarkd_core::imaging::{Frame, Image};
use landmarkd_core::recognition::objects::{Normaliser, ObjectOptions, View, ViewName, train};
use landmarkd_core::vision::segmentation::{SegmentationOptions, Threshold, segmented};
use landmarkd_core::vision::smoothing::smoothed;
use landmarkd_core::workcell::{Correspondence, Mapping, Stage, Workcell, inspect};

const SIDE_PX: usize = 128;
/// Where the parts lie, and how they are turned.
const PARTS: [([f64; 2], f64); 5] = [
    ([110.0, 120.0], 33.0),
    ([330.0, 100.0], 123.0),
    ([540.0, 140.0], 211.0),
    ([200.0, 350.0], 287.0),
    ([470.0, 360.0], 354.0),
];

/// A light plate with eight dark spots, another for each seed.
struct Plate {
    half: [f64; 2],
    spots: Vec<[f64; 3]>,
}

impl Plate {
    fn new(seed: u64) -> Plate {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) + 1;
        let mut next = |from: f64, to: f64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            from + (to - from) * (state >> 40) as f64 / (1u64 << 24) as f64
        };
        let half = [next(35.0, 50.0), next(20.0, 30.0)];
        let spots = (0..8).map(|_| [next(-40.0, 40.0), next(-20.0, 20.0), next(20.0, 80.0)]).collect();
        Plate { half, spots }
    }

    /// The light at a point from its middle, the plate being turned; `None` beside it.
    fn at(&self, [dx, dy]: [f64; 2], turn_deg: f64) -> Option<f64> {
        let (sin, cos) = turn_deg.to_radians().sin_cos();
        let (x, y) = (cos * dx + sin * dy, cos * dy - sin * dx);
        let inside = x.abs() <= self.half[0] && y.abs() <= self.half[1];
        let dark = |[sx, sy, size]: &[f64; 3]| 120.0 * (-((x - sx).powi(2) + (y - sy).powi(2)) / size).exp();
        inside.then(|| (200.0 - self.spots.iter().map(dark).sum::<f64>()).max(60.0))
    }
}

/// A dark cloth at a pixel.
fn cloth(x: usize, y: usize) -> f64 {
    12.0 + ((7 * x + 13 * y) % 5) as f64
}

fn workcell(criterion: &mut Criterion) {
    let plates: Vec<Plate> = (0..10).map(Plate::new).collect();
    let options = ObjectOptions { segment: true, ..ObjectOptions::default() };
    let normaliser = Normaliser::new(&options, (SIDE_PX as u32, SIDE_PX as u32));
    let alone = |plate: &Plate, turn_deg: f64| {
        Image::from_fn(SIDE_PX, SIDE_PX, |x, y| {
            let from_middle = [x as f64 - 64.0, y as f64 - 64.0];
            plate.at(from_middle, turn_deg).unwrap_or_else(|| cloth(x, y)) as f32
        })
    };
    let turns = (0..plates.len()).flat_map(|n| (0..36).map(move |view| (n, 10.0 * f64::from(view))));
    let views = turns.map(|(n, pose_deg)| {
        let name = ViewName { id: format!("{n} {pose_deg}"), label: n.to_string(), pose_deg: Some(pose_deg) };
        View::new(&normaliser, name, &Frame::gray(alone(&plates[n], pose_deg)), true).expect("a plate")
    });
    let (model, _) = train(views.collect(), &normaliser, &options).expect("views differ");

    // light that falls off by a fifth
    let picture = Image::from_fn(640, 480, |x, y| {
        let parts = PARTS.iter().zip(&plates);
        let light = parts
            .filter_map(|(([left, top], turn_deg), plate)| {
                plate.at([x as f64 - left, y as f64 - top], *turn_deg)
            })
            .next();
        ((1.0 - 0.2 * x as f64 / 640.0) * light.unwrap_or_else(|| cloth(x, y))) as f32
    });
    let correspondences = [[0.0, 0.0], [640.0, 0.0], [0.0, 480.0]]
        .map(|[x, y]| Correspondence { image_px: [x, y], robot_mm: [x / 2.0, -y / 2.0] });
    let cell = Workcell {
        mapping: Mapping::fit(&correspondences, None, true).expect("three corners"),
        flip_y: true,
        local: None,
        tolerance_px: 1.0,
        segmentation: SegmentationOptions::default(),
    };
    let frame = Frame::gray(picture.clone());
    assert_eq!(inspect(&frame, &cell, &model, |_| ()).parts.len(), PARTS.len());

    let mut group = criterion.benchmark_group("640×480, five parts");
    group.bench_function("baseline: smoothing", |b| b.iter(|| smoothed(black_box(&picture), 2.0)));
    for (name, threshold) in
        [("adaptive", Threshold::Adaptive), ("otsu", Threshold::Otsu), ("fixed", Threshold::Fixed(40.0))]
    {
        let options = SegmentationOptions { threshold, ..SegmentationOptions::default() };
        assert_eq!(segmented(&picture, &options).found, PARTS.len(), "{name}");
        group.bench_function(name, |b| b.iter(|| segmented(black_box(&picture), &options)));
    }
    let default = SegmentationOptions::default();
    let colour = Frame::colour(
        [1.0, 0.9, 0.8].map(|part| Image::new(640, 480, picture.pixels().iter().map(|v| part * v).collect())),
    );
    group.bench_function("adaptive, colour", |b| b.iter(|| segmented(black_box(&colour), &default)));
    let textured = Image::from_fn(640, 480, |x, y| {
        let grain = ((x / 2 * 7919 + y / 2 * 104_729) % 61) as f32 - 30.0;
        picture.at(x, y) + grain + 60.0
    });
    assert_eq!(segmented(&textured, &default).found, PARTS.len());
    group.bench_function("adaptive, texture", |b| b.iter(|| segmented(black_box(&textured), &default)));
    group.bench_function("inspecting", |b| b.iter(|| inspect(black_box(&frame), &cell, &model, |_| ())));
    for stage in [Stage::Segment, Stage::Crop, Stage::Recognise] {
        group.bench_function(format!("inspecting: {stage:?}"), |b| {
            b.iter_custom(|rounds| {
                let mut spent = Duration::ZERO;
                for _ in 0..rounds {
                    let mut last = Instant::now();
                    black_box(inspect(black_box(&frame), &cell, &model, |finished| {
                        let now = Instant::now();
                        if finished == stage {
                            spent += now - last;
                        }
                        last = now;
                    }));
                }
                spent
            });
        });
    }
    group.finish();
}

criterion_group!(benches, workcell);
criterion_main!(benches);
