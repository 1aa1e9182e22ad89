//! Focal pairs of scenes whose depth is known: what a camera with given optics would photograph.
//!
//! The scene's light is a smooth function (a cubic B-spline over samples half a pixel apart). Each sample spreads over a
//! disc of its own, and each pixel gathers the light of its square; where surfaces hide each other, rays through many
//! points of the lens do the same. An ordinary lens images the far-focused picture smaller, about the principal point.
//! Everything follows from the scene's seed.

mod point_spread;
mod rays;
mod relief;
mod spline;
mod texture;

use point_spread::{FINE, LightBuffer, PointSpreads};
use rays::{RadiusMap, gathered};
pub use relief::Relief;
pub use texture::Texture;

use super::{Aperture, Fault, FocalPair, Optics, OpticsSpec, Pair, PairError, Sensor};
use crate::imaging::{Frame, Image, Random, encode};

/// A rig for tests and examples: a lens of 35 mm, focused at 500 and at 583 mm, pixels of 10 µm. Its largest blur is 40 px
/// over the f-number.
///
/// # Panics
/// If the f-number makes no valid optics: 0.4 to 80 do.
pub fn bench_optics(f_number: f64, telecentric: bool) -> Optics {
    let pair = Pair::Focal {
        aperture: Aperture::FNumber(f_number),
        near_sensor: Sensor::FocusMm(500.0),
        plane_separation_mm: 0.4,
    };
    bench(pair, telecentric).expect("an f-number that makes a blur of 0.5 to 100 px")
}

/// The same lens before one sensor, focused at 500 mm and photographed with two f-numbers, for a working range that ends at
/// this distance.
///
/// # Panics
/// If they make no valid optics.
pub fn bench_aperture_pair(f_numbers: [f64; 2], range_end_mm: f64, telecentric: bool) -> Optics {
    let pair = Pair::Aperture {
        apertures: f_numbers.map(Aperture::FNumber),
        sensor: Sensor::FocusMm(500.0),
        range_end_mm,
    };
    bench(pair, telecentric).expect("f-numbers and a range that make a blur of 0.5 to 120 px")
}

fn bench(pair: Pair, telecentric: bool) -> Result<Optics, Vec<Fault>> {
    Optics::new(&OpticsSpec {
        focal_length_mm: 35.0,
        pair,
        pixel_pitch_um: 10.0,
        telecentric,
        principal_point_px: None,
    })
}

/// The scene before the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scene {
    /// How far away its parts are.
    pub relief: Relief,
    /// What its surfaces look like.
    pub texture: Texture,
    /// Standard deviation of the texture's light, in gray levels of 255; its mean is 120.
    pub contrast: f64,
    /// Whether a few glints shine beyond full scale.
    pub glints: bool,
    /// Of the texture and of the sensors' noise.
    pub seed: u64,
}

impl Scene {
    /// A scene of contrast 40 without glints.
    pub fn new(relief: Relief, texture: Texture, seed: u64) -> Scene {
        Scene { relief, texture, contrast: 40.0, glints: false, seed }
    }
}

/// What the scene is photographed with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Lens and sensors.
    pub optics: Optics,
    /// Width of both pictures in pixels.
    pub width: usize,
    /// Height of both pictures in pixels.
    pub height: usize,
    /// Standard deviation of a pixel's noise, in gray levels of 255.
    pub noise: f64,
    /// Bits a sample: 8 or 16.
    pub bits: u8,
    /// How much brighter the far-focused picture is.
    pub far_gain: f64,
    /// By how much the far-focused picture's content is displaced, x and y.
    pub far_shift_px: [f64; 2],
    /// Size of the far-focused picture over what the optics says.
    pub far_zoom: f64,
    /// By how much the far-focused picture's content is turned about the optical axis, x towards y.
    pub far_turn_deg: f64,
    /// Gray levels added to the far-focused picture.
    pub far_offset: f64,
    /// Power that the far-focused picture's light is raised to, as a part of full scale.
    pub far_gamma: f64,
}

/// Neighbours whose depths differ by more than this part of the working range lie on two surfaces.
const STEP: f64 = 0.05;
/// Rounds to find where a ray meets a surface; a plane that faces the camera needs one.
const RAY_ROUNDS: usize = 5;

