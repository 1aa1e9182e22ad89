//! The nearest of N eigenpoints of D coordinates for 64 queries: the tree beside looking at all; several nearest; and the
//! inverted index beside the product with all.
//!
//! Coordinates spread as the eigenvalues of real signatures do, ever less: half the variance lies in the
//! first few. Half of the queries are eigenpoints seen again with some noise (a hit), half are new (a
//! miss): background is always new, and a tree has to look at most of its leaves for it.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use landmarkd_core::eigen::{EigenpointIndex, InvertedIndex, RadiusIndex, Search};
use landmarkd_core::imaging::Random;
use landmarkd_core::statistics::median;

const QUERIES: usize = 64;

fn cloud(count: usize, dimension: usize, mut state: u64) -> Vec<f32> {
    let mut uniform = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1u64 << 24) as f32 - 0.5
    };
    // a sum of four is bell-shaped enough
    let mut bell = || uniform() + uniform() + uniform() + uniform();
    (0..count * dimension).map(|i| 0.2 * bell() / ((i % dimension) as f32 + 1.0).sqrt()).collect()
}

fn search(criterion: &mut Criterion) {
    for dimension in [8, 16, 32, 64] {
        let mut group = criterion.benchmark_group(format!("64 queries of {dimension} coordinates"));
        group
            .sample_size(10)
            .warm_up_time(Duration::from_millis(300))
            .measurement_time(Duration::from_secs(1));
        group.throughput(Throughput::Elements(QUERIES as u64));
        for count in [1_280, 10_000, 100_000] {
            let points = cloud(count, dimension, 1);
            let new = cloud(QUERIES, dimension, 2);
            let noise = cloud(QUERIES / 2, dimension, 3);
            let again = (points.iter().zip(&noise)).map(|(p, n)| p + 0.05 * n);
            let queries: Vec<f32> = again.chain(new[noise.len()..].iter().copied()).collect();
            let index = EigenpointIndex::with_tree(points, dimension);
            assert!(index.has_tree());
            group.bench_with_input(BenchmarkId::new("tree", count), &queries, |b, queries| {
                b.iter(|| black_box(index.nearest(queries)));
            });
            group.bench_with_input(BenchmarkId::new("looking at all", count), &queries, |b, queries| {
                b.iter(|| black_box(index.nearest_several(queries, 1)));
            });
        }
        group.finish();
    }
}

/// The several nearest for the 500 queries of a frame, beside the nearest alone.
fn several(criterion: &mut Criterion) {
    const DIMENSION: usize = 32;
    let mut group = criterion.benchmark_group("500 queries of 32 coordinates");
    group.sample_size(10);
    let queries = cloud(500, DIMENSION, 2);
    for count in [2_560, 256_000] {
        let index = EigenpointIndex::new(cloud(count, DIMENSION, 1), DIMENSION);
        for asked in [1, 10, 30] {
            group.bench_with_input(
                BenchmarkId::new(format!("nearest {asked}"), count),
                &asked,
                |b, &asked| {
                    b.iter(|| black_box(index.nearest_several(&queries, asked)));
                },
            );
        }
    }
    group.finish();
}

/// The 31 nearest for the 1000 queries of a frame: the inverted index beside the product with all eigenpoints.
///
/// Of 5, 20, 100 and 1000 exemplars of 600 windows each. With N eigenpoints in √N lists, a query is compared with √N
/// centroids and, probing 24, some 25 √N vectors in all: of 48 coordinates, a product and a sum of whole numbers for each.
/// 60 000 eigenpoints: 0.29 G products a frame, and 5.8 MB read once or twice; 600 000: 0.93 G and 58 MB. A core that adds up
/// 32 products of 16 bits at 3 GHz has floors of 3 and 10 ms; memory of 20 GB/s has 0.3 and 3 ms. The product with all has
/// 2.9 and 29 G of f32.
fn inverted(criterion: &mut Criterion) {
    const DIMENSION: usize = 48;
    const QUERIES: usize = 1000;
    const COUNT: usize = 31;
    let mut group = criterion.benchmark_group("1000 queries of 48 coordinates, the 31 nearest");
    group.sample_size(10).throughput(Throughput::Elements(QUERIES as u64));
    for count in [3_000, 12_000, 60_000, 600_000] {
        let points = clusters(count, DIMENSION, 1);
        let queries = clusters(QUERIES, DIMENSION, 2);
        let exact = EigenpointIndex::new(points.clone(), DIMENSION);
        let index = InvertedIndex::new(points, DIMENSION);
        group.bench_with_input(BenchmarkId::new("product with all", count), &queries, |b, queries| {
            b.iter(|| black_box(exact.nearest_several(queries, COUNT)));
        });
        group.bench_with_input(BenchmarkId::new("inverted index", count), &queries, |b, queries| {
            b.iter(|| black_box(index.nearest_several(queries, COUNT)));
        });
    }
    group.finish();
}

/// Eigenpoints in 1000 clusters, as signatures of a scene's parts are.
fn clusters(count: usize, dimension: usize, seed: u64) -> Vec<f32> {
    let middles = cloud(1000, dimension, 7);
    let around = cloud(count, dimension, seed);
    let mut random = Random::new(seed, 5);
    let mut points = around;
    for point in points.chunks_exact_mut(dimension) {
        let cluster = (random.uniform() * 1000.0) as usize;
        let middle = &middles[cluster * dimension..][..dimension];
        point.iter_mut().zip(middle).for_each(|(value, middle)| *value = 0.7 * *value + middle);
    }
    points
}

/// All eigenpoints within a radius that holds about five: the three ways of an object database. They must agree
/// before they are timed.
fn vicinity(criterion: &mut Criterion) {
    for dimension in [8, 15, 36] {
        let mut group =
            criterion.benchmark_group(format!("within a radius, 64 queries of {dimension} coordinates"));
        group
            .sample_size(10)
            .warm_up_time(Duration::from_millis(300))
            .measurement_time(Duration::from_secs(1));
        group.throughput(Throughput::Elements(QUERIES as u64));
        for count in [720, 7_200, 72_000] {
            let points = cloud(count, dimension, 1);
            let noise = cloud(QUERIES, dimension, 3);
            let queries: Vec<f32> = points.iter().zip(&noise).map(|(p, n)| p + 0.05 * n).collect();
            let radius = usual_radius(&points, &queries, dimension);
            let searches =
                [("k-d tree", Search::KdTree), ("slabs", Search::Slabs), ("product", Search::Exhaustive)];
            let answer = |index: &RadiusIndex| -> Vec<_> {
                queries.chunks_exact(dimension).map(|query| index.within(query, radius)).collect()
            };
            let built =
                searches.map(|(name, search)| (name, RadiusIndex::new(points.clone(), dimension, search)));
            let expected = answer(&built[2].1);
            for (name, index) in &built {
                assert_eq!(answer(index), expected, "{name} gives other answers");
                group.bench_with_input(BenchmarkId::new(*name, count), index, |b, index| {
                    b.iter(|| black_box(answer(index)));
                });
            }
        }
        group.finish();
    }
}

/// The median distance of the fifth nearest.
fn usual_radius(points: &[f32], queries: &[f32], dimension: usize) -> f64 {
    let all = RadiusIndex::new(points.to_vec(), dimension, Search::Exhaustive);
    let fifth = |query: &[f32]| f64::from(all.within(query, f64::INFINITY)[4].distance);
    let mut distances: Vec<f64> = queries.chunks_exact(dimension).map(fifth).collect();
    median(&mut distances, f64::total_cmp).expect("there are queries")
}

criterion_group!(benches, search, several, inverted, vicinity);
criterion_main!(benches);
