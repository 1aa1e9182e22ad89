//! Which matches agree on where an exemplar lies. Each match of a window with a trained one says where the
//! centre of that exemplar's picture would be, how the picture is turned, and at which scale; background matches
//! scatter, those of an object that is really there meet in one place.

use pulp::{Arch, Simd, WithSimd};

use super::placement::{Pair, Placement};

/// Matches agree within such distances: of the centre, of the turn, of the logarithm of the scale.
const CENTRE_WIDTH_PX: f32 = 6.0;
const TURN_WIDTH_RAD: f32 = 12.0 * std::f32::consts::PI / 180.0;
const SCALE_WIDTH: f32 = 0.12;
/// Beyond this many widths, squared, matches don't count for each other.
const REACH: f32 = 6.25;
/// Of one exemplar's matches the heaviest so many are looked at.
const MOST_MATCHES: usize = 512;
/// Places where one exemplar is looked for.
const MOST_INSTANCES: usize = 6;
/// Matches that make a hypothesis at least.
const LEAST_MEMBERS: usize = 2;

/// A window of the frame that looks like one of an exemplar.
#[derive(Clone, Copy, Debug)]
pub(super) struct Match {
    /// Index of the frame's window.
    pub query: u32,
    /// D.
    pub distance: f32,
    pub exemplar: u32,
    /// Where the centre of the exemplar's picture would be, and how it would be turned and scaled.
    pub placement: Placement,
    /// Offset of the trained window from the exemplar's centre.
    pub from: [f32; 2],
    /// Place of the frame's window.
    pub to: [f32; 2],
    pub weight: f32,
}

/// Where an exemplar may lie.
#[derive(Clone, Debug)]
pub(super) struct Hypothesis {
    pub exemplar: usize,
    pub placement: Placement,
    /// Density of the agreeing matches: the sum of the members' weights.
    pub density: f32,
    /// Index of each agreeing match, and what it adds.
    pub members: Vec<(u32, f32)>,
}

/// Where exemplars may lie, by the matches sorted by exemplar; densest first.
pub(super) fn hypotheses(matches: &[Match]) -> Vec<Hypothesis> {
    let mut found = Vec::new();
    let mut first = 0;
    let mut cloud = Cloud::default();
    for group in matches.chunk_by(|a, b| a.exemplar == b.exemplar) {
        if group.len() >= LEAST_MEMBERS {
            cloud.fill(group, first);
            cloud.modes(group, first, &mut found);
        }
        first += group.len();
    }
    found.sort_by(|a: &Hypothesis, b: &Hypothesis| {
        b.density.total_cmp(&a.density).then(a.exemplar.cmp(&b.exemplar))
    });
    found
}

/// Matches whose kernels are computed together.
const LANES: usize = 16;

/// The predictions of one exemplar's matches in units of the widths, coordinate by coordinate.
#[derive(Default)]
struct Cloud {
    members: Vec<u32>,
    /// Of every member, and then zeros up to a multiple of [`LANES`], as in all that follow.
    coordinates: [Vec<f32>; 5],
    /// 0 for what was taken away.
    weight: Vec<f32>,
    density: Vec<f32>,
    /// About one match.
    kernel: Vec<f32>,
}

impl Cloud {
    fn fill(&mut self, group: &[Match], first: usize) {
        self.members.clear();
        self.members.extend((0..group.len() as u32).map(|i| first as u32 + i));
        let weight = |member: &u32| group[*member as usize - first].weight;
        if self.members.len() > MOST_MATCHES {
            self.members.sort_by(|a, b| weight(b).total_cmp(&weight(a)));
            self.members.truncate(MOST_MATCHES);
        }
        self.coordinates.iter_mut().for_each(Vec::clear);
        self.weight.clear();
        for member in &self.members {
            let Match { placement, weight, .. } = group[*member as usize - first];
            let (sin, cos) = placement.rotation_rad.sin_cos();
            let at = [
                placement.x_px / CENTRE_WIDTH_PX,
                placement.y_px / CENTRE_WIDTH_PX,
                cos / TURN_WIDTH_RAD,
                sin / TURN_WIDTH_RAD,
                placement.scale.ln() / SCALE_WIDTH,
            ];
            self.coordinates.iter_mut().zip(at).for_each(|(all, value)| all.push(value));
            self.weight.push(weight);
        }
        let padded = self.members.len().next_multiple_of(LANES);
        self.coordinates.iter_mut().for_each(|all| all.resize(padded, 0.0));
        self.weight.resize(padded, 0.0);
        self.kernel.resize(padded, 0.0);
        self.density.clear();
        for i in 0..self.members.len() {
            let density = self.kernel_about(i);
            self.density.push(density);
        }
    }

