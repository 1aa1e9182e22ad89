//! A pinhole camera with the lens distortion of Brown and Conrady, as OpenCV and ROS (`plumb_bob`) write it.

use glam::{DVec2, DVec3};

/// Rounds of the inversion of the distortion.
const MOST_ROUNDS: usize = 60;
/// A ray is found when its pixel is met to within this, in px.
const CLOSE_PX: f64 = 1e-6;

/// Intrinsics of a camera. Pixels count from the centre of the top-left one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Focal length over the width of a pixel.
    pub fx: f64,
    /// Focal length over the height of a pixel.
    pub fy: f64,
    /// Column of the principal point.
    pub cx: f64,
    /// Row of the principal point.
    pub cy: f64,
    /// k₁, k₂, p₁, p₂, k₃: radial, tangential, radial.
    pub distortion: [f64; 5],
    /// Width of the pictures that these numbers are for.
    pub width_px: u32,
    /// Height of the pictures that these numbers are for.
    pub height_px: u32,
}

/// What is wrong with the intrinsics of a camera.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{field} {fault}")]
pub struct CameraFault {
    /// The field at fault.
    pub field: &'static str,
    /// What must hold of it.
    pub fault: String,
}

impl Camera {
    /// Everything that is wrong with it.
    pub fn faults(&self) -> Vec<CameraFault> {
        let mut faults = Vec::new();
        let mut check = |field, holds: bool, fault: &str| {
            if !holds {
                faults.push(CameraFault { field, fault: fault.to_owned() });
            }
        };
        let (width, height) = (f64::from(self.width_px), f64::from(self.height_px));
        check("width_px", (1..=65_536).contains(&self.width_px), "must be between 1 and 65536");
        check("height_px", (1..=65_536).contains(&self.height_px), "must be between 1 and 65536");
        let focal = |length: f64| length.is_finite() && length > 0.05 * width && length < 100.0 * width;
        check("fx", focal(self.fx), "must be a focal length in px: 0.05 to 100 times width_px");
        check("fy", focal(self.fy), "must be a focal length in px: 0.05 to 100 times width_px");
        let inside = |at: f64, extent: f64| at.is_finite() && at > -extent && at < 2.0 * extent;
        check("cx", inside(self.cx, width), "must be the column of the principal point, in px");
        check("cy", inside(self.cy, height), "must be the row of the principal point, in px");
        for (field, k) in ["k1", "k2", "p1", "p2", "k3"].into_iter().zip(self.distortion) {
            check(field, k.is_finite() && k.abs() < 100.0, "must be a coefficient of lens distortion");
        }
        if faults.is_empty() {
            let corners = [[0.0, 0.0], [width - 1.0, 0.0], [width - 1.0, height - 1.0], [0.0, height - 1.0]];
            if corners.iter().any(|corner| self.ray(*corner).is_none()) {
                faults.push(CameraFault {
                    field: "k1",
                    fault: "and the other coefficients fold the corners of the picture back onto it: calibrate again, with \
                            points near the corners, or send rectified pictures"
                        .into(),
                });
            }
        }
        faults
    }

    /// The same camera for pictures of another size, if they show the same: the ratio of width and height agrees to within
    /// a pixel.
    pub fn resized(&self, width_px: u32, height_px: u32) -> Option<Camera> {
        let scale = f64::from(width_px) / f64::from(self.width_px);
        let same = (f64::from(self.height_px) * scale - f64::from(height_px)).abs() <= 1.0_f64.max(scale);
        // A pixel u of one picture stands at (u + ½)·k − ½ of the other.
        let moved = |at: f64| (at + 0.5) * scale - 0.5;
        same.then(|| Camera {
            fx: self.fx * scale,
            fy: self.fy * scale,
            cx: moved(self.cx),
            cy: moved(self.cy),
            width_px,
            height_px,
            ..*self
        })
    }

    /// The pixel of a point before the camera, in its optical frame; none for a point behind it.
    pub fn project(&self, point: DVec3) -> Option<[f64; 2]> {
        (point.z > 0.0).then(|| self.pixel(DVec2::new(point.x / point.z, point.y / point.z)))
    }

    /// The pixel of a ray (x/z, y/z).
    pub fn pixel(&self, ray: DVec2) -> [f64; 2] {
        let bent = self.distorted(ray);
        [self.fx * bent.x + self.cx, self.fy * bent.y + self.cy]
    }

