//! The optics of two pictures that differ in blur (B(1)–B(3)): one lens before two sensors, or one sensor behind two
//! apertures.
//!
//! The lens law is 1/f = 1/u + 1/v: u the distance of a point, v that of its sharp image. Of a *focal pair* the near-focused
//! picture's sensor stands farther from the lens than the far-focused one's, by the separation b, and the working range is
//! what is sharp between the two. Of an *aperture pair* (Subbarao) both pictures have one sensor, and blur by the ratio of
//! the apertures: equally on both sides of the focus. So its working range lies on one side, from the end that is asked for
//! to where too little blur is left to measure by.
//!
//! β runs over the working range of either: 1 at its near end, −1 at its far one, and linear in v. The *first* picture is
//! that whose blur falls with β against the other's: near-focused; or wide open beyond the focus, stopped down before it.

use super::Fault;

/// How wide the lens is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aperture {
    /// Diameter in mm.
    DiameterMm(f64),
    /// Focal length over diameter.
    FNumber(f64),
}

/// Where a sensor stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sensor {
    /// Its distance from the lens, in mm.
    PlaneMm(f64),
    /// The distance in the scene that it is focused at, in mm.
    FocusMm(f64),
}

/// What the two pictures differ by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pair {
    /// Where they are focused.
    Focal {
        /// How wide the lens is.
        aperture: Aperture,
        /// Where the sensor of the near-focused picture stands.
        near_sensor: Sensor,
        /// How much nearer to the lens the far-focused picture's sensor stands, in mm: b.
        plane_separation_mm: f64,
    },
    /// How wide the lens is open.
    Aperture {
        /// Two apertures, in either order.
        apertures: [Aperture; 2],
        /// Where the sensor of both stands.
        sensor: Sensor,
        /// The distance, in mm, of the working range's end that is away from the focus: beyond it or before it.
        range_end_mm: f64,
    },
}

/// An optics as described by a user, not validated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpticsSpec {
    /// Focal length of the lens, in mm.
    pub focal_length_mm: f64,
    /// What the two pictures differ by.
    pub pair: Pair,
    /// The side of a pixel, in µm.
    pub pixel_pitch_um: f64,
    /// Whether a stop in the front focal plane keeps pictures of all focus settings at one scale.
    pub telecentric: bool,
    /// Where the optical axis meets the picture; the middle if `None`.
    pub principal_point_px: Option<[f64; 2]>,
}

/// A valid optics: all lengths positive, both sensors beyond the focal length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Optics {
    pub(super) focal_length_mm: f64,
    /// Diameters of the first and the second picture's aperture.
    pub(super) apertures_mm: [f64; 2],
    /// Distances of their sensors from the lens.
    pub(super) sensors_mm: [f64; 2],
    /// Of an aperture pair: the end of its working range that is away from the focus.
    pub(super) range_end_mm: Option<f64>,
    /// Where points at the far end of the working range are sharp: β = −1.
    pub(super) far_image_mm: f64,
    /// From there to where points at its near end are sharp.
    pub(super) image_span_mm: f64,
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
/// Candidates of β reach a little beyond ±1: an image may lie this part of the span beyond its ends.
const BEYOND_ENDS: f64 = 0.25;
/// The working range of an aperture pair ends where this part of its largest blur is left: nearer to the focus blur changes
/// too little with distance, and no candidate of β lies beyond the focus.
const LEAST_BLUR_SHARE: f64 = 0.2;
/// The narrower aperture over the wider one, at most: half a stop.
const MOST_APERTURE_RATIO: f64 = 0.85;
/// Least pixels of blur that can be measured.
const LEAST_BLUR_PX: f64 = 0.5;