    /// The kernel of every match about match i, and the density there.
    fn kernel_about(&mut self, i: usize) -> f32 {
        let about = [0, 1, 2, 3, 4].map(|axis| self.coordinates[axis][i]);
        let coordinates = self.coordinates.each_ref().map(|all| all.as_chunks().0);
        let (weight, out) = (self.weight.as_chunks().0, self.kernel.as_chunks_mut().0);
        Arch::new().dispatch(Kernel { about, coordinates, weight, out })
    }

    fn modes(&mut self, group: &[Match], first: usize, found: &mut Vec<Hypothesis>) {
        for _ in 0..MOST_INSTANCES {
            let Some(top) =
                (0..self.density.len()).max_by(|&a, &b| self.density[a].total_cmp(&self.density[b]))
            else {
                return;
            };
            self.kernel_about(top);
            let added = |i: usize| self.kernel[i] * self.weight[i];
            let agree: Vec<usize> = (0..self.members.len()).filter(|&i| added(i) > 0.0).collect();
            let members = agree.iter().map(|&i| (self.members[i], added(i))).collect();
            let members = once_a_window(members, group, first);
            if members.len() < LEAST_MEMBERS {
                return;
            }
            let centre = group[self.members[top] as usize - first].placement;
            found.push(Hypothesis {
                exemplar: group[0].exemplar as usize,
                placement: agreed(&members, group, first, centre),
                density: members.iter().map(|(_, k)| k).sum(),
                members,
            });
            // what agreed is taken away
            for &i in &agree {
                self.kernel_about(i);
                for (density, kernel) in self.density.iter_mut().zip(&self.kernel) {
                    *density -= kernel * self.weight[i];
                }
                self.density[i] = f32::NEG_INFINITY;
            }
            agree.iter().for_each(|&i| self.weight[i] = 0.0);
        }
    }
}

/// The matches that agree, in their order: of those of one window of the frame the one that adds most.
fn once_a_window(mut agree: Vec<(u32, f32)>, group: &[Match], first: usize) -> Vec<(u32, f32)> {
    let query = |member: u32| group[member as usize - first].query;
    agree.sort_by(|a, b| query(a.0).cmp(&query(b.0)).then(b.1.total_cmp(&a.1)));
    agree.dedup_by_key(|(member, _)| query(*member));
    agree.sort_by_key(|(member, _)| *member);
    agree
}

/// The similarity that the members agree on: by their positions, or where these are all in one place by the mean of
/// their predictions.
fn agreed(members: &[(u32, f32)], group: &[Match], first: usize, about: Placement) -> Placement {
    let of = |member: u32| &group[member as usize - first];
    let pairs: Vec<Pair> =
        members.iter().map(|&(m, weight)| Pair { exemplar: of(m).from, frame: of(m).to, weight }).collect();
    let (mut sum, mut logarithm) = (0.0, 0.0);
    let mut mean = [0.0_f32; 4];
    for &(m, weight) in members {
        let placement = of(m).placement;
        let (sin, cos) = placement.rotation_rad.sin_cos();
        sum += weight;
        logarithm += weight * placement.scale.ln();
        for (mean, value) in mean.iter_mut().zip([placement.x_px, placement.y_px, cos, sin]) {
            *mean += weight * value;
        }
    }
    let scale = (logarithm / sum).exp();
    let plain =
        Placement { x_px: mean[0] / sum, y_px: mean[1] / sum, rotation_rad: mean[3].atan2(mean[2]), scale };
    let near = |fit: &Placement| {
        let turned = (fit.rotation_rad - plain.rotation_rad).rem_euclid(std::f32::consts::TAU);
        turned.min(std::f32::consts::TAU - turned) < 2.0 * TURN_WIDTH_RAD
            && (fit.x_px - about.x_px).hypot(fit.y_px - about.y_px) < 2.0 * CENTRE_WIDTH_PX
    };
    Placement::fitted(&pairs, Some(scale)).filter(|fit| members.len() >= 3 && near(fit)).unwrap_or(plain)
}

struct Kernel<'a> {
    about: [f32; 5],
    coordinates: [&'a [[f32; LANES]]; 5],
    weight: &'a [[f32; LANES]],
    out: &'a mut [[f32; LANES]],
}