    /// The ray (x/z, y/z) of a pixel; none where the distortion can't be undone.
    pub fn ray(&self, [u, v]: [f64; 2]) -> Option<DVec2> {
        let goal = DVec2::new((u - self.cx) / self.fx, (v - self.cy) / self.fy);
        if self.distortion == [0.0; 5] {
            return Some(goal);
        }
        // Newton; the step is halved where it leads away.
        let mut ray = goal;
        let mut off = self.distorted(ray) - goal;
        for _ in 0..MOST_ROUNDS {
            if off.length() * self.fx.max(self.fy) < CLOSE_PX {
                break;
            }
            let [[a, b], [c, d]] = self.derivative(ray);
            let determinant = a * d - b * c;
            if determinant <= 0.0 {
                return None;
            }
            let mut step = DVec2::new(d * off.x - b * off.y, a * off.y - c * off.x) / determinant;
            let next = loop {
                let next = ray - step;
                if (self.distorted(next) - goal).length() < off.length() || step.length() < 1e-12 {
                    break next;
                }
                step *= 0.5;
            };
            ray = next;
            off = self.distorted(ray) - goal;
        }
        let found = off.length() * self.fx.max(self.fy) < 1e-3 && self.is_monotone(ray.length());
        found.then_some(ray)
    }

    /// Where the lens bends a ray to.
    fn distorted(&self, ray: DVec2) -> DVec2 {
        let [k1, k2, p1, p2, k3] = self.distortion;
        let (x, y) = (ray.x, ray.y);
        let r2 = ray.length_squared();
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        DVec2::new(
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        )
    }

    /// By how much a ray moves on the plane of unit depth behind the lens when it moves before it, row-major.
    pub(crate) fn derivative(&self, ray: DVec2) -> [[f64; 2]; 2] {
        let [k1, k2, p1, p2, k3] = self.distortion;
        let (x, y) = (ray.x, ray.y);
        let r2 = ray.length_squared();
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        let slope = 2.0 * (k1 + r2 * (2.0 * k2 + 3.0 * r2 * k3));
        let across = slope * x * y + 2.0 * p1 * x + 2.0 * p2 * y;
        [
            [radial + slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x, across],
            [across, radial + slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x],
        ]
    }

    /// Whether the radial distortion grows all the way to this distance from the axis.
    fn is_monotone(&self, radius: f64) -> bool {
        let [k1, k2, _, _, k3] = self.distortion;
        (1..=16).all(|step| {
            let r2 = (radius * f64::from(step) / 16.0).powi(2);
            1.0 + r2 * (3.0 * k1 + r2 * (5.0 * k2 + r2 * 7.0 * k3)) > 0.0
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wide camera with the distortion of a cheap lens.
    const WIDE: Camera = Camera {
        fx: 380.0,
        fy: 382.0,
        cx: 322.5,
        cy: 236.0,
        distortion: [-0.29, 0.09, 4e-4, -7e-4, -0.012],
        width_px: 640,
        height_px: 480,
    };

    #[test]
    fn a_pixel_and_its_ray_are_one() {
        assert!(WIDE.faults().is_empty(), "{:?}", WIDE.faults());
        for pixel in [[0.0, 0.0], [639.0, 0.0], [322.5, 236.0], [639.0, 479.0], [100.0, 400.0]] {
            let ray = WIDE.ray(pixel).unwrap();
            let back = WIDE.project(DVec3::new(2.0 * ray.x, 2.0 * ray.y, 2.0)).unwrap();
            assert!((back[0] - pixel[0]).hypot(back[1] - pixel[1]) < 1e-4, "{pixel:?} {back:?}");
        }
        assert_eq!(WIDE.project(DVec3::new(0.0, 0.0, -1.0)), None);
    }

    #[test]
    fn a_smaller_picture_has_the_same_rays() {
        let half = WIDE.resized(320, 240).unwrap();
        let ray = DVec2::new(0.31, -0.22);
        let (large, small) = (WIDE.pixel(ray), half.pixel(ray));
        let halved = large.map(|at| (at + 0.5) / 2.0 - 0.5);
        assert!((small[0] - halved[0]).hypot(small[1] - halved[1]) < 1e-9);
        assert_eq!(WIDE.resized(640, 360), None, "another part of the view");
    }

    #[test]
    fn what_is_no_camera_is_refused_field_by_field() {
        let none = Camera { fx: 0.0, cy: f64::NAN, width_px: 0, ..WIDE };
        let fields: Vec<_> = none.faults().iter().map(|fault| fault.field).collect();
        assert_eq!(fields, ["width_px", "fx", "fy", "cx", "cy"]);
        let folded = Camera { distortion: [-2.0, 0.0, 0.0, 0.0, 0.0], ..WIDE };
        assert_eq!(folded.faults()[0].field, "k1");
    }
}
