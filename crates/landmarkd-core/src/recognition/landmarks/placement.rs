//! Where an exemplar lies in a frame: a similarity of the exemplar's picture onto the frame.

/// A similarity: maps the offset d from the centre of the exemplar's picture to (x, y) + scale · R · d in the frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Column of the centre of the exemplar's picture in the frame.
    pub x_px: f32,
    /// Row of the centre of the exemplar's picture in the frame.
    pub y_px: f32,
    /// From x towards y, in (−π, π].
    pub rotation_rad: f32,
    /// Frame pixels per exemplar pixel.
    pub scale: f32,
}

/// A point of an exemplar and its position in the frame, with a weight.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointPair {
    /// Offset from the exemplar's centre.
    pub exemplar: [f32; 2],
    /// Position in the frame.
    pub frame: [f32; 2],
    pub weight: f32,
}

impl Placement {
    /// The position in the frame of an offset from the exemplar's centre.
    pub fn apply(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        let (sin, cos) = self.rotation_rad.sin_cos();
        [self.x_px + self.scale * (cos * x - sin * y), self.y_px + self.scale * (sin * x + cos * y)]
    }

    /// The corners of an exemplar's picture, from its top left clockwise on the screen when it isn't turned.
    pub fn outline_px(&self, width_px: u32, height_px: u32) -> [[f32; 2]; 4] {
        let (x, y) = (width_px as f32 / 2.0, height_px as f32 / 2.0);
        [[-x, -y], [x, -y], [x, y], [-x, y]].map(|corner| self.apply(corner))
    }

    /// The weighted least-squares similarity of the pairs; `None` if their points coincide. A given `scale` is kept.
    pub(super) fn fit(pairs: &[PointPair], scale: Option<f32>) -> Option<Placement> {
        let mut total = 0.0_f64;
        let (mut from, mut to) = ([0.0_f64; 2], [0.0_f64; 2]);
        for pair in pairs {
            let weight = f64::from(pair.weight);
            total += weight;
            for axis in 0..2 {
                from[axis] += weight * f64::from(pair.exemplar[axis]);
                to[axis] += weight * f64::from(pair.frame[axis]);
            }
        }
        if total <= 0.0 {
            return None;
        }
        let (from, to) = (from.map(|v| v / total), to.map(|v| v / total));
        let (mut along, mut across, mut variance) = (0.0, 0.0, 0.0);
        for pair in pairs {
            let weight = f64::from(pair.weight);
            let (x, y) = (f64::from(pair.exemplar[0]) - from[0], f64::from(pair.exemplar[1]) - from[1]);
            let (u, v) = (f64::from(pair.frame[0]) - to[0], f64::from(pair.frame[1]) - to[1]);
            along += weight * (x * u + y * v);
            across += weight * (x * v - y * u);
            variance += weight * (x * x + y * y);
        }
        let length = (along * along + across * across).sqrt();
        if variance <= 1e-9 || length <= 1e-9 {
            return None;
        }
        let (cos, sin) = (along / length, across / length);
        let scale = scale.map_or(length / variance, f64::from);
        Some(Placement {
            x_px: (to[0] - scale * (cos * from[0] - sin * from[1])) as f32,
            y_px: (to[1] - scale * (sin * from[0] + cos * from[1])) as f32,
            rotation_rad: sin.atan2(cos) as f32,
            scale: scale as f32,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_similarity_is_found_again_from_its_pairs() {
        let truth = Placement { x_px: 130.0, y_px: 70.0, rotation_rad: 2.4, scale: 1.3 };
        let corners = [[-20.0, -10.0], [15.0, -12.0], [3.0, 25.0], [40.0, 0.0]];
        let pairs = corners.map(|exemplar| PointPair { exemplar, frame: truth.apply(exemplar), weight: 0.3 });
        for scale in [None, Some(1.3)] {
            let fit = Placement::fit(&pairs, scale).unwrap();
            assert!((fit.x_px - truth.x_px).abs() < 1e-3 && (fit.y_px - truth.y_px).abs() < 1e-3, "{fit:?}");
            assert!((fit.rotation_rad - 2.4).abs() < 1e-5 && (fit.scale - 1.3).abs() < 1e-5, "{fit:?}");
        }
        assert_eq!(Placement::fit(&[pairs[0], pairs[0]], None), None);
        assert_eq!(Placement::fit(&[], None), None);
    }

    #[test]
    fn a_rotation_turns_x_towards_y() {
        let quarter =
            Placement { x_px: 10.0, y_px: 20.0, rotation_rad: std::f32::consts::FRAC_PI_2, scale: 2.0 };
        let [x, y] = quarter.apply([1.0, 0.0]);
        assert!((x - 10.0).abs() < 1e-5 && (y - 22.0).abs() < 1e-5);
        let outline = Placement { rotation_rad: 0.0, scale: 1.0, ..quarter }.outline_px(8, 4);
        assert_eq!(outline, [[6.0, 18.0], [14.0, 18.0], [14.0, 22.0], [6.0, 22.0]]);
    }
}