impl Camera {
    /// A camera of 256 × 240 pixels with 8 bits, noise of one gray level, and sensors alike.
    pub fn new(optics: Optics) -> Camera {
        Camera {
            optics,
            width: 256,
            height: 240,
            noise: 1.0,
            bits: 8,
            far_gain: 1.0,
            far_shift_px: [0.0; 2],
            far_zoom: 1.0,
            far_turn_deg: 0.0,
            far_offset: 0.0,
            far_gamma: 1.0,
        }
    }

    /// Photographs a scene.
    ///
    /// # Panics
    /// If a surface stands within the focal length, or the bits are neither 8 nor 16: errors of the caller.
    pub fn photograph(&self, scene: &Scene) -> Rendered {
        assert!(matches!(self.bits, 8 | 16), "8 or 16 bits a sample, not {}", self.bits);
        let size = [self.width, self.height];
        let depth_mm = (0..self.width * self.height)
            .map(|at| {
                let place = [(at % self.width) as f64, (at / self.width) as f64];
                self.depth_mm(scene.relief.share(scene.relief.seen(place, size), place, size))
            })
            .collect();
        let margin_px = self.margin_px(scene);
        let [columns, rows] = size.map(|side| FINE * (side + 2 * margin_px));
        let mut texture = scene.texture.drawn(columns, rows, scene.contrast, scene.seed);
        if scene.glints {
            self.add_glints(&mut texture, margin_px, scene.seed);
        }
        let light = spline::coefficients(texture);
        let spreads = &mut PointSpreads::default();
        let [near, far] = [0, 1].map(|sensor| self.exposed(sensor, scene, &light, margin_px, spreads));
        self.rendered(&near, &far, depth_mm, scene.seed)
    }

    /// Photographs a picture whose every pixel has a depth: `light` in gray levels and `depth_mm` of the camera's size.
    /// What a nearer thing hides from the middle of the lens is taken to be as what is beside it.
    ///
    /// # Panics
    /// If the sizes differ from the camera's, or a depth lies within the focal length.
    pub fn photograph_map(&self, light: &Image, depth_mm: Vec<f64>, seed: u64) -> Rendered {
        assert_eq!(
            (light.width(), light.height(), depth_mm.len()),
            (self.width, self.height, self.width * self.height)
        );
        let spline = spline::coefficients(light.clone());
        let [right, bottom] = [self.width - 1, self.height - 1].map(|last| last as f64);
        let [near, far] = [0, 1].map(|sensor| {
            let radius = |&depth_mm: &f64| self.blur_radius_px(sensor, depth_mm) as f32;
            let radii = Image::new(self.width, self.height, depth_mm.iter().map(radius).collect());
            let map = RadiusMap::new(radii);
            gathered([self.width, self.height], |place, lens| {
                let [x, y] = map.met(self.in_near_picture(sensor, place), lens);
                spline::value_at(&spline, x.clamp(0.0, right), y.clamp(0.0, bottom))
            })
        });
        self.rendered(&near, &far, depth_mm, seed)
    }

    fn rendered(&self, near: &[f32], far: &[f32], depth_mm: Vec<f64>, seed: u64) -> Rendered {
        let (near, far) = self.digitised(near, far, seed);
        let step_mm = STEP * self.optics.range_mm();
        Rendered { width: self.width, height: self.height, bits: self.bits, near, far, depth_mm, step_mm }
    }

    /// The place of the near-focused picture that shows what a place of a sensor shows.
    fn in_near_picture(&self, sensor: usize, [x, y]: [f64; 2]) -> [f64; 2] {
        if sensor == 0 {
            return [x, y];
        }
        let (scale, [dx, dy]) = (self.optics.far_scale() * self.far_zoom, self.far_shift_px);
        let centre = self.optics.principal_point(self.width, self.height);
        let (sin, cos) = self.far_turn_deg.to_radians().sin_cos();
        let (x, y) = ((x - dx - centre[0]) / scale, (y - dy - centre[1]) / scale);
        [centre[0] + cos * x + sin * y, centre[1] - sin * x + cos * y]
    }

    /// Half the signed blur diameter of a point on a sensor, in pixels of the near-focused picture.
    fn blur_radius_px(&self, sensor: usize, depth_mm: f64) -> f64 {
        0.5 * self.optics.registered_blur_px(self.optics.beta(depth_mm))[sensor]
    }

