//! A rigid motion: a rotation, then a translation.

use glam::{DMat3, DQuat, DVec3};

/// `T_a_b`: takes a point of frame b to frame a.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidTransform {
    /// Of unit length.
    pub rotation: DQuat,
    /// Where the origin of frame b lies in frame a, metres.
    pub translation_m: DVec3,
}

impl RigidTransform {
    /// No motion.
    pub const IDENTITY: RigidTransform =
        RigidTransform { rotation: DQuat::IDENTITY, translation_m: DVec3::ZERO };

    /// From a rotation matrix and a translation.
    pub fn new(rotation: DMat3, translation_m: DVec3) -> RigidTransform {
        RigidTransform { rotation: DQuat::from_mat3(&rotation).normalize(), translation_m }
    }

    /// Where a point of frame b lies in frame a.
    pub fn apply(&self, point: DVec3) -> DVec3 {
        self.rotation * point + self.translation_m
    }

    /// `T_b_a`.
    pub fn inverse(&self) -> RigidTransform {
        let rotation = self.rotation.conjugate();
        RigidTransform { rotation, translation_m: -(rotation * self.translation_m) }
    }

    /// `T_a_c` of this `T_a_b` and `T_b_c`.
    pub fn then(&self, next: &RigidTransform) -> RigidTransform {
        RigidTransform {
            rotation: (self.rotation * next.rotation).normalize(),
            translation_m: self.apply(next.translation_m),
        }
    }

    /// By how much the rotations of two motions differ, radians in 0..=π.
    pub fn angle_to_rad(&self, other: &RigidTransform) -> f64 {
        self.rotation.angle_between(other.rotation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_motion_and_its_inverse_are_none() {
        let motion = RigidTransform::new(
            DMat3::from_rotation_z(0.7) * DMat3::from_rotation_x(-1.1),
            DVec3::new(1.0, -2.0, 0.5),
        );
        let none = motion.then(&motion.inverse());
        assert!(none.translation_m.length() < 1e-12 && none.angle_to_rad(&RigidTransform::IDENTITY) < 1e-7);
        let point = DVec3::new(0.3, 4.0, -1.0);
        assert!((motion.inverse().apply(motion.apply(point)) - point).length() < 1e-12);
    }
}
