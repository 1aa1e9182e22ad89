//! The optics of a focal pair (B(1)–B(3)): one lens, two sensors.
//!
//! The lens law is 1/f = 1/u + 1/v: u the distance of a point, v that of its sharp image. The near-focused picture's
//! sensor stands at `near_plane`, the far-focused one's nearer to the lens by the separation b.

use super::Fault;

/// How wide the lens is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aperture {
    /// Diameter in mm.
    DiameterMm(f64),
    /// Focal length over diameter.
    FNumber(f64),
}

/// Where the sensor of the near-focused picture stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NearSensor {
    /// Its distance from the lens, in mm.
    PlaneMm(f64),
    /// The distance in the scene that it is focused at, in mm.
    FocusMm(f64),
}

/// An optics as described by a user: anything may be wrong with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpticsSpec {
    pub focal_length_mm: f64,
    pub aperture: Aperture,
    pub near_sensor: NearSensor,
    /// How much nearer to the lens the far-focused picture's sensor stands, in mm: b.
    pub plane_separation_mm: f64,
    /// The side of a pixel, in µm.
    pub pixel_pitch_um: f64,
    /// Whether a stop in the front focal plane keeps both pictures at one scale.
    pub telecentric: bool,
    /// Where the optical axis meets the picture; the middle if `None`.
    pub principal_point_px: Option<[f64; 2]>,
}

/// An optics that can be: all lengths positive, both sensors beyond the focal length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Optics {
    pub(super) focal_length_mm: f64,
    pub(super) aperture_mm: f64,
    pub(super) near_plane_mm: f64,
    pub(super) plane_separation_mm: f64,
    pub(super) pixel_pitch_um: f64,
    pub(super) telecentric: bool,
    pub(super) principal_point_px: Option<[f64; 2]>,
}

/// Blur of more pixels than this is no picture.
const LARGEST_BLUR_PX: f64 = 120.0;
/// Apertures that are taken, in mm.
const LENGTHS_MM: std::ops::RangeInclusive<f64> = 0.01..=10_000.0;
/// The farthest sensor from the lens, in mm.
const MOST_PLANE_MM: f64 = 1e7;
/// β is looked at a little beyond ±1: by this part of the separation an image may lie before the far-focused sensor.
const FARTHEST_LABEL: f64 = 0.25;
/// Blur of fewer pixels than this tells nothing.
const LEAST_BLUR_PX: f64 = 0.5;

impl Optics {
    /// The optics that the description makes.
    ///
    /// # Errors
    /// Every field that can't be as it is; pointers are the names of the HTTP contract.
    pub fn new(spec: &OpticsSpec) -> Result<Optics, Vec<Fault>> {
        let (aperture_name, aperture) = match spec.aperture {
            Aperture::DiameterMm(mm) => ("aperture_mm", mm),
            Aperture::FNumber(number) => ("f_number", number),
        };
        let (sensor_name, sensor) = match spec.near_sensor {
            NearSensor::PlaneMm(mm) => ("near_plane_mm", mm),
            NearSensor::FocusMm(mm) => ("near_focus_mm", mm),
        };
        let mut faults = Vec::new();
        let mut fault = |field, message| faults.push(Fault { field, message });
        let lengths = [
            ("focal_length_mm", spec.focal_length_mm, 0.1, 10_000.0),
            (aperture_name, aperture, *LENGTHS_MM.start(), *LENGTHS_MM.end()),
            (sensor_name, sensor, 0.1, MOST_PLANE_MM),
            ("plane_separation_mm", spec.plane_separation_mm, 1e-4, 1000.0),
            ("pixel_pitch_um", spec.pixel_pitch_um, 0.1, 1000.0),
        ];
        for (field, value, least, most) in lengths {
            if !(least..=most).contains(&value) {
                fault(field, format!("must be a number from {least} to {most}, not {value}"));
            }
        }
        if spec.principal_point_px.is_some_and(|point| point.iter().any(|v| !v.is_finite() || v.abs() > 1e5))
        {
            fault("principal_point_px", "must be two numbers within 100000 of 0".into());
        }
        if !faults.is_empty() {
            return Err(faults);
        }
        let focal_length_mm = spec.focal_length_mm;
        let near_plane_mm = match spec.near_sensor {
            NearSensor::PlaneMm(mm) => mm,
            NearSensor::FocusMm(mm) if mm > focal_length_mm => focal_length_mm * mm / (mm - focal_length_mm), // B(1)
            NearSensor::FocusMm(mm) => {
                let message = format!(
                    "must exceed the focal length of {focal_length_mm} mm, not be {mm}: a lens focuses nothing nearer"
                );
                return Err(vec![Fault { field: sensor_name, message }]);
            }
        };
        let optics = Optics {
            focal_length_mm,
            aperture_mm: match spec.aperture {
                Aperture::DiameterMm(mm) => mm,
                Aperture::FNumber(number) => focal_length_mm / number,
            },
            near_plane_mm,
            plane_separation_mm: spec.plane_separation_mm,
            pixel_pitch_um: spec.pixel_pitch_um,
            telecentric: spec.telecentric,
            principal_point_px: spec.principal_point_px,
        };
        optics.possible(sensor_name)?;
        Ok(optics)
    }

