//! The nearest of N eigenpoints of D coordinates for 64 queries: the tree beside looking at all; and several nearest.
//! The inverted index is in `scale.rs`.
//!
//! Coordinates spread as the eigenvalues of real signatures do, ever less: half the variance lies in the
//! first few. Half of the queries are eigenpoints seen again with some noise (a hit), half are new (a
//! miss): background is always new, and a tree has to look at most of its leaves for it.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use landmarkd_core::eigen::{EigenpointIndex, RadiusIndex, Search};
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

criterion_group!(benches, search, several, vicinity);
criterion_main!(benches);
