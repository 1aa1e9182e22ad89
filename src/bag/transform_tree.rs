//! Which frame stands where in which, over time: what ROS calls tf.
//!
//! Every frame but the roots has one parent and samples of `T_parent_child`; one sample that always holds, or several
//! between which it is interpolated, linearly and by slerp. Times are nanoseconds of the messages' own stamps.

use std::collections::HashMap;

use landmarkd_core::geometry::RigidTransform;

/// Longer chains are loops.
const LONGEST_CHAIN: usize = 64;

/// A tree of frames.
#[derive(Debug)]
pub struct TransformTree {
    edges: HashMap<String, Edge>,
    /// Samples farther apart than this are not interpolated between.
    longest_gap_ns: i64,
}

#[derive(Debug)]
struct Edge {
    parent: String,
    motion: Motion,
}

#[derive(Debug)]
enum Motion {
    Static(RigidTransform),
    /// By time, after [`TransformTree::sort`].
    Samples(Vec<(i64, RigidTransform)>),
}

/// Why there is no transform between two frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoTransform {
    /// Nothing links the frames, at any time.
    NotLinked,
    /// They are linked, but no two samples around the moment are near enough to each other.
    NotThen,
}

impl TransformTree {
    /// Without frames.
    pub fn new(longest_gap_ns: i64) -> TransformTree {
        TransformTree { edges: HashMap::new(), longest_gap_ns }
    }

    /// `T_parent_child` that always holds; takes the place of what was known of the child.
    pub fn fix(&mut self, parent: &str, child: &str, transform: RigidTransform) {
        let edge = Edge { parent: parent.to_owned(), motion: Motion::Static(transform) };
        self.edges.insert(child.to_owned(), edge);
    }

    /// `T_parent_child` at a moment. A new parent, or a fixed transform before, is forgotten.
    pub fn add(&mut self, parent: &str, child: &str, stamp_ns: i64, transform: RigidTransform) {
        match self.edges.get_mut(child) {
            Some(Edge { parent: known, motion: Motion::Samples(samples) }) if known == parent => {
                samples.push((stamp_ns, transform));
            }
            _ => {
                let motion = Motion::Samples(vec![(stamp_ns, transform)]);
                self.edges.insert(child.to_owned(), Edge { parent: parent.to_owned(), motion });
            }
        }
    }

    /// Takes out what is known of a frame in its parent.
    pub fn cut(&mut self, child: &str) {
        self.edges.remove(child);
    }

    /// Brings all samples into the order of time; returns how many came after a later one.
    pub fn sort(&mut self) -> usize {
        let mut late = 0;
        for edge in self.edges.values_mut() {
            if let Motion::Samples(samples) = &mut edge.motion {
                let mut latest = i64::MIN;
                for (stamp_ns, _) in samples.iter() {
                    late += usize::from(*stamp_ns < latest);
                    latest = latest.max(*stamp_ns);
                }
                samples.sort_by_key(|(stamp_ns, _)| *stamp_ns);
            }
        }
        late
    }

    /// The frames from this one to its root, itself first.
    fn chain<'a>(&'a self, frame: &'a str) -> Vec<&'a str> {
        let parent = |child: &&'a str| self.edges.get(*child).map(|edge| edge.parent.as_str());
        std::iter::successors(Some(frame), parent).take(LONGEST_CHAIN).collect()
    }