    fn possible(&self, sensor_name: &'static str) -> Result<(), Vec<Fault>> {
        // What follows from the description must be fit to be described itself: it is what is kept.
        if !LENGTHS_MM.contains(&self.aperture_mm) {
            let message =
                format!("makes an aperture of {} mm; {LENGTHS_MM:?} mm are taken", self.aperture_mm);
            return Err(vec![Fault { field: "f_number", message }]);
        }
        if self.near_plane_mm > MOST_PLANE_MM {
            let message = format!(
                "puts the sensor {} mm behind the lens: a focus farther from the focal length is needed",
                self.near_plane_mm
            );
            return Err(vec![Fault { field: sensor_name, message }]);
        }
        let within = FARTHEST_LABEL * self.plane_separation_mm;
        if self.far_plane_mm() <= self.focal_length_mm || self.far_plane_mm() <= within {
            let message = format!(
                "the far-focused sensor would stand {:.4} mm behind the lens, within the focal length of {} mm, and be \
                 focused on nothing: a sensor farther away or a smaller separation is needed",
                self.far_plane_mm(),
                self.focal_length_mm
            );
            let faults = [sensor_name, "plane_separation_mm"];
            return Err(faults.map(|field| Fault { field, message: message.clone() }).to_vec());
        }
        if !(self.range_mm() > 0.0 && self.far_focus_mm().is_finite()) {
            let message =
                "is too small beside the other lengths: both pictures are focused at one distance".into();
            return Err(vec![Fault { field: "plane_separation_mm", message }]);
        }
        let blur = self.largest_blur_px();
        if !(LEAST_BLUR_PX..=LARGEST_BLUR_PX).contains(&blur) {
            let message = format!(
                "the larger blur between the two focus distances is {blur:.2} px; {LEAST_BLUR_PX} to {LARGEST_BLUR_PX} px \
                 can be measured, 4 to 7 px are best: aperture × separation / (focal length × pitch) says it"
            );
            let faults = ["plane_separation_mm", "pixel_pitch_um"];
            return Err(faults.map(|field| Fault { field, message: message.clone() }).to_vec());
        }
        Ok(())
    }

    /// The same optics as a description.
    pub fn spec(&self) -> OpticsSpec {
        OpticsSpec {
            focal_length_mm: self.focal_length_mm,
            aperture: Aperture::DiameterMm(self.aperture_mm),
            near_sensor: NearSensor::PlaneMm(self.near_plane_mm),
            plane_separation_mm: self.plane_separation_mm,
            pixel_pitch_um: self.pixel_pitch_um,
            telecentric: self.telecentric,
            principal_point_px: self.principal_point_px,
        }
    }

    /// Distance of the far-focused picture's sensor from the lens, in mm.
    pub fn far_plane_mm(&self) -> f64 {
        self.near_plane_mm - self.plane_separation_mm
    }

    /// The distance that the near-focused picture is focused at, in mm: β = 1.
    pub fn near_focus_mm(&self) -> f64 {
        self.depth_mm(1.0)
    }