    /// The light on a sensor's pixels of a scene whose surfaces hide each other.
    fn seen_through_the_lens(
        &self,
        sensor: usize,
        scene: &Scene,
        light: &Image,
        margin_px: usize,
    ) -> Vec<f32> {
        let (size, relief) = ([self.width, self.height], scene.relief);
        let light = spline::of_squares(light);
        let sample_at = |px: f64, surface: usize, stride: usize| {
            (px + 0.5 + margin_px as f64) * FINE as f64 - 0.5 + (stride * FINE * surface) as f64
        };
        gathered(size, |place, lens| {
            let place = self.in_near_picture(sensor, place);
            let met = |surface: usize| {
                let mut at = place;
                for _ in 0..RAY_ROUNDS {
                    let depth_mm = self.depth_mm(relief.share(surface, at, size));
                    let radius_px = self.blur_radius_px(sensor, depth_mm);
                    let next = [place[0] - radius_px * lens[0], place[1] - radius_px * lens[1]];
                    if next == std::mem::replace(&mut at, next) {
                        break;
                    }
                }
                relief.reaches(surface, at, size).then_some((surface, at))
            };
            let seen = (0..relief.surfaces()).rev().find_map(met);
            let (surface, [x, y]) = seen.expect("the farthest surface is everywhere");
            spline::value_at(&light, sample_at(x, surface, 37), sample_at(y, surface, 53))
        })
    }

    /// The samples of both sensors for the light on their pixels: noise, gain, rounding.
    fn digitised(&self, near: &[f32], far: &[f32], seed: u64) -> (Vec<u16>, Vec<u16>) {
        let random = &mut Random::new(seed, 2);
        let full = f64::from(u16::MAX >> (16 - self.bits));
        let sample = |light: f32, noise: f64| {
            let level = f64::from(light) + self.noise * noise;
            (level / 255.0 * full).round().clamp(0.0, full) as u16
        };
        let samples = near.iter().zip(far).map(|(&near, &far)| {
            let [near_noise, far_noise] = random.normals();
            let far = 255.0 * (far.max(0.0) / 255.0).powf(self.far_gamma as f32) * self.far_gain as f32;
            (sample(near, near_noise), sample(far + self.far_offset as f32, far_noise))
        });
        samples.unzip()
    }

    fn depth_mm(&self, share: f64) -> f64 {
        self.optics.near_focus_mm() + share * self.optics.range_mm()
    }

    /// Width of the scene beyond the picture that sends light into it, with room for a far-focused picture
    /// that is smaller or displaced. In steps of 16 px, so that most cameras see one texture.
    fn margin_px(&self, scene: &Scene) -> usize {
        let corners = [[0, 0], [1, 0], [0, 1], [1, 1]]
            .map(|[x, y]| [x * (self.width - 1), y * (self.height - 1)].map(|v| v as f64));
        let middle = [self.width / 2, self.height / 2].map(|v| v as f64);
        let places = corners.iter().chain([&middle]);
        let blurs = places.flat_map(|&place| {
            let share = scene.relief.share(0, place, [self.width, self.height]);
            self.optics.blur_diameters_px(self.optics.beta(self.depth_mm(share)))
        });
        let blur_px = blurs.fold(self.optics.largest_blur_px(), |most, blur| most.max(blur.abs()));
        let shift_px = self.far_shift_px[0].abs().max(self.far_shift_px[1].abs());
        let wider = (1.0 / (self.optics.far_scale() * self.far_zoom) - 1.0).max(0.0)
            + self.far_turn_deg.to_radians().abs();
        let wider_px = self.width.max(self.height) as f64 * wider;
        ((0.6 * blur_px + shift_px + wider_px + 4.0) / 16.0).ceil() as usize * 16
    }

