//! Paper B, section 4, past the text: rigs of other kinds than two focus settings whose optics are known. Rendered scenes of known
//! depth, seeds 301 to 303; 16 pixels at the border left out. Parameters were chosen on seeds 11, 12, 21, 31 and 40 to 43.

use landmarkd_core::depth::scene::{Camera, Relief, Scene, Texture, bench_aperture_pair, bench_optics};
use landmarkd_core::depth::{
    Aperture, BlurScaleError, Calibration, DepthMap, DepthOptions, Estimator, FocusStack, Method, Optics,
    OpticsSpec, Pair, Scenery, Sensor, StackEstimator, StackOptics, StackSpec, Sweep, Warning, blur_scale,
    predicted,
};
use landmarkd_core::imaging::{Frame, Image};

use super::depth::Figures;

const SEEDS: [u64; 3] = [301, 302, 303];

fn aperture_pairs() -> [(&'static str, Optics); 3] {
    [
        ("f/2.8 and f/8, beyond", bench_aperture_pair([2.8, 8.0], 540.0, false)),
        ("f/2.8 and f/8, before", bench_aperture_pair([2.8, 8.0], 470.0, false)),
        ("f/4 and f/11, telecentric", bench_aperture_pair([4.0, 11.0], 545.0, true)),
    ]
}

/// The map of a pair by the optics alone, and its figures.
fn figures(camera: &Camera, scene: &Scene, calibration: &Calibration, method: Method) -> Figures {
    let options = DepthOptions { method, ..DepthOptions::default() };
    let estimator = Estimator::new(calibration, &options).unwrap();
    let mut figures = Figures::default();
    for seed in SEEDS {
        let seen = camera.photograph(&Scene { seed, ..*scene });
        let map = estimator.estimate(&seen.pair().unwrap(), &mut |_| {}).unwrap();
        figures.add(&seen, &map, camera.optics.range_mm());
    }
    figures
}

#[test]
fn two_apertures_measure_as_well_as_two_focus_settings() {
    for (what, optics) in aperture_pairs() {
        for (texture, method, most, least_coverage) in [
            (Texture::Gravel, Method::Gram, 0.6, 98.0),
            (Texture::Noise, Method::Gram, 0.7, 95.0),
            (Texture::Gravel, Method::Stm, 1.6, 80.0),
        ] {
            let scene = Scene::new(Relief::Slant, texture, 0);
            let found = figures(&Camera::new(optics), &scene, &Calibration::of(optics), method);
            found.say(&format!("{what}, slant, {texture:?}, {method:?}"));
            assert!(
                found.rms() <= most && found.coverage() >= least_coverage && found.beyond() <= 3.0,
                "{what}"
            );
        }
    }
}

#[test]
fn what_two_apertures_are_predicted_to_measure_is_what_they_measure() {
    for (what, optics) in aperture_pairs() {
        for share in [0.1, 0.5, 0.9] {
            let scene = Scene::new(Relief::Plane { share }, Texture::Noise, 0);
            let found = figures(&Camera::new(optics), &scene, &Calibration::of(optics), Method::Gram);
            let depth_mm = optics.near_focus_mm() + share * optics.range_mm();
            let scenery = Scenery { contrast: scene.contrast, noise_sigma: 1.0 };
            let expected_mm = predicted(&optics, &scenery, &[depth_mm]).expected[0].sigma_mm.unwrap();
            let expected = 100.0 * expected_mm / optics.range_mm();
            println!(
                "{what}, {depth_mm:.0} mm: RMS {:.2} % of range, predicted {expected:.2} %",
                found.rms()
            );
            assert!(
                found.rms() <= 2.0 * expected && found.rms() >= 0.3 * expected,
                "{what}, {depth_mm:.0} mm"
            );
        }
    }
}

#[test]
fn what_stands_on_the_other_side_of_the_focus_is_taken_for_this_one() {
    // Nothing in the pictures tells the sides apart: whoever states the range does.
    let optics = bench_aperture_pair([2.8, 8.0], 540.0, false);
    let seen =
        Camera::new(optics).photograph(&Scene::new(Relief::Plane { share: -0.9 }, Texture::Gravel, SEEDS[0]));
    let truth_mm = seen.depth_mm[0];
    let estimator = Estimator::new(&Calibration::of(optics), &DepthOptions::default()).unwrap();
    let map = estimator.estimate(&seen.pair().unwrap(), &mut |_| {}).unwrap();
    let told_mm = map.summary.depth.unwrap().median;
    println!("a plane at {truth_mm:.1} mm, before the focus at 500 mm, is told at {told_mm:.1} mm");
    assert!(truth_mm < 500.0 && told_mm > 500.0);
    let other = bench_aperture_pair([2.8, 8.0], 470.0, false);
    let estimator = Estimator::new(&Calibration::of(other), &DepthOptions::default()).unwrap();
    // There the stopped-down picture is the first.
    let pair = seen.exchanged_pair().unwrap();
    let told_mm = estimator.estimate(&pair, &mut |_| {}).unwrap().summary.depth.unwrap().median;
    assert!((told_mm - truth_mm).abs() < 0.01 * other.range_mm(), "{told_mm:.2} mm, not {truth_mm:.2}");
}

#[test]
fn exchanged_apertures_are_noticed() {
    for (what, optics) in aperture_pairs() {
        let seen = Camera::new(optics).photograph(&Scene::new(Relief::Slant, Texture::Gravel, SEEDS[0]));
        let estimator = Estimator::new(&Calibration::of(optics), &DepthOptions::default()).unwrap();
        let warned = [seen.pair().unwrap(), seen.exchanged_pair().unwrap()].map(|pair| {
            let map = estimator.estimate(&pair, &mut |_| {}).unwrap();
            map.summary.warnings.contains(&Warning::NearFarSwapped)
        });
        assert_eq!(warned, [false, true], "{what}");
    }
}

#[test]
fn a_sweep_mends_apertures_that_are_other_than_stated() {
    let truth = bench_aperture_pair([2.8, 8.0], 540.0, false);
    let stated = bench_aperture_pair([3.0, 8.0], 540.0, false);
    let camera = Camera::new(truth);
    let scene = Scene::new(Relief::Slant, Texture::Gravel, 0);
    let before = figures(&camera, &scene, &Calibration::of(stated), Method::Gram);
    let depths_mm: Vec<f64> = (0..13).map(|k| stated.depth_mm(1.1 - 2.2 * f64::from(k) / 12.0)).collect();
    let mut sweep = Sweep::new(&Calibration::of(stated), Method::Gram, &depths_mm).unwrap();
    for &depth_mm in &depths_mm {
        let share = (depth_mm - truth.near_focus_mm()) / truth.range_mm();
        let plane = Scene::new(Relief::Plane { share }, Texture::Gravel, 304);
        sweep.add(depth_mm, &camera.photograph(&plane).pair().unwrap()).unwrap();
    }
    let swept = sweep.fit(false, &mut |_, _| true).unwrap().unwrap();
    let after = figures(&camera, &scene, &swept, Method::Gram);
    before.say("f/3 stated for f/2.8");
    after.say("the same after a sweep");
    assert!(before.rms() > 1.5 && after.rms() < 0.8);
}

#[test]
fn an_unknown_aperture_is_measured_from_one_textured_pair() {
    let mut beyond = 0;
    let mut all = 0;
    for f_number in [9.0, 7.5, 6.0, 4.5] {
        for (telecentric, relief, texture) in [
            (true, Relief::Slant, Texture::Gravel),
            (true, Relief::Cone, Texture::Noise),
            (false, Relief::Slant, Texture::Gravel),
            (false, Relief::Staircase, Texture::Gravel),
        ] {
            let truth = bench_optics(f_number, telecentric);
            let seen = Camera::new(truth).photograph(&Scene::new(relief, texture, SEEDS[0]));
            let blur_px = truth.largest_blur_px();
            // What is stated of the aperture doesn't count.
            let found = blur_scale(&bench_optics(11.0, telecentric), &seen.pair().unwrap());
            let what =
                format!("f/{f_number}, {relief:?}, {texture:?}, telecentric {telecentric}, {blur_px:.2} px");
            let Ok(found) = found else {
                println!("{what}: refused");
                continue;
            };
            let found_px = found.optics.largest_blur_px();
            println!(
                "{what}: {found_px:.2} ± {:.2} px, {:+.1} %",
                found.sigma_px,
                100.0 * (found_px / blur_px - 1.0)
            );
            all += 1;
            beyond += u32::from((found_px - blur_px).abs() > 3.0 * found.sigma_px);
        }
    }
    assert!(all >= 12 && beyond == 0, "{all} of 16 measured, {beyond} beyond 3 sigma");
}

#[test]
fn depths_by_a_measured_aperture_are_worse_by_its_error_alone() {
    let truth = bench_optics(7.0, true);
    let camera = Camera::new(truth);
    let scene = Scene::new(Relief::Slant, Texture::Gravel, SEEDS[0]);
    let seen = camera.photograph(&scene);
    let found = blur_scale(&bench_optics(11.0, true), &seen.pair().unwrap()).unwrap();
    let by_truth = figures(&camera, &scene, &Calibration::of(truth), Method::Gram);
    let estimator = Estimator::new(&Calibration::of(found.optics), &DepthOptions::default()).unwrap();
    let map = estimator.estimate(&seen.pair().unwrap(), &mut |_| {}).unwrap().with_error_of(&found);
    let mut by_found = Figures::default();
    by_found.add(&seen, &map, truth.range_mm());
    by_truth.say("aperture known");
    by_found.say("aperture measured");
    assert!(by_found.rms() < 2.0 && by_found.beyond() <= 3.0);
}

#[test]
fn a_pair_that_fixes_no_blur_is_refused() {
    let cases = [
        ("plain", bench_optics(8.0, true), Relief::Slant, Texture::Plain),
        ("stripes", bench_optics(8.0, true), Relief::Slant, Texture::Stripes { period_px: 10.0 }),
        ("blur of 2 px", bench_optics(20.0, true), Relief::Slant, Texture::Gravel),
        ("two apertures", bench_aperture_pair([2.8, 8.0], 540.0, false), Relief::Slant, Texture::Gravel),
    ];
    for (what, optics, relief, texture) in cases {
        let seen = Camera::new(optics).photograph(&Scene::new(relief, texture, SEEDS[0]));
        assert_eq!(blur_scale(&optics, &seen.pair().unwrap()), Err(BlurScaleError::Unclear), "{what}");
    }
}

/// A lens of 35 mm at f/8, focused at 500 mm and on by steps of .4 mm of the sensor.
fn planes_mm(pictures: usize) -> Vec<f64> {
    let first_mm = 35.0 * 500.0 / 465.0;
    (0..pictures).map(|k| first_mm - 0.4 * k as f64).collect()
}

fn stack_optics(planes_mm: &[f64], telecentric: bool) -> StackOptics {
    StackOptics::new(&StackSpec {
        focal_length_mm: 35.0,
        aperture: Aperture::FNumber(8.0),
        sensors: planes_mm.iter().map(|&mm| Sensor::PlaneMm(mm)).collect(),
        pixel_pitch_um: 10.0,
        telecentric,
        principal_point_px: None,
    })
    .unwrap()
}

/// Pictures of a textured scene whose pixels have these depths, by the settings of a stack.
fn stack_of(planes_mm: &[f64], telecentric: bool, depth_mm: &[f64], seed: u64) -> FocusStack {
    let sharp = Camera { noise: 0.0, ..Camera::new(bench_optics(8.0, true)) };
    let light = sharp.photograph(&Scene::new(Relief::Plane { share: 0.0 }, Texture::Gravel, seed));
    let light = light.pair().unwrap().near().clone();
    let picture = |k: usize| {
        // With the first as a pair: its own far picture, or with the second its near one.
        let optics = Optics::new(&OpticsSpec {
            focal_length_mm: 35.0,
            pair: Pair::Focal {
                aperture: Aperture::FNumber(8.0),
                near_sensor: Sensor::PlaneMm(planes_mm[0]),
                plane_separation_mm: planes_mm[0] - planes_mm[k.max(1)],
            },
            pixel_pitch_um: 10.0,
            telecentric,
            principal_point_px: None,
        });
        let camera = Camera::new(optics.unwrap());
        let seen = camera.photograph_map(&light, depth_mm.to_vec(), seed + 10 * k as u64);
        let levels = if k == 0 { seen.near } else { seen.far };
        Frame::gray(Image::new(seen.width, seen.height, levels.into_iter().map(f32::from).collect()))
    };
    FocusStack::new((0..planes_mm.len()).map(picture).collect(), 8).unwrap()
}

/// RMS and coverage in percent of the range and of the pixels, and the share beyond three predicted deviations.
fn stack_figures(map: &DepthMap, depth_mm: &[f64], range_mm: f64) -> [f64; 3] {
    let (mut squares, mut known, mut beyond, mut all) = (0.0, 0.0, 0.0, 0.0);
    for (at, &truth_mm) in depth_mm.iter().enumerate() {
        let (x, y) = (at % map.width(), at / map.width());
        if x < 16 || y < 16 || x + 16 >= map.width() || y + 16 >= map.height() {
            continue;
        }
        all += 1.0;
        let error_mm = f64::from(map.depth_mm()[at]) - truth_mm;
        if error_mm.is_nan() {
            continue;
        }
        known += 1.0;
        squares += error_mm * error_mm;
        beyond += f64::from(error_mm.abs() > 3.0 * f64::from(map.sigma_mm()[at]));
    }
    [100.0 * (squares / known).sqrt() / range_mm, 100.0 * known / all, 100.0 * beyond / known]
}

#[test]
fn a_focus_stack_measures_over_all_of_its_settings() {
    for (pictures, telecentric) in [(3, true), (3, false), (5, true)] {
        let planes_mm = planes_mm(pictures);
        let optics = stack_optics(&planes_mm, telecentric);
        let whole = optics.whole();
        let slant = |at: usize| whole.depth_mm(0.95 - 1.9 * (at % 256) as f64 / 255.0);
        let depth_mm: Vec<f64> = (0..256 * 240).map(slant).collect();
        let stack = stack_of(&planes_mm, telecentric, &depth_mm, SEEDS[0]);
        let estimator = StackEstimator::new(&optics, &DepthOptions::default()).unwrap();
        let map = estimator.estimate(&stack, &mut |_| {});
        let [rms, coverage, beyond] = stack_figures(&map, &depth_mm, whole.range_mm());
        let alone = Estimator::new(&Calibration::of(optics.pairs()[0]), &DepthOptions::default()).unwrap();
        let alone = alone.estimate(stack.first_pair(), &mut |_| {}).unwrap();
        let [_, alone_coverage, _] = stack_figures(&alone, &depth_mm, whole.range_mm());
        println!(
            "{pictures} pictures, telecentric {telecentric}, {:.0} to {:.0} mm: RMS {rms:.2} % of range, coverage {coverage:.1} % \
             ({alone_coverage:.1} % by the first two), {beyond:.2} % beyond 3 sigma",
            whole.near_focus_mm(),
            whole.far_focus_mm()
        );
        assert!(rms < 0.6 && coverage > 90.0 && beyond <= 3.0);
        assert!(alone_coverage < 0.7 * coverage);
    }
}

#[test]
fn what_stands_beyond_a_stack_has_no_depth() {
    let planes_mm = planes_mm(3);
    let optics = stack_optics(&planes_mm, true);
    for beta in [-1.5, 1.5] {
        let depth_mm = vec![optics.whole().depth_mm(beta); 256 * 240];
        let stack = stack_of(&planes_mm, true, &depth_mm, SEEDS[1]);
        let map =
            StackEstimator::new(&optics, &DepthOptions::default()).unwrap().estimate(&stack, &mut |_| {});
        println!("β {beta}: coverage {:.2} %", 100.0 * map.summary.coverage);
        assert!(map.summary.coverage < 0.01);
    }
}