    /// The distance that the far-focused picture is focused at, in mm: β = −1.
    pub fn far_focus_mm(&self) -> f64 {
        self.depth_mm(-1.0)
    }

    /// The working range: from the near to the far focus distance, in mm.
    pub fn range_mm(&self) -> f64 {
        self.far_focus_mm() - self.near_focus_mm()
    }

    /// Size of the far-focused image over that of the near-focused one: 1 with a telecentric stop.
    pub fn far_scale(&self) -> f64 {
        if self.telecentric { 1.0 } else { self.far_plane_mm() / self.near_plane_mm }
    }

    /// Distance from the lens at which a point of this β is sharp, in mm.
    fn image_distance_mm(&self, beta: f64) -> f64 {
        self.far_plane_mm() + 0.5 * self.plane_separation_mm * (1.0 + beta)
    }

    /// Distance of a point of this β, in mm; infinite where the lens forms no image.
    pub fn depth_mm(&self, beta: f64) -> f64 {
        let (f, v) = (self.focal_length_mm, self.image_distance_mm(beta));
        if v > f { f * v / (v - f) } else { f64::INFINITY } // B(1)
    }

    /// β of a point at this distance, in mm, beyond the focal length.
    pub fn beta(&self, depth_mm: f64) -> f64 {
        let (f, u) = (self.focal_length_mm, depth_mm);
        2.0 * (f * u / (u - f) - self.far_plane_mm()) / self.plane_separation_mm - 1.0 // B(1)
    }

    /// Signed diameters of the blur circle on the near- and on the far-focused sensor, in their pixels; positive where
    /// the sensor stands behind the sharp image.
    pub fn blur_diameters_px(&self, beta: f64) -> [f64; 2] {
        let v = self.image_distance_mm(beta);
        let over = if self.telecentric { self.focal_length_mm } else { v };
        let diameter =
            |sensor_mm: f64| self.aperture_mm * (sensor_mm - v) / over / (self.pixel_pitch_um / 1000.0);
        [diameter(self.near_plane_mm), diameter(self.far_plane_mm())] // B(2), B(3), with their signs
    }

    /// The same once the far-focused picture has been enlarged to the near one's scale: its blur grows with it.
    pub fn registered_blur_px(&self, beta: f64) -> [f64; 2] {
        let [near, far] = self.blur_diameters_px(beta);
        [near, far / self.far_scale()]
    }

    /// The largest blur within the working range, in pixels.
    pub fn largest_blur_px(&self) -> f64 {
        self.blur_diameters_px(-1.0)[0].abs().max(self.blur_diameters_px(1.0)[1].abs())
    }

    /// Where the optical axis meets a picture of this size.
    pub fn principal_point(&self, width: usize, height: usize) -> [f64; 2] {
        self.principal_point_px.unwrap_or([(width as f64 - 1.0) / 2.0, (height as f64 - 1.0) / 2.0])
    }

    /// The point of the scene, in mm, that the near-focused picture shows in pixel `[x, y]` at this depth: x right,
    /// y down, z along the optical axis from the lens. `centre` is where the axis meets the picture.
    pub fn point_mm(&self, [x, y]: [f64; 2], centre: [f64; 2], depth_mm: f64) -> [f64; 3] {
        let pitch_mm = self.pixel_pitch_um / 1000.0;
        // The chief ray runs through the middle of the stop: the lens, or the front focal point.
        let magnified = match self.telecentric {
            false => depth_mm / self.near_plane_mm,
            true => (depth_mm - self.focal_length_mm) / self.focal_length_mm,
        };
        [(x - centre[0]) * pitch_mm * magnified, (y - centre[1]) * pitch_mm * magnified, depth_mm]
    }

    /// The same with pixels `factor` times as large: a picture that was shrunk.
    pub(super) fn shrunk(&self, factor: f64) -> Optics {
        let principal_point_px = self.principal_point_px.map(|point| point.map(|v| v / factor));
        Optics { pixel_pitch_um: self.pixel_pitch_um * factor, principal_point_px, ..*self }
    }
}