    /// The light that falls on the pixels of the near- (0) or the far-focused (1) sensor, in gray levels: by the disc that
    /// each sample becomes where nothing is hidden or turned, else by rays.
    fn exposed(
        &self,
        sensor: usize,
        scene: &Scene,
        light: &Image,
        margin_px: usize,
        spreads: &mut PointSpreads,
    ) -> Vec<f32> {
        if scene.relief.surfaces() > 1 || self.far_zoom != 1.0 || self.far_turn_deg != 0.0 {
            return self.seen_through_the_lens(sensor, scene, light, margin_px);
        }
        let view = View::new(self, sensor, light, margin_px);
        let own_light = view.light(light);
        let diameters = self.blur_diameters(&view, scene, spreads);
        let mut lit = LightBuffer::new(self.width, self.height, spreads.reach_px() + margin_px);
        for (at, &diameter) in diameters.iter().enumerate() {
            let place = [at % view.columns(), at / view.columns()];
            let share = 1.0 / (FINE * FINE) as f32;
            spreads.splat(&mut lit, place, margin_px, diameter, share * own_light.pixels()[at]);
        }
        lit.picture().collect()
    }

    /// Blur diameter of each sample of the scene on the view's sensor, in pixels. Prepares the kernels for them.
    fn blur_diameters(&self, view: &View, scene: &Scene, spreads: &mut PointSpreads) -> Vec<f32> {
        let columns = view.columns();
        (0..columns * view.y_px.len())
            .map(|at| {
                let place = [view.x_px[at % columns], view.y_px[at / columns]];
                let share = scene.relief.share(0, place, [self.width, self.height]);
                let beta = self.optics.beta(self.depth_mm(share));
                let diameter = self.optics.blur_diameters_px(beta)[view.sensor].abs() as f32;
                spreads.prepare(diameter);
                diameter
            })
            .collect()
    }

    /// Five small sources, far brighter than what the sensor holds.
    fn add_glints(&self, texture: &mut Image, margin_px: usize, seed: u64) {
        let random = &mut Random::new(seed, 3);
        let width = texture.width();
        for _ in 0..5 {
            let [x, y] = [self.width, self.height]
                .map(|side| (margin_px as f64 + random.between(0.15, 0.85) * side as f64) * FINE as f64);
            let radius = random.between(2.0, 5.0) * FINE as f64;
            for (at, value) in texture.pixels_mut().iter_mut().enumerate() {
                if ((at % width) as f64 - x).hypot((at / width) as f64 - y) < radius {
                    *value = 900.0;
                }
            }
        }
    }
}

/// For each sample of a sensor, the place in the near-focused picture that shows the same.
struct View {
    /// 0 near-focused, 1 far-focused.
    sensor: usize,
    margin_px: usize,
    /// Whether the samples are those of the scene.
    is_identity: bool,
    x_px: Vec<f64>,
    y_px: Vec<f64>,
}

impl View {
    fn new(camera: &Camera, sensor: usize, light: &Image, margin_px: usize) -> View {
        let (scale, shift_px) = match sensor {
            0 => (1.0, [0.0; 2]),
            _ => (camera.optics.far_scale(), camera.far_shift_px),
        };
        let centre = camera.optics.principal_point(camera.width, camera.height);
        let sample_px = |at: usize| (at as f64 + 0.5) / FINE as f64 - 0.5 - margin_px as f64;
        let axis = |length: usize, axis: usize| -> Vec<f64> {
            let (centre, shift_px) = (centre[axis], shift_px[axis]);
            (0..length).map(|at| centre + (sample_px(at) - shift_px - centre) / scale).collect()
        };
        View {
            sensor,
            margin_px,
            is_identity: scale == 1.0 && shift_px == [0.0; 2],
            x_px: axis(light.width(), 0),
            y_px: axis(light.height(), 1),
        }
    }

    fn columns(&self) -> usize {
        self.x_px.len()
    }

    /// The spline's coefficients of the light at the view's samples.
    fn light(&self, light: &Image) -> Image {
        if self.is_identity {
            return light.clone();
        }
        let sample_at = |px: f64| (px + 0.5 + self.margin_px as f64) * FINE as f64 - 0.5;
        spline::coefficients(Image::from_fn(light.width(), light.height(), |x, y| {
            spline::value_at(light, sample_at(self.x_px[x]), sample_at(self.y_px[y]))
        }))
    }
}

