//! Where something stands in a map, in the numbers that people and navigation stacks write.

use glam::{DMat3, DQuat, DVec3};

use super::RigidTransform;

/// The pose of a body frame (x forward, y left, z up) in a map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MapPose {
    /// Metres along the map's x axis.
    pub x_m: f64,
    /// Metres along the map's y axis.
    pub y_m: f64,
    /// Metres above the map's plane.
    pub z_m: f64,
    /// Heading, counter-clockwise from the map's x axis.
    pub yaw_deg: f64,
    /// Positive when it looks down.
    pub pitch_deg: f64,
    /// Positive when its left side rises.
    pub roll_deg: f64,
}

impl MapPose {
    /// `T_map_body`: rotations about z, then the turned y, then the turned x (ROS' `rpy`).
    pub fn transform(&self) -> RigidTransform {
        let [yaw, pitch, roll] = [self.yaw_deg, self.pitch_deg, self.roll_deg].map(f64::to_radians);
        RigidTransform {
            rotation: DQuat::from_rotation_z(yaw)
                * DQuat::from_rotation_y(pitch)
                * DQuat::from_rotation_x(roll),
            translation_m: DVec3::new(self.x_m, self.y_m, self.z_m),
        }
    }

    /// `T_map_optical` of a camera that looks along the body's x axis.
    pub fn optical(&self) -> RigidTransform {
        self.transform().then(&optical_in_body())
    }

    /// The pose of `T_map_body`. Headings and rolls are in (−180, 180], pitches in [−90, 90].
    pub fn of(transform: &RigidTransform) -> MapPose {
        let m = DMat3::from_quat(transform.rotation);
        let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
        MapPose {
            x_m: transform.translation_m.x,
            y_m: transform.translation_m.y,
            z_m: transform.translation_m.z,
            yaw_deg: x.y.atan2(x.x).to_degrees(),
            pitch_deg: (-x.z).clamp(-1.0, 1.0).asin().to_degrees(),
            roll_deg: y.z.atan2(z.z).to_degrees(),
        }
    }

    /// The pose of the body of a camera whose `T_map_optical` is given.
    pub fn of_optical(optical: &RigidTransform) -> MapPose {
        MapPose::of(&optical.then(&optical_in_body().inverse()))
    }
}

/// `T_body_optical`: the optical frame of a camera that looks along the body's x axis (REP 103).
pub fn optical_in_body() -> RigidTransform {
    // right is −y, down is −z, forward is x
    RigidTransform::new(DMat3::from_cols(-DVec3::Y, -DVec3::Z, DVec3::X), DVec3::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_survives_its_transform() {
        for (yaw_deg, pitch_deg, roll_deg) in
            [(0.0, 0.0, 0.0), (170.0, -20.0, 5.0), (-95.0, 45.0, -170.0), (180.0, 0.0, 0.0)]
        {
            let pose = MapPose { x_m: 1.0, y_m: -2.0, z_m: 0.4, yaw_deg, pitch_deg, roll_deg };
            for back in [MapPose::of(&pose.transform()), MapPose::of_optical(&pose.optical())] {
                let off = [back.yaw_deg - yaw_deg, back.pitch_deg - pitch_deg, back.roll_deg - roll_deg];
                let off = off.map(|off| (off + 180.0).rem_euclid(360.0) - 180.0);
                assert!(off.iter().all(|off| off.abs() < 1e-6), "{pose:?} {back:?}");
                assert!((back.x_m - 1.0).abs() < 1e-12 && (back.z_m - 0.4).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_camera_that_heads_along_x_sees_what_is_left_of_it_on_the_left() {
        let pose = MapPose { yaw_deg: 0.0, ..MapPose::default() };
        let seen = pose.optical().inverse().apply(DVec3::new(2.0, 0.5, 0.1));
        assert!((seen - DVec3::new(-0.5, -0.1, 2.0)).length() < 1e-12, "{seen}");
        let down = MapPose { pitch_deg: 30.0, ..MapPose::default() };
        assert!(down.optical().apply(DVec3::Z).z < 0.0, "a positive pitch looks down");
        let turned = MapPose { yaw_deg: 90.0, ..MapPose::default() };
        assert!((turned.optical().apply(DVec3::Z) - DVec3::Y).length() < 1e-12);
    }
}