impl WithSimd for Kernel<'_> {
    type Output = f32;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> f32 {
        let [x0, y0, cos0, sin0, scale0] = self.about;
        let mut density = [0.0; LANES];
        for chunk in 0..self.out.len() {
            let [x, y, cos, sin, scale] = self.coordinates;
            let (x, y, cos, sin, scale) = (&x[chunk], &y[chunk], &cos[chunk], &sin[chunk], &scale[chunk]);
            let (weight, out) = (&self.weight[chunk], &mut self.out[chunk]);
            for i in 0..LANES {
                let (dx, dy, dc, ds, dl) =
                    (x[i] - x0, y[i] - y0, cos[i] - cos0, sin[i] - sin0, scale[i] - scale0);
                let left = 1.0 - (dx * dx + dy * dy + dc * dc + ds * ds + dl * dl) * (1.0 / REACH);
                let left = if left > 0.0 { left } else { 0.0 };
                out[i] = left * left;
                density[i] += out[i] * weight[i];
            }
        }
        let mut sum = 0.0;
        for lane in density {
            sum += lane;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(exemplar: u32, x_px: f32, degrees: f32, from: [f32; 2], weight: f32) -> Match {
        let placement = Placement { x_px, y_px: 80.0, rotation_rad: degrees.to_radians(), scale: 1.0 };
        let query = (from[0] * 100.0 + from[1] + x_px * 7.0) as i32 as u32;
        Match { query, distance: 0.0, exemplar, placement, from, to: placement.apply(from), weight }
    }

    #[test]
    fn matches_that_agree_outweigh_more_that_do_not() {
        let mut matches: Vec<Match> =
            (0..30).map(|i| said(0, 10.0 + 37.0 * i as f32, 53.0 * i as f32, [5.0, 0.0], 0.2)).collect();
        let corners = [[-20.0, -10.0], [15.0, -12.0], [3.0, 25.0], [-9.0, 14.0]];
        matches.extend(corners.map(|from| said(1, 100.0, 40.0, from, 0.1)));
        let found = hypotheses(&matches);
        assert_eq!(found[0].exemplar, 1);
        assert_eq!(found[0].members.len(), 4);
        let placement = found[0].placement;
        assert!(
            (placement.x_px - 100.0).abs() < 1e-3 && (placement.y_px - 80.0).abs() < 1e-3,
            "{placement:?}"
        );
        assert!((placement.rotation_rad.to_degrees() - 40.0).abs() < 1e-2);
        assert!((found[0].density - 0.4).abs() < 1e-6);
    }

    #[test]
    fn one_exemplar_may_lie_in_several_places_and_no_match_counts_twice() {
        let corners = [[-20.0, -10.0], [15.0, -12.0], [3.0, 25.0]];
        let places = [(40.0, 0.0), (140.0, 90.0), (240.0, -170.0)];
        let matches: Vec<Match> = places
            .iter()
            .flat_map(|&(x, degrees)| corners.map(|from| said(0, x, degrees, from, 0.1)))
            .collect();
        let found = hypotheses(&matches);
        let mut at: Vec<f32> = found.iter().map(|hypothesis| hypothesis.placement.x_px.round()).collect();
        at.sort_by(f32::total_cmp);
        assert_eq!(at, [40.0, 140.0, 240.0]);
        let mut members: Vec<u32> = found.iter().flat_map(|h| h.members.iter().map(|(m, _)| *m)).collect();
        members.sort_unstable();
        assert_eq!(members, (0..9).collect::<Vec<u32>>());
    }

    #[test]
    fn turns_agree_across_half_a_turn() {
        let matches = [said(0, 50.0, 178.0, [20.0, 0.0], 0.1), said(0, 50.0, -178.0, [-20.0, 3.0], 0.1)];
        let found = hypotheses(&matches);
        assert_eq!(found[0].members.len(), 2);
        assert!(found[0].placement.rotation_rad.to_degrees().abs() > 176.0);
    }

    #[test]
    fn a_single_match_is_no_hypothesis() {
        assert!(hypotheses(&[said(0, 50.0, 0.0, [1.0, 1.0], 1.0)]).is_empty());
        assert!(hypotheses(&[]).is_empty());
    }

    #[test]
    fn a_window_that_resembles_two_trained_ones_counts_once() {
        let mut twice = [said(0, 50.0, 0.0, [10.0, 4.0], 0.1), said(0, 51.0, 2.0, [12.0, 4.0], 0.1)];
        twice[1].query = twice[0].query;
        assert!(hypotheses(&twice).is_empty());
        let third = said(0, 50.0, 1.0, [-20.0, 9.0], 0.1);
        assert_eq!(hypotheses(&[twice[0], twice[1], third])[0].members.len(), 2);
    }
}