/// Both pictures of a scene, and the truth.
#[derive(Clone, Debug, PartialEq)]
pub struct Rendered {
    /// Width of both pictures in pixels.
    pub width: usize,
    /// Height of both pictures in pixels.
    pub height: usize,
    /// Bits a sample.
    pub bits: u8,
    /// Samples of the near-focused picture, row-major.
    pub near: Vec<u16>,
    /// Samples of the far-focused picture, row-major.
    pub far: Vec<u16>,
    /// Distance along the optical axis of what each pixel of the near-focused picture shows, in mm.
    pub depth_mm: Vec<f64>,
    /// Neighbouring pixels whose depths differ by more lie on two surfaces.
    step_mm: f64,
}

impl Rendered {
    /// The pair as it is when its files have been read.
    ///
    /// # Errors
    /// As of [`FocalPair::new`].
    pub fn pair(&self) -> Result<FocalPair, PairError> {
        let full = f32::from(u16::MAX >> (16 - self.bits));
        let frame = |samples: &[u16]| {
            let levels = samples.iter().map(|&sample| f32::from(sample) * 255.0 / full).collect();
            Frame::gray(Image::new(self.width, self.height, levels))
        };
        FocalPair::new(frame(&self.near), frame(&self.far), self.bits)
    }

    /// The same with the pictures exchanged.
    ///
    /// # Errors
    /// As of [`FocalPair::new`].
    pub fn exchanged_pair(&self) -> Result<FocalPair, PairError> {
        Rendered { near: self.far.clone(), far: self.near.clone(), ..self.clone() }.pair()
    }

    /// The near- and the far-focused picture as PNG files.
    pub fn pngs(&self) -> [Vec<u8>; 2] {
        [&self.near, &self.far].map(|samples| {
            if self.bits == 16 {
                return encode::png_gray16(self.width, self.height, samples);
            }
            let bytes: Vec<u8> = samples.iter().map(|&sample| sample as u8).collect();
            encode::png_gray8(self.width, self.height, &bytes)
        })
    }

