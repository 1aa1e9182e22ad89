//! A million windows in memory: the 31 nearest eigenpoints for the 512 queries of a frame, of ten thousand to a million
//! windows; of ten million too if `LANDMARKD_BENCH_LARGE` is set. Printed before the timings: recall against the product
//! with all, seconds to build, bytes a window, and a frame held against the roofline of this core.
//!
//! The roofline is that of products and sums of f32. A vector holds twice as many whole numbers of 16 bits, so a scan of
//! them can exceed it where operations are the limit.
//!
//! The windows are drawn, with the distribution of real ones. Real are 770 thousand windows of 1316 photographs, 48
//! coordinates each, and 512 queries of photographs that are left out. They are not normally distributed: parts of
//! pictures are alike, and photographs of a place, or levels of a scale space, repeat a window. So a window lies about a
//! scene point, and a scene point about one of 1000 parts; all together have the deviations of real ones. Queries are
//! drawn about the same scene points. Distances over the median distance of any two windows, and recall of the 31
//! nearest by an inverted index of 1024 lists and f32 (FAISS, IVF1024,Flat, four rounds of k-means; 256 queries of those
//! drawn). Parts and deviations were chosen, of some twenty, for distances and recall like the real ones:
//!
//! | | 1st nearest | 10th | 31st | 8 probes | 16 | 24 | 64 |
//! | --- | --- | --- | --- | --- | --- | --- | --- |
//! | real, 694 thousand: median | 0.23 | 0.30 | 0.32 | 0.864 | 0.947 | 0.976 | 0.999 |
//! | 10th and 90th percentile | 0.09, 0.32 | 0.18, 0.36 | 0.20, 0.38 | | | | |
//! | drawn, a million: median | 0.22 | 0.30 | 0.33 | 0.892 | 0.956 | 0.979 | 0.997 |
//! | 10th and 90th percentile | 0.09, 0.32 | 0.19, 0.38 | 0.21, 0.41 | | | | |
//! | normally distributed, a million: median | 0.36 | 0.40 | 0.42 | 0.762 | 0.900 | 0.951 | 0.996 |
//! | 10th and 90th percentile | 0.33, 0.41 | 0.36, 0.45 | 0.38, 0.48 | | | | |
//!
//! Fewer windows are drawn farther apart than real ones are: the 31st of ten thousand is at 0.53, and at 0.43 of as many
//! real ones taken at random; of a hundred thousand at 0.42 and 0.36.

mod machine;

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use landmarkd_core::eigen::{EigenpointIndex, InvertedIndex, Neighbour};
use landmarkd_core::imaging::Random;
use landmarkd_core::statistics::median;
use machine::{Machine, least_seconds};

const DIMENSION: usize = 48;
const QUERIES: usize = 512;
const COUNT: usize = 31;
const SIZES: [usize; 3] = [10_000, 100_000, 1_000_000];
const LARGE: usize = 10_000_000;
/// Lists that a query probes, and bytes that are read of a window there, as the index has them: codes of 8 bits,
/// a square and a number.
const PROBES: f64 = 64.0;
const WINDOW_BYTES: f64 = (DIMENSION + 4 + 4) as f64;

/// Standard deviations of the coordinates of real windows: the square roots of the eigenvalues.
#[rustfmt::skip]
const DEVIATIONS: [f32; DIMENSION] = [
    0.869, 0.421, 0.369, 0.313, 0.237, 0.223, 0.183, 0.176, 0.165, 0.151, 0.149, 0.146,
    0.110, 0.105, 0.102, 0.0972, 0.0909, 0.0892, 0.0842, 0.0800, 0.0799, 0.0757, 0.0736, 0.0725,
    0.0696, 0.0688, 0.0693, 0.0657, 0.0642, 0.0633, 0.0578, 0.0574, 0.0564, 0.0559, 0.0549, 0.0538,
    0.0536, 0.0529, 0.0533, 0.0522, 0.0510, 0.0504, 0.0498, 0.0492, 0.0493, 0.0484, 0.0480, 0.0472,
];
const PARTS: f64 = 1000.0;
/// How far scene points deviate from their part: of the standard deviation, the least and the most.
const OF_PART: [f64; 2] = [0.13, 0.65];
const WINDOWS_A_SCENE_POINT: usize = 2;
/// How far windows deviate from their scene point.
const OF_SCENE_POINT: [f64; 2] = [0.0, 0.6];

/// Draws `count` windows about the scene points of an index of `size`, row-major; other ones for another seed.
fn windows(count: usize, size: usize, seed: u64) -> Vec<f32> {
    let mut random = Random::new(seed, 0);
    let mut points = Vec::with_capacity(count * DIMENSION);
    for _ in 0..count {
        let scene_point = (random.uniform() * (size / WINDOWS_A_SCENE_POINT) as f64) as u64;
        let mut of_scene_point = Random::new(scene_point, 1);
        let mut of_part = Random::new((of_scene_point.uniform() * PARTS) as u64, 2);
        let spread = of_part.between(OF_PART[0], OF_PART[1]);
        let middle = about(&[0.0; DIMENSION], 1.0, &mut of_part);
        let scene_point = about(&middle, spread, &mut of_scene_point);
        let deviation = random.between(OF_SCENE_POINT[0], OF_SCENE_POINT[1]);
        let window = about(&scene_point, deviation, &mut random);
        points.extend(window.iter().zip(&DEVIATIONS).map(|(value, scale)| *value as f32 * scale));
    }
    points
}

