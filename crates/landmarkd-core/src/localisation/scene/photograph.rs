//! Photographs of a scene: pinhole and lens distortion, several rays a pixel, noise, 8 bits.

use super::Scene;
use super::surface::Seen;
use crate::geometry::{Camera, DVec2, DVec3, MapPose};
use crate::imaging::{Frame, Image, Random};

/// Rays along either side of a pixel.
const RAYS: usize = 2;

/// Light and sensor of a photograph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposure {
    /// What red, green and blue are multiplied by: brightness, and the colour of the light.
    pub gain: [f64; 3],
    /// Standard deviation of each colour's noise, in gray levels of 255.
    pub noise: f64,
    /// Of the noise.
    pub seed: u64,
}

impl Default for Exposure {
    fn default() -> Exposure {
        Exposure { gain: [1.0; 3], noise: 0.0, seed: 0 }
    }
}

impl Scene {
    /// What a camera sees from a pose of its body. Where nothing is, it is black.
    pub fn photograph(&self, camera: &Camera, pose: &MapPose, exposure: &Exposure) -> Frame {
        let optical = pose.optical();
        let seen: Vec<Seen<'_>> =
            self.surfaces.iter().filter_map(|surface| surface.from(optical.translation_m)).collect();
        let [width, height] = [camera.width_px, camera.height_px].map(|side| side as usize);
        let corner_rays: Vec<Option<DVec2>> = (0..=height)
            .flat_map(|y| (0..=width).map(move |x| [x as f64 - 0.5, y as f64 - 0.5]))
            .map(|corner| camera.ray(corner))
            .collect();
        let side = 1.0 / (RAYS as f64 * (camera.fx * camera.fy).sqrt());
        let random = &mut Random::new(exposure.seed, 13);
        let mut planes = [(); 3].map(|()| Vec::with_capacity(width * height));
        let mut last = 0;
        for at in 0..width * height {
            let first = at / width * (width + 1) + at % width;
            let corners = [first, first + 1, first + width + 1, first + width + 2].map(|i| corner_rays[i]);
            let mut sum = [0.0; 3];
            if let [Some(a), Some(b), Some(c), Some(d)] = corners {
                for ray in 0..RAYS * RAYS {
                    let [u, v] = [ray % RAYS, ray / RAYS].map(|i| (i as f64 + 0.5) / RAYS as f64);
                    let (upper, lower) = (a.lerp(b, u), c.lerp(d, u));
                    let ray = optical.rotation * upper.lerp(lower, v).extend(1.0);
                    let colour = traced(&seen, ray, side, &mut last);
                    sum.iter_mut().zip(colour).for_each(|(sum, level)| *sum += level);
                }
            }
            let ([red, green], [blue, _]) = (random.normals(), random.normals());
            let noise = [red, green, blue];
            for (c, plane) in planes.iter_mut().enumerate() {
                let level = exposure.gain[c] * sum[c] / (RAYS * RAYS) as f64 + exposure.noise * noise[c];
                plane.push(level.round().clamp(0.0, 255.0) as f32);
            }
        }
        Frame::colour(planes.map(|pixels| Image::new(width, height, pixels)))
    }
}

/// The colour of the nearest surface along a ray. `last` is the one that the ray before it met: it is asked first.
fn traced(seen: &[Seen<'_>], ray: DVec3, side: f64, last: &mut usize) -> [f64; 3] {
    let first = seen.get(*last).and_then(|surface| surface.met(ray, 0.0));
    let mut nearest = first.map(|met| (*last, met));
    for (index, surface) in seen.iter().enumerate() {
        let nearer_than = nearest.map_or(0.0, |(_, met)| met.nearness);
        if let Some(met) = surface.met(ray, nearer_than) {
            nearest = Some((index, met));
        }
    }
    let Some((index, met)) = nearest else { return [0.0; 3] };
    *last = index;
    seen[index].colour(&met, side)
}