    /// The pixels within a distance of a step in depth, row-major.
    pub fn near_step(&self, distance_px: f64) -> Vec<bool> {
        let depth_mm = &self.depth_mm;
        let mut marks = vec![false; depth_mm.len()];
        let reach = distance_px.ceil() as i64;
        let within = |at: usize, step: i64, side: usize| {
            let there = at as i64 + step;
            (0..side as i64).contains(&there).then_some(there as usize)
        };
        for at in 0..depth_mm.len() {
            let (x, y) = (at % self.width, at / self.width);
            let differs = |other: usize| (depth_mm[at] - depth_mm[other]).abs() > self.step_mm;
            let right = x + 1 < self.width && differs(at + 1);
            let below = y + 1 < self.height && differs(at + self.width);
            if !right && !below {
                continue;
            }
            // The step lies between two pixels.
            let (step_x, step_y) = (0.5 * f64::from(right), 0.5 * f64::from(below));
            for (down, across) in (-reach..=reach + 1).flat_map(|v| (-reach..=reach + 1).map(move |u| (v, u)))
            {
                let near = (down as f64 - step_y).hypot(across as f64 - step_x) <= distance_px;
                if let (true, Some(y), Some(x)) =
                    (near, within(y, down, self.height), within(x, across, self.width))
                {
                    marks[y * self.width + x] = true;
                }
            }
        }
        marks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn small(telecentric: bool) -> Camera {
        Camera { width: 64, height: 48, noise: 0.0, bits: 16, ..Camera::new(bench_optics(8.0, telecentric)) }
    }

    /// What a sensor sees of a scene whose only light is the sample at `x`, `y`, counted from the picture's corner.
    fn spot(camera: &Camera, sensor: usize, relief: Relief, [x, y]: [usize; 2]) -> Vec<f32> {
        let scene = Scene::new(relief, Texture::Plain, 1);
        let margin = camera.margin_px(&scene);
        let [columns, rows] = [camera.width, camera.height].map(|side| FINE * (side + 2 * margin));
        let light = Image::from_fn(columns, rows, |column, row| {
            let lit = column == x + FINE * margin && row == y + FINE * margin;
            f32::from(lit) * 800.0
        });
        let light = spline::coefficients(light);
        camera.exposed(sensor, &scene, &light, margin, &mut PointSpreads::default())
    }

    /// Light, mean x and variance along x of what a sensor sees of the four samples of a pixel, each about its own place.
    fn moments(camera: &Camera, sensor: usize, relief: Relief, [x, y]: [usize; 2]) -> [f64; 3] {
        let [mut light, mut mean, mut variance] = [0.0; 3];
        for sample in [[0, 0], [1, 0], [0, 1], [1, 1]] {
            let picture = spot(camera, sensor, relief, [FINE * x + sample[0], FINE * y + sample[1]]);
            let from = x as f64 - 0.25 + 0.5 * sample[0] as f64;
            for (at, value) in picture.into_iter().enumerate() {
                let (value, off) = (f64::from(value), (at % camera.width) as f64 - from);
                light += value / 4.0;
                mean += value * off / 800.0;
                variance += value * off * off / 800.0;
            }
        }
        let (mean, variance) = (mean * 200.0 / light, variance * 200.0 / light);
        [light, mean, variance - mean * mean]
    }

    #[test]
    fn a_point_is_spread_as_the_optics_say() {
        for share in [0.0, 0.1, 0.5, 1.0, 2.5] {
            let camera = small(true);
            let diameters = camera.optics.blur_diameters_px(camera.optics.beta(camera.depth_mm(share)));
            for (sensor, diameter_px) in diameters.into_iter().enumerate() {
                let [light, mean, variance] = moments(&camera, sensor, Relief::Plane { share }, [32, 20]);
                // The disc and the pixel's square.
                let theory = diameter_px.powi(2) / 16.0 + 1.0 / 12.0;
                assert!((light - 200.0).abs() < 0.1 && mean.abs() < 1e-3, "{light}, {mean}");
                let told = format!("{diameter_px:.2} px: {variance:.4}, not {theory:.4} px²");
                assert!((variance - theory).abs() < 0.002, "{told}");
            }
        }
    }

    #[test]
    fn an_ordinary_lens_images_the_far_picture_smaller() {
        let camera = small(false);
        let [_, moved, _] = moments(&camera, 1, Relief::Plane { share: 0.5 }, [57, 20]);
        let expected = (57.0 - 31.5) * (camera.optics.far_scale() - 1.0);
        assert!((moved - expected).abs() < 0.003, "{moved}, not {expected}");
        assert!(expected < -0.2);
    }

    #[test]
    fn the_far_picture_is_displaced_and_brighter_as_asked() {
        let camera = Camera { far_shift_px: [0.4, -0.7], ..small(true) };
        let [_, moved, _] = moments(&camera, 1, Relief::Plane { share: 0.9 }, [32, 20]);
        assert!((moved - 0.4).abs() < 0.003, "{moved}");
        let scene = Scene::new(Relief::Slant, Texture::Plain, 1);
        let rendered = Camera { far_gain: 0.5, ..camera }.photograph(&scene);
        assert!(rendered.far.iter().all(|&sample| sample.abs_diff(60 * 257) < 30));
    }

    #[test]
    fn a_plain_surface_is_plain_wherever_it_stands() {
        // A scene this small is steep: where the slope changes, discs of growing size don't quite make a whole.
        let reliefs =
            [(Relief::Slant, 0.1), (Relief::Cone, 4.0), (Relief::Staircase, 0.1), (Relief::Sphere, 0.6)];
        for (relief, most_levels) in reliefs {
            let rendered = small(false).photograph(&Scene::new(relief, Texture::Plain, 1));
            for (picture, samples) in [("near", &rendered.near), ("far", &rendered.far)] {
                let off = |sample: &u16| (f64::from(*sample) / 257.0 - 120.0).abs();
                let off_levels = samples.iter().map(off).fold(0.0, f64::max);
                assert!(off_levels < most_levels, "{relief:?}, {picture}: off by {off_levels} levels");
            }
        }
    }

    #[test]
    fn what_is_nearer_covers_what_is_behind_it() {
        let camera = Camera { width: 128, height: 128, ..small(true) };
        let middle = 64 * camera.width + 64;
        // The spot is on the farthest surface alone; the ball looks elsewhere.
        for (relief, seen) in [(Relief::Plane { share: 0.85 }, true), (Relief::Sphere, false)] {
            let picture = spot(&camera, 1, relief, [FINE * 64, FINE * 64]);
            let light = picture[middle];
            assert!(if seen { light > 5.0 } else { light.abs() < 0.2 }, "{relief:?}: {light}");
        }
    }

    #[test]
    fn rays_and_discs_make_the_same_pictures_where_nothing_is_hidden() {
        // A step between two planes at one depth is no step.
        let camera = Camera { width: 48, height: 40, ..small(false) };
        let pictures = [Relief::Plane { share: 0.9 }, Relief::Step { near: 0.9, far: 0.9 }]
            .map(|relief| camera.photograph(&Scene::new(relief, Texture::Gravel, 5)));
        for (picture, [discs, rays]) in [
            ("near", pictures.each_ref().map(|rendered| &rendered.near)),
            ("far", pictures.each_ref().map(|rendered| &rendered.far)),
        ] {
            // The right half: the left one shows another part of the texture.
            let right = (0..discs.len()).filter(|at| at % camera.width > 34);
            let squares = right.clone().map(|at| (f64::from(discs[at]) - f64::from(rays[at])).powi(2));
            let rms_levels = (squares.sum::<f64>() / right.count() as f64).sqrt() / 257.0;
            assert!(rms_levels < 0.5, "{picture}: {rms_levels} levels between them");
        }
    }

    #[test]
    fn a_map_of_depths_is_photographed_as_its_surfaces_are() {
        // The lone disc of a light point on a plane behind an edge: cut where the near half hides it.
        let camera = Camera { width: 64, height: 48, ..small(true) };
        let light = Image::from_fn(64, 48, |x, y| if (x, y) == (35, 24) { 200.0 } else { 100.0 });
        let whole = camera.photograph_map(&light, vec![camera.depth_mm(0.9); 64 * 48], 1);
        let depth_mm = (0..64 * 48).map(|at| camera.depth_mm(if at % 64 < 35 { 0.1 } else { 0.9 }));
        let hidden = camera.photograph_map(&light, depth_mm.collect(), 1);
        // Two pixels left of the point: within its disc, and before it.
        let level = |rendered: &Rendered| f64::from(rendered.near[24 * 64 + 33]) / 257.0;
        assert!(
            level(&whole) > 103.0 && (level(&hidden) - 100.0).abs() < 2.5,
            "{} {}",
            level(&whole),
            level(&hidden)
        );
        assert!(hidden.near_step(1.0)[24 * 64 + 35] && !whole.near_step(1.0).contains(&true));
    }

    #[test]
    fn one_seed_makes_one_scene() {
        let textures = [
            Texture::Noise,
            Texture::Gravel,
            Texture::Grass,
            Texture::Dots { period_px: 4.0 },
            Texture::Stripes { period_px: 10.0 },
        ];
        let camera = Camera { noise: 1.0, bits: 8, ..small(true) };
        for texture in textures {
            let scene = Scene::new(Relief::Slant, texture, 7);
            let (once, again) = (camera.photograph(&scene), camera.photograph(&scene));
            assert_eq!(once, again);
            let other = camera.photograph(&Scene { seed: 8, ..scene });
            assert_ne!(once.near, other.near, "{texture:?}");
            let [near_png, _] = once.pngs();
            let decoded = crate::imaging::decode(&near_png, &Default::default()).unwrap();
            assert_eq!(&decoded.luminance, once.pair().unwrap().near(), "{texture:?}");
        }
    }

    #[test]
    fn depth_and_its_steps_are_told() {
        let camera = small(true);
        let rendered = camera.photograph(&Scene::new(Relief::Staircase, Texture::Noise, 1));
        let share =
            |x: usize| (rendered.depth_mm[x] - camera.optics.near_focus_mm()) / camera.optics.range_mm();
        assert!((share(0) - 0.1).abs() < 1e-9 && (share(63) - 0.9).abs() < 1e-9);
        // The first two steps lie between the pixels 10 and 11, 20 and 21.
        let marks = rendered.near_step(2.0);
        let row: Vec<usize> = (0..30).filter(|&x| marks[10 * 64 + x]).collect();
        assert_eq!(row, [9, 10, 11, 12, 19, 20, 21, 22]);
        assert!(
            camera.photograph(&Scene::new(Relief::Cone, Texture::Noise, 1)).near_step(4.0).iter().all(|m| !m)
        );
    }
}
