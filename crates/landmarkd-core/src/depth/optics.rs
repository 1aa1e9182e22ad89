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

/// An optics as described by a user, not validated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpticsSpec {
    /// Focal length of the lens, in mm.
    pub focal_length_mm: f64,
    /// How wide the lens is.
    pub aperture: Aperture,
    /// Where the sensor of the near-focused picture stands.
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

/// A valid optics: all lengths positive, both sensors beyond the focal length.
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

/// Most pixels of blur that leave a picture.
const LARGEST_BLUR_PX: f64 = 120.0;
/// Least and largest aperture, in mm.
const APERTURES_MM: std::ops::RangeInclusive<f64> = 0.01..=10_000.0;
/// The farthest sensor from the lens, in mm.
const MOST_PLANE_MM: f64 = 1e7;
/// Candidates of β reach a little beyond ±1: an image may lie this part of the separation before the far-focused sensor.
const BEFORE_FAR_SENSOR: f64 = 0.25;
/// Least pixels of blur that can be measured.
const LEAST_BLUR_PX: f64 = 0.5;

impl NearSensor {
    /// Its field in the HTTP contract.
    fn field(self) -> &'static str {
        match self {
            NearSensor::PlaneMm(_) => "near_plane_mm",
            NearSensor::FocusMm(_) => "near_focus_mm",
        }
    }
}

impl OpticsSpec {
    /// The fields that are no numbers within their limits.
    fn range_faults(&self) -> Vec<Fault> {
        let (aperture_field, aperture) = match self.aperture {
            Aperture::DiameterMm(mm) => ("aperture_mm", mm),
            Aperture::FNumber(number) => ("f_number", number),
        };
        let (NearSensor::PlaneMm(sensor_mm) | NearSensor::FocusMm(sensor_mm)) = self.near_sensor;
        let lengths = [
            ("focal_length_mm", self.focal_length_mm, 0.1..=10_000.0),
            (aperture_field, aperture, APERTURES_MM),
            (self.near_sensor.field(), sensor_mm, 0.1..=MOST_PLANE_MM),
            ("plane_separation_mm", self.plane_separation_mm, 1e-4..=1000.0),
            ("pixel_pitch_um", self.pixel_pitch_um, 0.1..=1000.0),
        ];
        let mut faults = Vec::new();
        for (field, value, range) in lengths {
            if !range.contains(&value) {
                let (least, most) = (range.start(), range.end());
                let message = format!("must be a number from {least} to {most}, not {value}");
                faults.push(Fault { field, message });
            }
        }
        if self.principal_point_px.is_some_and(|point| point.iter().any(|v| !v.is_finite() || v.abs() > 1e5))
        {
            let message = "must be two numbers within 100000 of 0".into();
            faults.push(Fault { field: "principal_point_px", message });
        }
        faults
    }
}

/// One fault of several fields together.
fn faults_of(fields: &[&'static str], message: &str) -> Vec<Fault> {
    fields.iter().map(|&field| Fault { field, message: message.into() }).collect()
}

impl Optics {
    /// The optics of a description.
    ///
    /// # Errors
    /// Every faulty field, by its name in the HTTP contract.
    pub fn new(spec: &OpticsSpec) -> Result<Optics, Vec<Fault>> {
        let faults = spec.range_faults();
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
                return Err(faults_of(&["near_focus_mm"], &message));
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
        optics.check(spec.near_sensor.field())?;
        Ok(optics)
    }

    /// Whether the lengths make an optics together. `sensor` is the field that places the near-focused sensor.
    fn check(&self, sensor: &'static str) -> Result<(), Vec<Fault>> {
        // Derived lengths must be valid descriptions themselves, as calibrations keep them.
        if !APERTURES_MM.contains(&self.aperture_mm) {
            let message =
                format!("makes an aperture of {} mm; {APERTURES_MM:?} mm are taken", self.aperture_mm);
            return Err(faults_of(&["f_number"], &message));
        }
        if self.near_plane_mm > MOST_PLANE_MM {
            let message = format!(
                "puts the sensor {} mm behind the lens: a focus farther from the focal length is needed",
                self.near_plane_mm
            );
            return Err(faults_of(&[sensor], &message));
        }
        let least_mm = BEFORE_FAR_SENSOR * self.plane_separation_mm;
        if self.far_plane_mm() <= self.focal_length_mm || self.far_plane_mm() <= least_mm {
            let message = format!(
                "the far-focused sensor would stand {:.4} mm behind the lens, within the focal length of {} mm, and be \
                 focused on nothing: a sensor farther away or a smaller separation is needed",
                self.far_plane_mm(),
                self.focal_length_mm
            );
            return Err(faults_of(&[sensor, "plane_separation_mm"], &message));
        }
        if !(self.range_mm() > 0.0 && self.far_focus_mm().is_finite()) {
            let message = "is too small beside the other lengths: both pictures are focused at one distance";
            return Err(faults_of(&["plane_separation_mm"], message));
        }
        let blur = self.largest_blur_px();
        if !(LEAST_BLUR_PX..=LARGEST_BLUR_PX).contains(&blur) {
            let message = format!(
                "the larger blur between the two focus distances is {blur:.2} px; {LEAST_BLUR_PX} to {LARGEST_BLUR_PX} px \
                 can be measured, 4 to 7 px are best: aperture × separation / (focal length × pitch) says it"
            );
            return Err(faults_of(&["plane_separation_mm", "pixel_pitch_um"], &message));
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