/// A vector about a middle one, whose variance it keeps.
fn about(middle: &[f64; DIMENSION], deviation: f64, random: &mut Random) -> [f64; DIMENSION] {
    let kept = (1.0 - deviation * deviation).sqrt();
    let mut vector = middle.map(|value| kept * value);
    for pair in vector.as_chunks_mut::<2>().0 {
        let [a, b] = random.normals();
        *pair = [pair[0] + deviation * a, pair[1] + deviation * b];
    }
    vector
}

/// The index that is measured, and all that is asked of it.
struct Measured(InvertedIndex);

impl Measured {
    fn new(points: Vec<f32>) -> Measured {
        Measured(InvertedIndex::new(&points, DIMENSION))
    }

    fn nearest(&self, queries: &[f32]) -> Vec<Neighbour> {
        self.0.nearest_several(queries, COUNT)
    }

    fn lists(&self) -> usize {
        self.0.lists()
    }

    fn bytes(&self) -> usize {
        self.0.bytes()
    }

    /// Operations and bytes of a frame: a product and a sum for each coordinate of each centroid and of each window of
    /// the lists probed; of the windows of lists that any query probes, what a list holds, once. Lists are taken to be
    /// of one size and probed independently.
    fn work(&self, size: usize) -> (f64, f64) {
        let lists = self.lists() as f64;
        let probed = PROBES.min(lists) / lists;
        let compared = lists + size as f64 * probed;
        let read = size as f64 * (1.0 - (1.0 - probed).powf(QUERIES as f64));
        (2.0 * (QUERIES * DIMENSION) as f64 * compared, (lists + read) * WINDOW_BYTES)
    }
}

/// The share of the `count` nearest that are among the `count` first found, over all queries.
fn recall(found: &[Neighbour], exact: &[Neighbour], count: usize) -> f64 {
    let among = |(found, exact): (&[Neighbour], &[Neighbour])| {
        let is_found = |one: &&Neighbour| found[..count].iter().any(|other| other.index == one.index);
        exact[..count].iter().filter(is_found).count()
    };
    let rows = found.chunks_exact(COUNT).zip(exact.chunks_exact(COUNT));
    rows.map(among).sum::<usize>() as f64 / (exact.len() / COUNT * count) as f64
}

fn seconds<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let begun = Instant::now();
    let done = work();
    (done, begun.elapsed().as_secs_f64())
}

/// The median distance of two windows drawn independently.
fn usual_distance(points: &[f32]) -> f64 {
    let (first, last) = points[..2 * QUERIES * DIMENSION].split_at(QUERIES * DIMENSION);
    let square =
        |(p, q): (&[f32], &[f32])| p.iter().zip(q).map(|(p, q)| f64::from(p - q).powi(2)).sum::<f64>();
    let pairs = first.chunks_exact(DIMENSION).zip(last.chunks_exact(DIMENSION));
    let mut distances: Vec<f64> = pairs.map(|pair| square(pair).sqrt()).collect();
    median(&mut distances, f64::total_cmp).expect("there are pairs")
}

/// Says how far the nearest are, over the usual distance.
fn print_distances(exact: &[Neighbour], usual: f64) {
    let of_rank = |rank: usize| {
        let mut distances: Vec<f32> = exact.chunks_exact(COUNT).map(|row| row[rank - 1].distance).collect();
        f64::from(median(&mut distances, f32::total_cmp).expect("there are queries")) / usual
    };
    let [first, tenth, last] = [1, 10, COUNT].map(of_rank);
    println!("  nearest {first:.3}, 10th {tenth:.3}, last of {COUNT} {last:.3} of the usual distance");
}

fn scale(criterion: &mut Criterion) {
    let machine = Machine::measured();
    let mut group = criterion
        .benchmark_group(format!("{QUERIES} queries of {DIMENSION} coordinates, the {COUNT} nearest"));
    group.sample_size(10).throughput(Throughput::Elements(QUERIES as u64));
    group.measurement_time(Duration::from_secs(3));
    let large = std::env::var_os("LANDMARKD_BENCH_LARGE").map(|_| LARGE);
    for size in SIZES.into_iter().chain(large) {
        let points = windows(size, size, 1);
        let queries = windows(QUERIES, size, 2);
        let usual = usual_distance(&points);
        let judge = EigenpointIndex::new(points.clone(), DIMENSION);
        let (exact, exact_s) = seconds(|| judge.nearest_several(&queries, COUNT));
        drop(judge);

        let (index, build_s) = seconds(|| Measured::new(points));
        let found = index.nearest(&queries);
        let least_s = least_seconds(|| index.nearest(&queries));
        let (operations, bytes) = index.work(size);
        println!("{size} windows in {} lists", index.lists());
        print_distances(&exact, usual);
        println!(
            "  recall@10 {:.4}, recall@{COUNT} {:.4}; built in {build_s:.1} s; {:.0} bytes a window",
            recall(&found, &exact, 10),
            recall(&found, &exact, COUNT),
            index.bytes() as f64 / size as f64
        );
        println!(
            "  a frame: {:.2} ms ({:.0} ms by the product with all), {:.0} MFLOP, {:.1} MB: {:.0} % of the roofline",
            1e3 * least_s,
            1e3 * exact_s,
            operations / 1e6,
            bytes / 1e6,
            100.0 * machine.floor(operations, bytes) / least_s
        );
        group.bench_with_input(BenchmarkId::new("inverted index", size), &queries, |b, queries| {
            b.iter(|| black_box(index.nearest(queries)));
        });
    }
    group.finish();
}

criterion_group!(benches, scale);
criterion_main!(benches);