    /// The last of the frames above this one that fixed transforms alone lead to; the frame itself, if there is none.
    pub fn fixed_root<'a>(&'a self, frame: &'a str) -> &'a str {
        let parent = |child: &&'a str| match self.edges.get(*child) {
            Some(Edge { parent, motion: Motion::Static(_) }) => Some(parent.as_str()),
            _ => None,
        };
        std::iter::successors(Some(frame), parent).take(LONGEST_CHAIN).last().unwrap_or(frame)
    }

    /// Whether one frame stands above another, or is it.
    pub fn is_above(&self, above: &str, frame: &str) -> bool {
        self.chain(frame).contains(&above)
    }

    /// `T_to_from` at a moment.
    ///
    /// # Errors
    /// [`NoTransform`].
    pub fn lookup(&self, to: &str, from: &str, stamp_ns: i64) -> Result<RigidTransform, NoTransform> {
        let (to_chain, from_chain) = (self.chain(to), self.chain(from));
        let common =
            from_chain.iter().find(|frame| to_chain.contains(frame)).ok_or(NoTransform::NotLinked)?;
        let below = |chain: &[&str]| {
            let mut transform = RigidTransform::IDENTITY;
            for frame in chain.iter().take_while(|frame| *frame != common) {
                transform = self.in_parent(frame, stamp_ns)?.then(&transform);
            }
            Ok(transform)
        };
        Ok(below(&to_chain)?.inverse().then(&below(&from_chain)?))
    }

    fn in_parent(&self, child: &str, stamp_ns: i64) -> Result<RigidTransform, NoTransform> {
        let samples = match &self.edges.get(child).ok_or(NoTransform::NotLinked)?.motion {
            Motion::Static(transform) => return Ok(*transform),
            Motion::Samples(samples) => samples,
        };
        let after = samples.partition_point(|(at_ns, _)| *at_ns < stamp_ns);
        let (next_ns, next) = samples.get(after).ok_or(NoTransform::NotThen)?;
        if *next_ns == stamp_ns {
            return Ok(*next);
        }
        let (last_ns, last) = after.checked_sub(1).map(|at| &samples[at]).ok_or(NoTransform::NotThen)?;
        let gap_ns = next_ns.saturating_sub(*last_ns);
        if gap_ns > self.longest_gap_ns {
            return Err(NoTransform::NotThen);
        }
        let part = (stamp_ns - last_ns) as f64 / gap_ns as f64;
        Ok(RigidTransform {
            rotation: last.rotation.slerp(next.rotation, part),
            translation_m: last.translation_m.lerp(next.translation_m, part),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use landmarkd_core::geometry::MapPose;

    const SECOND: i64 = 1_000_000_000;

    fn at(x_m: f64, y_m: f64, yaw_deg: f64) -> RigidTransform {
        MapPose { x_m, y_m, yaw_deg, ..MapPose::default() }.transform()
    }

    /// map → odom → base → camera; odom's samples come late one first.
    fn tree() -> TransformTree {
        let mut tree = TransformTree::new(SECOND);
        tree.add("map", "odom", 2 * SECOND, at(1.0, 0.0, 90.0));
        tree.add("map", "odom", SECOND, at(1.0, 0.0, 90.0));
        tree.add("odom", "base", SECOND, at(0.0, 0.0, 170.0));
        tree.add("odom", "base", 2 * SECOND, at(2.0, 0.0, -170.0));
        tree.add("odom", "base", 9 * SECOND, at(2.0, 0.0, -170.0));
        tree.fix("base", "camera", at(0.5, 0.0, 0.0));
        assert_eq!(tree.sort(), 1);
        tree
    }

    #[test]
    fn a_pose_between_two_samples_is_on_the_short_way_between_them() {
        let camera = MapPose::of(&tree().lookup("map", "camera", SECOND + SECOND / 2).unwrap());
        // in odom the base is at x 1, heading 180°, so the camera is at x 0.5; odom is turned by 90° about (1, 0)
        assert!((camera.x_m - 1.0).abs() < 1e-9 && (camera.y_m - 0.5).abs() < 1e-9, "{camera:?}");
        assert!((camera.yaw_deg + 90.0).abs() < 1e-9, "{camera:?}");
        let back = tree().lookup("camera", "map", SECOND + SECOND / 2).unwrap();
        assert!(back.then(&camera.transform()).translation_m.length() < 1e-9);
    }

    #[test]
    fn outside_of_the_samples_and_in_long_gaps_there_is_none() {
        let tree = tree();
        for stamp_ns in [0, SECOND - 1, 3 * SECOND, 10 * SECOND] {
            assert_eq!(tree.lookup("odom", "base", stamp_ns), Err(NoTransform::NotThen), "{stamp_ns}");
        }
        assert!(tree.lookup("odom", "base", 9 * SECOND).is_ok(), "a sample of that very moment");
        assert_eq!(tree.lookup("map", "kitchen", SECOND), Err(NoTransform::NotLinked));
        assert_eq!((tree.fixed_root("camera"), tree.fixed_root("base")), ("base", "base"));
        assert!(tree.is_above("odom", "camera") && !tree.is_above("camera", "odom"));
    }

    #[test]
    fn a_loop_of_frames_ends() {
        let mut tree = TransformTree::new(SECOND);
        tree.fix("a", "b", at(1.0, 0.0, 0.0));
        tree.fix("b", "a", at(1.0, 0.0, 0.0));
        assert_eq!(tree.lookup("map", "a", 0), Err(NoTransform::NotLinked));
        assert!(tree.lookup("a", "b", 0).is_ok());
    }
}