/// The field of the HTTP contract that a length comes from, and the length.
type Length = (&'static str, f64, std::ops::RangeInclusive<f64>);

impl Aperture {
    /// Its diameter in mm.
    pub fn diameter_mm(self, focal_length_mm: f64) -> f64 {
        match self {
            Aperture::DiameterMm(mm) => mm,
            Aperture::FNumber(number) => focal_length_mm / number,
        }
    }

    /// As it is described, under one of two fields.
    fn length(self, [diameter, number]: [&'static str; 2]) -> Length {
        match self {
            Aperture::DiameterMm(mm) => (diameter, mm, APERTURES_MM),
            Aperture::FNumber(value) => (number, value, APERTURES_MM),
        }
    }
}

impl Sensor {
    /// Its distance from the lens in mm; `None` if a lens focuses nothing as near as it says.
    pub fn plane_mm(self, focal_length_mm: f64) -> Option<f64> {
        match self {
            Sensor::PlaneMm(mm) => Some(mm),
            Sensor::FocusMm(mm) => {
                (mm > focal_length_mm).then(|| focal_length_mm * mm / (mm - focal_length_mm))
            } // B(1)
        }
    }

    /// As it is described, under one of two fields.
    fn length(self, [plane, focus]: [&'static str; 2]) -> Length {
        match self {
            Sensor::PlaneMm(mm) => (plane, mm, 0.1..=MOST_PLANE_MM),
            Sensor::FocusMm(mm) => (focus, mm, 0.1..=MOST_PLANE_MM),
        }
    }
}

impl Pair {
    /// The fields that describe its apertures: one each.
    fn aperture_fields(&self) -> Vec<Length> {
        match self {
            Pair::Focal { aperture, .. } => vec![aperture.length(["aperture_mm", "f_number"])],
            Pair::Aperture { apertures, .. } => {
                apertures.map(|aperture| aperture.length(["apertures_mm", "f_numbers"])).to_vec()
            }
        }
    }

    /// The field that places the sensor of the first picture.
    fn sensor_field(&self) -> Length {
        match self {
            Pair::Focal { near_sensor, .. } => near_sensor.length(["near_plane_mm", "near_focus_mm"]),
            Pair::Aperture { sensor, .. } => sensor.length(["plane_mm", "focus_mm"]),
        }
    }

    /// The field that says how far the working range reaches.
    fn range_field(&self) -> Length {
        match self {
            Pair::Focal { plane_separation_mm, .. } => {
                ("plane_separation_mm", *plane_separation_mm, 1e-4..=1000.0)
            }
            Pair::Aperture { range_end_mm, .. } => ("range_end_mm", *range_end_mm, 0.1..=MOST_PLANE_MM),
        }
    }

    fn sensor(&self) -> Sensor {
        let (Pair::Focal { near_sensor: sensor, .. } | Pair::Aperture { sensor, .. }) = self;
        *sensor
    }
}

impl OpticsSpec {
    /// The fields that are no numbers within their limits.
    fn range_faults(&self) -> Vec<Fault> {
        let mut lengths = vec![("focal_length_mm", self.focal_length_mm, 0.1..=10_000.0)];
        lengths.extend(self.pair.aperture_fields());
        lengths.extend([self.pair.sensor_field(), self.pair.range_field()]);
        lengths.push(("pixel_pitch_um", self.pixel_pitch_um, 0.1..=1000.0));
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
        let f = spec.focal_length_mm;
        let (sensor_field, sensor, _) = spec.pair.sensor_field();
        let Some(sensor_mm) = spec.pair.sensor().plane_mm(f) else {
            let message = format!(
                "must exceed the focal length of {f} mm, not be {sensor}: a lens focuses nothing nearer"
            );
            return Err(faults_of(&[sensor_field], &message));
        };
        if sensor_mm > MOST_PLANE_MM {
            let message = format!(
                "puts the sensor {sensor_mm} mm behind the lens: a focus farther from the focal length is needed"
            );
            return Err(faults_of(&[sensor_field], &message));
        }
        let optics = Optics {
            focal_length_mm: f,
            apertures_mm: [0.0; 2],
            sensors_mm: [sensor_mm; 2],
            range_end_mm: None,
            far_image_mm: 0.0,
            image_span_mm: 0.0,
            pixel_pitch_um: spec.pixel_pitch_um,
            telecentric: spec.telecentric,
            principal_point_px: spec.principal_point_px,
        };
        let optics = match spec.pair {
            Pair::Focal { aperture, plane_separation_mm, .. } => {
                let far_sensor_mm = sensor_mm - plane_separation_mm;
                Optics {
                    apertures_mm: [aperture.diameter_mm(f); 2],
                    sensors_mm: [sensor_mm, far_sensor_mm],
                    far_image_mm: far_sensor_mm,
                    image_span_mm: plane_separation_mm,
                    ..optics
                }
            }
            Pair::Aperture { apertures, range_end_mm, .. } => {
                optics.with_apertures(apertures.map(|aperture| aperture.diameter_mm(f)), range_end_mm)?
            }
        };
        optics.check(&spec.pair)?;
        Ok(optics)
    }

    /// The same with two apertures before its sensor, and a range that ends at this distance.
    fn with_apertures(self, apertures_mm: [f64; 2], range_end_mm: f64) -> Result<Optics, Vec<Fault>> {
        let (f, sensor_mm) = (self.focal_length_mm, self.sensors_mm[0]);
        if range_end_mm <= f {
            let message = format!("must exceed the focal length of {f} mm, not be {range_end_mm}");
            return Err(faults_of(&["range_end_mm"], &message));
        }
        let [narrow, wide] = [apertures_mm[0].min(apertures_mm[1]), apertures_mm[0].max(apertures_mm[1])];
        let outer_mm = f * range_end_mm / (range_end_mm - f); // B(1)
        let inner_mm = sensor_mm + LEAST_BLUR_SHARE * (outer_mm - sensor_mm);
        let beyond = outer_mm < sensor_mm;
        Ok(Optics {
            apertures_mm: if beyond { [wide, narrow] } else { [narrow, wide] },
            range_end_mm: Some(range_end_mm),
            far_image_mm: outer_mm.min(inner_mm),
            image_span_mm: (outer_mm - inner_mm).abs(),
            ..self
        })
    }

    /// Whether the lengths make an optics together.
    fn check(&self, pair: &Pair) -> Result<(), Vec<Fault>> {
        let ((sensor, ..), (range, ..)) = (pair.sensor_field(), pair.range_field());
        // Derived lengths must be valid descriptions themselves, as calibrations keep them.
        if let Some(mm) = self.apertures_mm.iter().find(|mm| !APERTURES_MM.contains(mm)) {
            let message = format!("makes an aperture of {mm} mm; {APERTURES_MM:?} mm are taken");
            return Err(faults_of(&[pair.aperture_fields()[0].0], &message));
        }
        let nearest_mm = self.sensors_mm[1].min(self.far_image_mm);
        if nearest_mm <= self.focal_length_mm || nearest_mm <= BEYOND_ENDS * self.image_span_mm {
            let message = format!(
                "the far-focused sensor would stand {nearest_mm:.4} mm behind the lens, within the focal length of {} mm, \
                 and be focused on nothing: a sensor farther away or a smaller separation is needed",
                self.focal_length_mm
            );
            return Err(faults_of(&[sensor, range], &message));
        }
        if !(self.range_mm() > 0.0 && self.far_focus_mm().is_finite()) {
            let message = match pair {
                Pair::Focal { .. } => {
                    "is too small beside the other lengths: both pictures are focused at one distance"
                }
                Pair::Aperture { .. } => {
                    "is the focus distance itself: blur is alike on both sides of it, so say by the end of the range which \
                     side is measured"
                }
            };
            return Err(faults_of(&[range], message));
        }
        let [first, second] = self.apertures_mm;
        if self.range_end_mm.is_some() && first.min(second) > MOST_APERTURE_RATIO * first.max(second) {
            let message = format!(
                "differ too little, {first:.3} and {second:.3} mm: half a stop is the least, two or three stops are best"
            );
            return Err(faults_of(&[pair.aperture_fields()[0].0], &message));
        }
        let blur = self.largest_blur_px();
        if !(LEAST_BLUR_PX..=LARGEST_BLUR_PX).contains(&blur) {
            let message = match pair {
                Pair::Focal { .. } => format!(
                    "the larger blur between the two focus distances is {blur:.2} px; {LEAST_BLUR_PX} to {LARGEST_BLUR_PX} px \
                     can be measured, 4 to 7 px are best: aperture × separation / (focal length × pitch) says it"
                ),
                Pair::Aperture { .. } => format!(
                    "the wide-open picture is blurred by {blur:.2} px at the end of the range; {LEAST_BLUR_PX} to \
                     {LARGEST_BLUR_PX} px can be measured, 4 to 7 px are best"
                ),
            };
            return Err(faults_of(&[range, "pixel_pitch_um"], &message));
        }
        Ok(())
    }

    /// The same optics as a description.
    pub fn spec(&self) -> OpticsSpec {
        self.perturbed_spec(1.0, 1.0, 0.0)
    }

    /// The description with its apertures `widened` times as large, its sensors `spread` times as far apart or the second aperture
    /// that much larger than the first, and the sensors `moved` away from the lens by this part of the image's span.
    pub(super) fn perturbed_spec(&self, widened: f64, spread: f64, moved: f64) -> OpticsSpec {
        let sensor = Sensor::PlaneMm(self.sensors_mm[0] + self.image_span_mm * moved);
        let [first, second] = self.apertures_mm;
        let pair = match self.range_end_mm {
            None => Pair::Focal {
                aperture: Aperture::DiameterMm(first * widened),
                near_sensor: sensor,
                plane_separation_mm: self.image_span_mm * spread,
            },
            Some(range_end_mm) => Pair::Aperture {
                apertures: [first * widened, second * widened * spread].map(Aperture::DiameterMm),
                sensor,
                range_end_mm,
            },
        };
        OpticsSpec {
            focal_length_mm: self.focal_length_mm,
            pair,
            pixel_pitch_um: self.pixel_pitch_um,
            telecentric: self.telecentric,
            principal_point_px: self.principal_point_px,
        }
    }

    /// The same with apertures that make this the largest blur.
    pub(super) fn with_largest_blur(&self, blur_px: f64) -> Optics {
        let scale = blur_px / self.largest_blur_px();
        Optics { apertures_mm: self.apertures_mm.map(|mm| mm * scale), ..*self }
    }

    /// Diameters of the first and the second picture's aperture, in mm.
    pub fn apertures_mm(&self) -> [f64; 2] {
        self.apertures_mm
    }

    /// The names of the first and the second picture.
    pub fn picture_names(&self) -> [&'static str; 2] {
        match self.range_end_mm {
            None => ["near", "far"],
            Some(_) if self.apertures_mm[0] > self.apertures_mm[1] => ["wide", "narrow"],
            Some(_) => ["narrow", "wide"],
        }
    }

    /// The near end of the working range, in mm: β = 1. The near-focused picture is focused there.
    pub fn near_focus_mm(&self) -> f64 {
        self.depth_mm(1.0)
    }

    /// The far end of the working range, in mm: β = −1. The far-focused picture is focused there.
    pub fn far_focus_mm(&self) -> f64 {
        self.depth_mm(-1.0)
    }

    /// The length of the working range, in mm.
    pub fn range_mm(&self) -> f64 {
        self.far_focus_mm() - self.near_focus_mm()
    }

    /// Size of the second image over that of the first: 1 with a telecentric stop.
    pub fn far_scale(&self) -> f64 {
        if self.telecentric { 1.0 } else { self.sensors_mm[1] / self.sensors_mm[0] }
    }

    /// Distance from the lens at which a point of this β is sharp, in mm.
    fn image_distance_mm(&self, beta: f64) -> f64 {
        self.far_image_mm + 0.5 * self.image_span_mm * (1.0 + beta)
    }

    /// Distance of a point of this β, in mm; infinite where the lens forms no image.
    pub fn depth_mm(&self, beta: f64) -> f64 {
        let (f, v) = (self.focal_length_mm, self.image_distance_mm(beta));
        if v > f { f * v / (v - f) } else { f64::INFINITY } // B(1)
    }

    /// β of a point at this distance, in mm, beyond the focal length.
    pub fn beta(&self, depth_mm: f64) -> f64 {
        let (f, u) = (self.focal_length_mm, depth_mm);
        2.0 * (f * u / (u - f) - self.far_image_mm) / self.image_span_mm - 1.0 // B(1)
    }

    /// Signed diameters of the blur circle in the first and in the second picture, in their pixels; positive where the
    /// sensor stands behind the sharp image.
    pub fn blur_diameters_px(&self, beta: f64) -> [f64; 2] {
        let v = self.image_distance_mm(beta);
        let over = if self.telecentric { self.focal_length_mm } else { v };
        std::array::from_fn(|picture| {
            self.apertures_mm[picture] * (self.sensors_mm[picture] - v)
                / over
                / (self.pixel_pitch_um / 1000.0)
        }) // B(2), B(3), with their signs
    }

    /// The same once the second picture has been enlarged to the first one's scale: its blur grows with it.
    pub fn registered_blur_px(&self, beta: f64) -> [f64; 2] {
        let [first, second] = self.blur_diameters_px(beta);
        [first, second / self.far_scale()]
    }

    /// The largest blur within the working range, in pixels.
    pub fn largest_blur_px(&self) -> f64 {
        let ends = [-1.0, 1.0].map(|beta| self.blur_diameters_px(beta));
        ends.as_flattened().iter().fold(0.0, |most, blur| blur.abs().max(most))
    }

    /// Where the optical axis meets a picture of this size.
    pub fn principal_point(&self, width: usize, height: usize) -> [f64; 2] {
        self.principal_point_px.unwrap_or([(width as f64 - 1.0) / 2.0, (height as f64 - 1.0) / 2.0])
    }

    /// The point of the scene, in mm, that the first picture shows in pixel `[x, y]` at this depth: x right,
    /// y down, z along the optical axis from the lens. `centre` is where the axis meets the picture.
    pub fn point_mm(&self, [x, y]: [f64; 2], centre: [f64; 2], depth_mm: f64) -> [f64; 3] {
        let pitch_mm = self.pixel_pitch_um / 1000.0;
        // The chief ray runs through the middle of the stop: the lens, or the front focal point.
        let magnified = match self.telecentric {
            false => depth_mm / self.sensors_mm[0],
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::depth::scene::{bench_aperture_pair, bench_optics};

    #[test]
    fn an_aperture_pair_blurs_by_the_ratio_of_its_apertures_on_one_side_of_the_focus() {
        for (range_end_mm, names) in [(540.0, ["wide", "narrow"]), (470.0, ["narrow", "wide"])] {
            let optics = bench_aperture_pair([8.0, 2.8], range_end_mm, false);
            assert_eq!(optics.picture_names(), names);
            let ends_mm = [optics.near_focus_mm(), optics.far_focus_mm()];
            assert!(ends_mm.iter().any(|end_mm| (end_mm - range_end_mm).abs() < 1e-9), "{ends_mm:?}");
            assert!(ends_mm[0] < ends_mm[1] && (ends_mm[0] > 500.0) == (range_end_mm > 500.0), "{ends_mm:?}");
            let wide = usize::from(names[1] == "wide");
            for beta in [-1.0, -0.2, 0.7, 1.3] {
                let blur_px = optics.blur_diameters_px(beta);
                assert!((blur_px[wide] / blur_px[1 - wide] - 8.0 / 2.8).abs() < 1e-9, "{blur_px:?}");
                assert_eq!(blur_px[0] > 0.0, range_end_mm > 500.0, "candidates stay on their side");
            }
            // The first picture's blur falls against the other's as β rises.
            let excess = |beta: f64| {
                let [first, second] = optics.blur_diameters_px(beta);
                first * first - second * second
            };
            assert!(excess(-1.0) > excess(0.0) && excess(0.0) > excess(1.0));
        }
    }

    #[test]
    fn a_description_comes_back() {
        for optics in [bench_optics(8.0, false), bench_aperture_pair([2.8, 8.0], 470.0, true)] {
            assert_eq!(Optics::new(&optics.spec()), Ok(optics));
        }
    }

    #[test]
    fn what_makes_no_aperture_pair_is_refused_by_its_field() {
        let with = |f_numbers: [f64; 2], range_end_mm: f64| {
            let pair = Pair::Aperture {
                apertures: f_numbers.map(Aperture::FNumber),
                sensor: Sensor::FocusMm(500.0),
                range_end_mm,
            };
            let optics = Optics::new(&OpticsSpec { pair, ..bench_optics(8.0, false).spec() });
            optics.map(drop).map_err(|faults| faults[0].field)
        };
        assert_eq!(with([2.8, 8.0], 540.0), Ok(()));
        assert_eq!(with([2.8, 3.0], 540.0), Err("f_numbers"), "alike");
        assert_eq!(with([2.8, 8.0], 500.0), Err("range_end_mm"), "no side");
        assert_eq!(with([2.8, 8.0], 30.0), Err("range_end_mm"), "within the focal length");
        assert_eq!(with([2.8, 8.0], 501.0), Err("range_end_mm"), "too little blur");
    }
}
